//! A search's runs, and a few tiles by which they are foreseen.

use std::time::Instant;

use super::Store;
use super::curve::Curve;
use super::figures::Figures;
use super::hunt::{Bench, Preview};
use super::sample::{Sample, for_each};
use crate::job::passes::{Job, Pool, TileMaker, TileTimes};
use crate::job::shards::merge_run;
use crate::job::triangulate::run_to_the_end;
use crate::job::{Error, Mesh, Params, Quality};

/// With fewer tiles none is polished beforehand: a run is little more.
const FEW: usize = 4;

/// Who makes the tiles of runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::job) enum Makers {
    /// This process.
    Here,
    /// Others, in shards: a run whose tiles are not all there ends the search with [`Error::Missing`].
    Others,
}

/// What runs make, and what a few tiles foretell.
pub(super) struct Tiles<'a> {
    job: &'a Job<'a>,
    /// None where nothing is kept, and no run is made.
    store: Option<&'a dyn Store>,
    run_makers: Makers,
    sample: Sample,
    ways: Vec<Way>,
    previews: Vec<Preview>,
    /// What many tiles came to.
    of_many: Curve,
    start: f64,
    makers: Pool<TileMaker>,
    /// Meshes of runs, by their tolerances.
    meshes: Vec<(f64, Mesh)>,
    /// The tolerances of runs whose chunks may be kept, by this process or an earlier one.
    kept: Vec<f64>,
    /// Of all runs together.
    times: TileTimes,
    found: u64,
    spool_bytes: u64,
    /// Seconds of all threads together for tiles that were tried; and for all tiles, as the last took that were polished.
    seconds: f64,
    run_seconds: Option<f64>,
}

/// Which tiles are tried.
#[derive(Debug, Clone, Copy)]
enum Which {
    Few,
    Many,
}

/// A way to foretell what a run comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// A few tiles as the engine leaves them: these lead to about the right tolerance.
    Few,
    /// Many, likewise: rough ground and smooth in the right proportion.
    Many,
    /// What polishing leaves of few, as a share, applied to many.
    Polished,
}

impl Way {
    fn name(self) -> &'static str {
        match self {
            Way::Few => "a few tiles",
            Way::Many => "many tiles",
            Way::Polished => "polished",
        }
    }
}

/// What whole runs are called.
pub(in crate::job) const RUN: &str = "run";

impl<'a> Tiles<'a> {
    /// Looks at the heights of a few tiles.
    pub(super) fn new(job: &'a Job<'a>, store: Option<&'a dyn Store>, run_makers: Makers) -> Result<Tiles<'a>, Error> {
        let Job { params, grid, .. } = *job;
        let makers = Pool::default();
        let sample = Sample::look(job, &makers)?;
        let ways = [
            (Way::Few, Preview { near: 0.15, bias: 1.0 }, sample.few.len() < sample.many.len()),
            (Way::Many, Preview { near: 0.08, bias: polished_share(params.quality) }, true),
            (Way::Polished, Preview { near: 0.04, bias: 1.0 }, params.quality != Quality::None && grid.len() >= FEW),
        ];
        // Without ground nothing is known before the first run.
        let ways = ways.into_iter().filter(|(_, _, pays)| *pays && !sample.many.is_empty());
        let (ways, previews) = ways.map(|(way, preview, _)| (way, preview)).unzip();
        let asked = Some(params.tolerance.asked()).filter(|asked| asked.is_finite());
        let start = params.goal.max_rms.map(|rms| 2.5 * rms).or(asked).filter(|&start| start > 0.0);
        let start = start.or((sample.span > 0.0).then_some(sample.span / 64.0)).unwrap_or(1.0);
        Ok(Tiles {
            job,
            store,
            run_makers,
            sample,
            ways,
            previews,
            of_many: Curve::default(),
            start,
            makers,
            meshes: Vec::new(),
            kept: Vec::new(),
            times: TileTimes::default(),
            found: 0,
            spool_bytes: 0,
            seconds: 0.0,
            run_seconds: None,
        })
    }

    /// The mesh of a run that was made, here or in an earlier process.
    pub(super) fn mesh(mut self, tolerance: f64) -> Result<Mesh, Error> {
        let mesh = match self.meshes.iter().position(|(t, _)| *t == tolerance) {
            Some(at) => self.meshes.swap_remove(at).1,
            None => self.make(tolerance)?,
        };
        let spool_bytes = self.spool_bytes.max(mesh.spool_bytes);
        Ok(Mesh { times: self.times, found: self.found, spool_bytes, ..mesh })
    }

    /// Seconds of all threads together: what the tiles took that were tried, and what the first pass of a run may take, where
    /// it is known.
    pub(super) fn seconds(&self) -> (f64, Option<f64>) {
        (self.seconds, self.run_seconds)
    }

    /// Makes sure that it is known how long a run takes, where no tile has been polished so far.
    pub(super) fn time(&mut self, tolerance: f64) -> Result<(), Error> {
        if self.run_seconds.is_none() && !self.sample.few.is_empty() {
            self.made(Which::Few, true, tolerance)?;
        }
        Ok(())
    }

    /// Makes a run at a tolerance.
    fn make(&mut self, tolerance: f64) -> Result<Mesh, Error> {
        let Job { field, control, .. } = *self.job;
        let params = self.job.params.at(tolerance);
        let store = self.store.expect("a store where runs are made");
        let make_spool = |pass: &_| store.spool(Some(tolerance), pass);
        let mesh = match self.run_makers {
            Makers::Here => run_to_the_end(&make_spool, field, &params, control)?,
            Makers::Others => merge_run(&make_spool, field, &params, control).map_err(|e| e.of_trial(tolerance))?,
        };
        let held: u64 = self.meshes.iter().map(|(_, mesh)| mesh.spool.bytes()).sum();
        self.spool_bytes = self.spool_bytes.max(held + mesh.spool_bytes);
        self.times = self.times.plus(mesh.times);
        self.found += mesh.found;
        Ok(mesh)
    }

    /// What tiles come to, with or without polishing, scaled to the whole raster.
    fn made(&mut self, tiles: Which, polished: bool, tolerance: f64) -> Result<Figures, Error> {
        // Lines have their edges in whole runs.
        let (params, job) = (Params { breaklines: None, ..self.job.params.at(tolerance) }, self.job);
        let wants_errors = job.params.goal.max_rms.is_some();
        let (params, max_stray) = match polished {
            false => (Params { quality: Quality::None, ..params }, f64::INFINITY),
            true => (params, job.max_stray),
        };
        let (tiles, times) = match tiles {
            Which::Few => (&self.sample.few, self.sample.times[0]),
            Which::Many => (&self.sample.many, self.sample.times[1]),
        };
        let tried = for_each(job, &self.makers, tiles, |maker, job, id| {
            let alone = Job { params: &params, max_stray, polishes_seams: false, chains: None, ..job.clone() };
            let start = Instant::now();
            let probed = maker.probe(&alone, &job.grid.place_of(id), wants_errors)?;
            Ok((probed, start.elapsed().as_secs_f64()))
        })?;
        let seconds: f64 = tried.iter().map(|(_, seconds)| seconds).sum();
        let mut sum = Figures::default();
        let (mut squares, mut samples) = (0.0, 0);
        for (tile, _) in &tried {
            sum.vertices += tile.vertices;
            sum.triangles += tile.triangles;
            squares += tile.squares;
            samples += tile.measured;
        }
        self.seconds += seconds;
        let is_run = polished || job.params.quality == Quality::None;
        self.run_seconds = is_run.then_some(seconds * times).or(self.run_seconds);
        let rms = if samples == 0 { 0.0 } else { (squares / samples as f64).sqrt() };
        Ok(Figures { rms, ..sum.scaled(times) })
    }

    /// What a tolerance comes to in some way.
    fn try_way(&mut self, way: Way, tolerance: f64) -> Result<Figures, Error> {
        match way {
            Way::Few => self.made(Which::Few, false, tolerance),
            Way::Many => self.made(Which::Many, false, tolerance),
            Way::Polished => {
                let of_engine = self.made(Which::Few, false, tolerance)?;
                let polished = self.made(Which::Few, true, tolerance)?;
                let many = self.of_many.estimate(tolerance).unwrap_or(of_engine);
                Ok(polished.in_proportion(&of_engine, &many))
            }
        }
    }

    /// What was noted, else what is found out, and noted.
    fn known(
        &mut self,
        way: &str,
        tolerance: f64,
        find: impl FnOnce(&mut Self) -> Result<Figures, Error>,
    ) -> Result<Figures, Error> {
        if let Some(store) = self.store
            && let Some(figures) = store.recall(way, tolerance)?
        {
            return Ok(figures);
        }
        let figures = find(self)?;
        if let Some(store) = self.store {
            store.note(way, tolerance, &figures)?;
        }
        Ok(figures)
    }
}

impl Bench for Tiles<'_> {
    fn previews(&self) -> &[Preview] {
        &self.previews
    }

    fn preview(&mut self, number: usize, tolerance: f64) -> Result<Figures, Error> {
        let way = self.ways[number];
        let figures = self.known(way.name(), tolerance, |tiles| tiles.try_way(way, tolerance))?;
        if way == Way::Many {
            self.of_many.add(tolerance, figures);
        }
        Ok(figures)
    }

    fn run(&mut self, tolerance: f64) -> Result<Figures, Error> {
        self.kept.push(tolerance);
        self.known(RUN, tolerance, |tiles| {
            let mesh = tiles.make(tolerance)?;
            let figures = mesh.figures()?;
            tiles.meshes.push((tolerance, mesh));
            Ok(figures)
        })
    }

    fn keep(&mut self, best: Option<f64>) -> Result<(), Error> {
        self.meshes.retain(|(tolerance, _)| Some(*tolerance) == best);
        let others: Vec<f64> = self.kept.extract_if(.., |tolerance| Some(*tolerance) != best).collect();
        others.into_iter().try_for_each(|tolerance| self.store.map_or(Ok(()), |store| store.forget(tolerance)))
    }

    fn start(&self) -> f64 {
        self.start
    }

    fn span(&self) -> f64 {
        self.sample.span
    }

    fn step(&self) -> Option<f64> {
        self.sample.step
    }
}

/// How many of the triangles of engines polishing leaves, about.
fn polished_share(quality: Quality) -> f64 {
    match quality {
        Quality::None => 1.0,
        Quality::Fast => 0.45,
        Quality::Balanced => 0.32,
        Quality::Best => 0.3,
    }
}
