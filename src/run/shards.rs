//! A run in shards: laid out once, worked on by any number of processes, merged in the end.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use super::attributes::Ranged;
use super::make::merge as make_merged;
use super::prepare::{Purpose, Run};
use super::report::{Needs, Report, SCHEMA};
use super::resume::Kept;
use super::{Request, RunError, Warned};
use crate::base::control::Control;
use crate::base::warning::Warnings;
use crate::field::Field;
use crate::job::shards::{MissingTiles, Shard, Share, first_trial, make_share, merge as merge_chunks, rounds};
use crate::job::update::{TakenOver, take_over};
use crate::job::work_dir::{PlannedCommand, WorkDir, WorkDirError};
use crate::job::{Error, Job, Mesh, Params, Pass, PassName, Store, passes, rules};

/// A run that has been laid out for shards.
#[derive(Debug, Clone, Serialize)]
pub struct Layout {
    /// See [`SCHEMA`].
    pub schema: u32,
    /// The work dir.
    pub work_dir: String,
    /// The passes, in their order: each needs all of the one before.
    pub passes: Vec<PassLayout>,
    /// Where a tolerance is looked for: at which one the passes are made first. Whoever merges tells whether they have to be made at
    /// another one.
    pub tolerance: Option<f64>,
    /// What was taken over of an earlier run; null where none was named.
    pub taken_over: Option<TakenOver>,
    /// What the whole run will need: disk in all, memory for each process.
    pub needs: Needs,
}

/// A pass of a run that has been laid out.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PassLayout {
    /// Its number, from 1.
    pub pass: usize,
    /// What it does.
    pub name: &'static str,
    /// Its tiles, across and down.
    pub columns: usize,
    /// See `columns`.
    pub rows: usize,
}

/// What a process has done of its shard.
#[derive(Debug, Clone, Serialize)]
pub struct ShardReport {
    /// See [`SCHEMA`].
    pub schema: u32,
    /// The work dir.
    pub work_dir: String,
    /// The shard, as "3/64".
    pub shard: String,
    /// Where a tolerance is looked for: the one of these tiles.
    pub tolerance: Option<f64>,
    /// What became of its tiles, by pass.
    pub passes: Vec<PassShare>,
    /// Wall clock.
    pub seconds: f64,
    /// What the user should know of the inputs.
    pub warnings: Warnings,
}

/// What became of a shard's tiles in a pass.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PassShare {
    /// The pass, from 1. Those with short links come after all others.
    pub pass: usize,
    /// Its tiles.
    #[serde(flatten)]
    pub share: Share,
}

impl ShardReport {
    /// How many tiles wait for others.
    pub fn waiting(&self) -> u64 {
        self.passes.iter().map(|pass| pass.share.waiting).sum()
    }
}

/// What a pass does, in a word.
fn name(pass: PassName) -> &'static str {
    match pass {
        PassName::Tiles => "tiles",
        PassName::Seams => "seams",
        PassName::Across => "crossings across",
        PassName::Down => "crossings down",
    }
}

/// Lays a run out in [`Request::work_dir`]: finds out what it will need, and writes what [`work`] and [`merge`] go by.
/// [`Request::output`] gives the format alone. Laid out again, it keeps the tiles that are there. `words` are those of the command
/// that asks for it, after the program's name, with names of files relative to the current folder: other processes follow them.
///
/// `earlier` is the work dir of an earlier run with the same parameters, when the raster had other samples in places, or lines were others:
/// tiles are taken over from it that no change concerns ([`crate::job::update`]). That reads all samples, once for each pass.
///
/// Under a goal that a tolerance is looked for a few tiles are tried, so that the first run is made near it.
///
/// # Errors
/// [`RunError`]; a goal that insertion stops at is refused ([`rules::check_shards`]), and so is a request without a work dir.
pub fn lay_out(
    request: &Request<'_>,
    words: Vec<String>,
    earlier: Option<&Path>,
    control: &Control<'_>,
) -> Result<Layout, RunError> {
    let dir = check(request)?;
    let warned = Warned::new(control);
    let run = Run::prepare(request, Purpose::Share, &warned, control)?;
    let passes = passes(run.band().width(), run.band().height(), &run.params)?;
    let (needs, taken_over, tolerance) = run.pool.install(|| -> Result<_, RunError> {
        let ranged = run.ranged()?;
        let needs = run.needs(ranged.as_ref())?;
        let kept = run.kept(|job| WorkDir::open(dir, job), ranged.as_ref())?;
        let failed = |source| WorkDirError::Io { path: kept.path().to_path_buf(), source };
        let taken_over = earlier.map(|earlier| run.take_over(earlier, ranged.as_ref(), &kept)).transpose()?;
        let folder = std::env::current_dir().map_err(failed)?;
        let tolerance = if run.is_searched() { Some(run.first_trial(ranged.as_ref(), &kept)?) } else { None };
        kept.dir().lay_out(&PlannedCommand::new(words, folder, passes.len())).map_err(failed)?;
        Ok((needs, taken_over, tolerance))
    })?;
    let layout = |(i, pass): (usize, &Pass)| PassLayout {
        pass: i + 1,
        name: name(pass.name()),
        columns: pass.grid().columns(),
        rows: pass.grid().rows(),
    };
    let passes = passes.iter().enumerate().map(layout).collect();
    let needs = Needs { warnings: warned.take(), ..needs };
    Ok(Layout { schema: SCHEMA, work_dir: dir.display().to_string(), passes, tolerance, taken_over, needs })
}

/// Makes what can be made of a shard of a run that has been laid out in [`Request::work_dir`] with the same request: all passes in
/// their order, or one of them, by its number from 1. Tiles whose chunks are there are not made again, and those wait that need
/// chunks of others: [`ShardReport::waiting`].
///
/// Any number of processes may be at it at once, on one machine or on many, also at the same shard. Memory and time are those of a
/// run's; the raster is opened, and read as a whole where its blocks are strips or on another machine, and where the request asks
/// for what needs that (single precision, filled voids, attributes).
///
/// # Errors
/// [`RunError`]; chunks that were finished by then are kept.
pub fn work(
    request: &Request<'_>,
    shard: Shard,
    pass: Option<usize>,
    control: &Control<'_>,
) -> Result<ShardReport, RunError> {
    let dir = check(request)?;
    let start = Instant::now();
    let warned = Warned::new(control);
    let run = Run::prepare(request, Purpose::Share, &warned, control)?;
    let (tolerance, passes) = run.pool.install(|| run.work(dir, shard, pass))?;
    Ok(ShardReport {
        schema: SCHEMA,
        work_dir: dir.display().to_string(),
        shard: shard.to_string(),
        tolerance,
        passes,
        seconds: start.elapsed().as_secs_f64(),
        warnings: warned.take(),
    })
}

/// Puts the mesh of a run together whose tiles are all there, writes it and gives it its name: the bytes that
/// [`super::simplify`] writes for the same request. The work dir goes, unless [`Request::keep_work_dir`] says otherwise.
///
/// # Errors
/// [`RunError`]; where tiles are missing, [`Error::Missing`] within, also where a search needs another run: from then on [`work`] makes
/// its tiles. Nothing is left under the output's name then, and the work dir stays.
pub fn merge(request: &Request<'_>, control: &Control<'_>) -> Result<Report, RunError> {
    check(request)?;
    make_merged(request, control)
}

/// The work dir of a request for a run in shards, if it can be one.
fn check<'a>(request: &'a Request<'_>) -> Result<&'a Path, RunError> {
    rules::check_shards(request.features())?;
    request.work_dir.as_deref().ok_or(RunError::NoWorkDir)
}

impl Run<'_> {
    fn take_over(&self, earlier: &Path, ranged: Option<&Ranged<'_>>, kept: &Kept) -> Result<TakenOver, RunError> {
        let earlier = kept.dir().earlier(earlier)?;
        let field = self.field(ranged, &kept.path().join("nothing"))?;
        let job = Job::new(&field, &self.params, self.control)?;
        // Of a search there is nothing to be taken over: each of its runs has a tolerance of its own.
        let job = if self.is_searched() { job } else { job.surveyed()? };
        Ok(take_over(&job, &|pass| earlier.spool(pass), &|pass| kept.spool(pass))?)
    }

    /// The tolerance that shards make tiles at, which is noted, or found out and noted.
    fn first_trial(&self, ranged: Option<&Ranged<'_>>, kept: &Kept) -> Result<f64, RunError> {
        if let Some(tolerance) = kept.dir().trial_of_shards()? {
            return Ok(tolerance);
        }
        let field = self.field(ranged, &kept.path().join("nothing"))?;
        let tolerance = first_trial(kept, &field, &self.params, self.control)?;
        kept.note_trial_of_shards(tolerance)?;
        Ok(tolerance)
    }

    fn work(&self, dir: &Path, shard: Shard, pass: Option<usize>) -> Result<(Option<f64>, Vec<PassShare>), RunError> {
        let ranged = self.ranged()?;
        let kept = self.kept(|job| WorkDir::join(dir, job), ranged.as_ref())?;
        // Nothing is staged that would have to be removed.
        let field = self.field(ranged.as_ref(), &dir.join("nothing"))?;
        let trial = if self.is_searched() {
            let noted = kept.dir().trial_of_shards()?;
            Some(noted.ok_or_else(|| WorkDirError::NotPlanned { dir: dir.to_path_buf() })?)
        } else {
            None
        };
        let params = trial.map_or_else(|| self.params.clone(), |tolerance| self.params.at(tolerance));
        // There is no goal; the chains of breaklines are found.
        let job = Job::new(&field, &params, self.control)?.surveyed()?;
        let all = rounds(&job);
        let usual = if kept.dir().is_again() { all.len() } else { job.passes().len() };
        let numbers = match pass {
            None => 0..usual,
            Some(pass) if (1..=all.len()).contains(&pass) => pass - 1..pass,
            Some(pass) => return Err(RunError::NoSuchPass { passes: all.len(), pass }),
        };
        let shares = numbers.map(|number| {
            let (job, pass) = &all[number];
            let share = make_share(job, *pass, shard, &|pass| Store::spool(&kept, trial, pass))?;
            Ok(PassShare { pass: number + 1, share })
        });
        let made: Result<Vec<PassShare>, Error> = shares.collect();
        let unchanged = || self.inputs.watches.iter().try_for_each(|watch| watch.check());
        let made = made.and_then(|shares| Ok(unchanged().map(|()| shares)?));
        made.map(|made| (trial, made)).map_err(|error| kept.explain(error))
    }
}

impl Kept {
    /// The mesh of chunks that are all there. Where they are not, it is noted what shards have to make next.
    pub(super) fn merge(&self, field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
        let merged = merge_chunks(self, field, params, control);
        let passes = passes(field.width(), field.height(), params)?.len();
        if let Err(Error::Missing(MissingTiles { trial, pass, .. })) = merged {
            if let Some(tolerance) = trial
                && self.dir().trial_of_shards()? != trial
            {
                self.note_trial_of_shards(tolerance)?;
            }
            if pass > passes {
                self.dir().note_again().map_err(self.failed())?;
            }
        }
        merged
    }

    fn note_trial_of_shards(&self, tolerance: f64) -> Result<(), WorkDirError> {
        self.dir().note_trial_of_shards(tolerance).map_err(self.failed())
    }

    fn failed(&self) -> impl Fn(std::io::Error) -> WorkDirError {
        let path = self.path().to_path_buf();
        move |source| WorkDirError::Io { path: path.clone(), source }
    }
}
