//! A run made in parts: processes, on one machine or on many, that each make their share of every pass's tiles, and one that
//! puts the mesh together.
//!
//! A share is a range of tiles in their order, so what a tile of a later pass needs is in the same share but for what lies along
//! its ends. Nothing is locked: chunks come to their names whole, and whoever makes one twice makes the same bytes
//! ([`crate::job::work_dir`]).
//!
//! Under a goal that a tolerance is looked for ([`Params::is_searched`]) whole runs are made so, one after the other: whoever merges
//! says at which tolerance, and the processes make its tiles ([`first_trial`], [`merge`]).

use std::fmt;
use std::ops::Range;

use super::passes::{Gathered, Job, Pass, gather, must_be_of_samples, run_pass};
use super::search::{self, Makers, Store};
use super::spool::{Chunks, Spool};
use super::triangulate::must_have_ground;
use super::{Error, MakeSpool, Mesh, Params};
use crate::base::control::Control;
use crate::base::decimal::Decimal;
use crate::base::features::FeatureSet;
use crate::base::tiling::TileId;
use crate::field::Field;

/// One of the equal shares that a run is made in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// More shares than this are of no use to anybody.
    pub const MOST: usize = 1_000_000;

    /// Share `number` of `of`, counted from 1; `None` unless 1 ≤ number ≤ of ≤ [`Shard::MOST`].
    pub fn new(number: usize, of: usize) -> Option<Shard> {
        (1 <= number && number <= of && of <= Shard::MOST).then_some(Shard { number, of })
    }

    /// Its range of `tiles` tiles: over all shards every tile once, and no share larger than another by more than one tile.
    pub fn tiles(self, tiles: usize) -> Range<usize> {
        // A product of two numbers of a machine's word.
        let at = |part: usize| (tiles as u128 * part as u128 / self.of as u128) as usize;
        at(self.number - 1)..at(self.number)
    }

    /// Whether a place below `total` is in its share of all places: it is in one shard's.
    pub fn has(self, place: u128, total: u128) -> bool {
        place * self.of as u128 / total == self.number as u128 - 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// What became of a shard's tiles in a pass.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct Share {
    /// How many it has.
    pub tiles: u64,
    /// How many of them were made now.
    pub made: u64,
    /// How many were there.
    pub found: u64,
    /// How many wait for chunks of the pass before that others have to make.
    pub waiting: u64,
}

/// Makes what can be made of a shard's tiles in a pass, on the threads of the current rayon pool: those whose needed chunks are
/// there. `number` is the pass's among [`Job::passes`], from 0. Where the raster's files are not those that the work dir was made for
/// ([`Spool::check_samples`]), the samples of all chunks that are needed are compared first.
///
/// Memory: that of [`run_pass`], and a number for each tile of the shard.
///
/// # Errors
/// [`Error`]; chunks that were finished by then are kept.
///
/// # Panics
/// If there is no such pass, or spools are not kept or are for another number of tiles.
pub fn make_share(job: &Job<'_>, number: usize, shard: Shard, make_spool: &MakeSpool<'_>) -> Result<Share, Error> {
    let passes = job.passes();
    let pass = passes[number];
    let tiles = shard.tiles(pass.grid().len());
    let out = make_spool(&pass)?;
    let inputs = pass.needs().map(|_| make_spool(&passes[number - 1])).transpose()?;
    let mut share = Share { tiles: tiles.len() as u64, ..Share::default() };
    let runs = ready(&pass, tiles, inputs.as_ref())?;
    if let Some(inputs) = inputs.as_ref().filter(|inputs| inputs.check_samples()) {
        // The raster may have changed since the pass before: then its chunks do not go with what is made now.
        let mut needed: Vec<usize> =
            runs.iter().flat_map(|run| run.tiles.clone()).flat_map(|tile| pass.needed(tile)).collect();
        needed.sort_unstable();
        needed.dedup();
        must_be_of_samples(job, &passes[number - 1], inputs, &needed)?;
    }
    for run in runs {
        share.waiting += run.waiting_before;
        let count = run.tiles.len() as u64;
        let inputs = inputs.as_ref().map(|spool| spool as &dyn Chunks);
        let result = run_pass(job, &pass, run.tiles, inputs, &out)?;
        share.found += result.found;
        share.made += count - result.found;
    }
    Ok(share)
}

/// Tiles in a row that can be made, and how many before them cannot.
struct Ready {
    waiting_before: u64,
    tiles: Range<usize>,
}

/// The tiles of a range whose needed chunks are there, in runs; the last run may be empty.
fn ready(pass: &Pass, tiles: Range<usize>, inputs: Option<&Spool>) -> Result<Vec<Ready>, Error> {
    let Some(inputs) = inputs else { return Ok(vec![Ready { waiting_before: 0, tiles }]) };
    let mut runs = vec![Ready { waiting_before: 0, tiles: tiles.start..tiles.start }];
    for tile in tiles {
        let mut is_ready = true;
        for needed in pass.needed(tile) {
            is_ready = is_ready && inputs.holds(needed)?;
        }
        let last = runs.len() - 1;
        let run = &mut runs[last];
        match (is_ready, run.tiles.is_empty()) {
            (true, true) => run.tiles = tile..tile + 1,
            (true, false) => run.tiles.end = tile + 1,
            (false, true) => run.waiting_before += 1,
            (false, false) => runs.push(Ready { waiting_before: 1, tiles: tile..tile }),
        }
    }
    Ok(runs)
}

impl Error {
    /// The same of a search's run at a tolerance.
    pub(super) fn of_trial(self, tolerance: f64) -> Error {
        match self {
            Error::Missing(missing) => MissingTiles { trial: Some(tolerance), ..missing }.into(),
            other => other,
        }
    }
}

/// Tiles of a pass that nobody has made yet.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "expected the chunks of all {of} tiles of pass {pass}{}, found {missing} missing: {}",
    trial.map_or(String::new(), |tolerance| format!(" at the tolerance of {}, which the search tries next", Decimal(tolerance))),
    named(tiles, *missing)
)]
pub struct MissingTiles {
    /// The tolerance of a search's run that they are tiles of.
    pub trial: Option<f64>,
    /// The pass, from 1, as [`rounds`] counts them.
    pub pass: usize,
    /// How many are missing.
    pub missing: usize,
    /// Of how many.
    pub of: usize,
    /// The first of them.
    pub tiles: Vec<TileId>,
}

impl Gathered {
    /// What is missing of a pass of this number.
    fn missing_of(self, number: usize, pass: Pass) -> MissingTiles {
        let tiles = self.first_missing.into_iter().map(|tile| pass.grid().tile(tile)).collect();
        MissingTiles { trial: None, pass: number, missing: self.missing, of: pass.grid().len(), tiles }
    }
}

fn named(tiles: &[TileId], missing: usize) -> String {
    let places = tiles.iter().map(|TileId { column, row }| format!("column {column} row {row}"));
    let rest = (missing > tiles.len()).then(|| "…".to_string());
    places.chain(rest).collect::<Vec<_>>().join(", ")
}

/// All passes that a job may have, each with the job that it is a pass of and its number in that: its own, and after them
/// those with short links, which are only made where a limit on straying needs them ([`merge`] tells).
pub fn rounds<'a>(job: &Job<'a>) -> Vec<(Job<'a>, usize)> {
    let jobs = [Some(job.clone()), job.with_short_links()];
    jobs.into_iter().flatten().flat_map(|job| (0..job.passes().len()).map(move |pass| (job.clone(), pass))).collect()
}

/// At which tolerance the first run of a search is made, on the threads of the current rayon pool: a few tiles are tried, and what
/// they come to is noted in the store.
///
/// # Errors
/// [`Error`].
pub fn first_trial(store: &dyn Store, field: &Field, params: &Params, control: &Control<'_>) -> Result<f64, Error> {
    search::first_run(store, field, params, control)
}

/// Puts the mesh of a job together from chunks that others have made, on the threads of the current rayon pool. Of a search it is that
/// of the run that meets the goal.
///
/// Reads every chunk of the last pass once, and with trimming those of the first; of a search those of each run whose count is not
/// noted, and a few tiles of the raster. With breaklines tiles are loaded again, as by [`Job::surveyed`]. Memory: a chunk for each busy
/// thread.
///
/// # Errors
/// [`Error::Missing`], also where the passes with short links have to be made, and where a search needs another run, whose tolerance
/// it tells; or another [`Error`].
///
/// # Panics
/// If spools are for another number of tiles, or there is a goal that insertion stops at.
pub fn merge(store: &dyn Store, field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
    if params.is_searched(FeatureSet::of_field(field)) {
        return search::triangulate(Makers::Others, store, field, params, control);
    }
    merge_run(&|pass| store.spool(None, pass), field, params, control)
}

/// The same of one run.
pub(super) fn merge_run(
    make_spool: &MakeSpool<'_>,
    field: &Field,
    params: &Params,
    control: &Control<'_>,
) -> Result<Mesh, Error> {
    assert!(params.goal.is_none(), "a goal is met by one process");
    // There is no goal; the chains of breaklines are found, as their edges are marked.
    let job = Job::new(field, params, control)?.surveyed()?;
    match merge_passes(&job, 0, make_spool)? {
        Some(mesh) => Ok(mesh),
        None => {
            let again = job.with_short_links().expect("links are in the way once");
            let mesh = merge_passes(&again, job.passes().len(), make_spool)?;
            Ok(mesh.expect("short links are in nobody's way"))
        }
    }
}

/// The mesh of a job's passes, which come after so many others; `None` if it has to be made again with short links.
fn merge_passes(job: &Job<'_>, before: usize, make_spool: &MakeSpool<'_>) -> Result<Option<Mesh>, Error> {
    let passes = job.passes();
    let last = passes[passes.len() - 1];
    let spool = make_spool(&last)?;
    let gathered = gather(job, &last, &spool)?;
    if gathered.missing > 0 {
        return Err(gathered.missing_of(before + passes.len(), last).into());
    }
    let Gathered { astray, bare, .. } = gathered;
    if astray > 0 && job.with_short_links().is_some() {
        return Ok(None);
    }
    if job.params.trim > 0 && passes.len() > 1 {
        let first = gather(job, &passes[0], &make_spool(&passes[0])?)?;
        if first.missing > 0 {
            return Err(first.missing_of(before + 1, passes[0]).into());
        }
        if bare != first.bare {
            return Err(Error::Unlike { trimmed: first.bare, bare });
        }
    }
    must_have_ground(job, &spool, &last)?;
    Ok(Some(Mesh::of(job, spool, &last)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_even_and_leave_nothing_out() {
        for (tiles, of) in [(0, 1), (1, 1), (7, 3), (64, 64), (5, 64), (400_000, 7)] {
            let shares: Vec<Range<usize>> = (1..=of).map(|n| Shard::new(n, of).unwrap().tiles(tiles)).collect();
            assert_eq!((shares[0].start, shares[of - 1].end), (0, tiles));
            assert!(shares.windows(2).all(|pair| pair[0].end == pair[1].start));
            let sizes = || shares.iter().map(Range::len);
            assert!(sizes().max().unwrap() - sizes().min().unwrap() <= 1, "{tiles} in {of}");
        }
        for (total, of) in [(1u128, 1), (1, 64), (7, 3), (1000, 64)] {
            let owners = |place| (1..=of).filter(move |&n| Shard::new(n, of).unwrap().has(place, total)).count();
            assert!((0..total).all(|place| owners(place) == 1), "{total} in {of}");
        }
        assert_eq!([Shard::new(0, 1), Shard::new(2, 1), Shard::new(1, 0)], [None; 3]);
    }
}
