//! A search's runs, and a few tiles by which they are foreseen.

use rayon::prelude::*;

use super::Store;
use super::curve::Curve;
use super::figures::Figures;
use super::hunt::{Bench, Preview};
use crate::base::control::Stage;
use crate::base::tiling::{TileGrid, TileId, spread};
use crate::job::passes::{Job, Pool, TileMaker, TileTimes};
use crate::job::triangulate::run_to_the_end;
use crate::job::{Error, Goal, Mesh, Params, Quality};

/// One of so many tiles is polished beforehand.
const ONE_OF: usize = 8;
/// With fewer tiles none is: a run is little more.
const FEW: usize = 4;
/// No more tiles than this are polished, or triangulated.
const MOST: [usize; 2] = [256, 1024];

/// What runs make, and what a few tiles foretell.
pub(super) struct Tiles<'a> {
    job: &'a Job<'a>,
    /// None where no run is made.
    store: Option<&'a dyn Store>,
    few: Vec<TileId>,
    many: Vec<TileId>,
    ways: Vec<Way>,
    previews: Vec<Preview>,
    /// What many tiles came to.
    of_many: Curve,
    start: f64,
    step: Option<f64>,
    makers: Pool<TileMaker>,
    /// Meshes of runs, by their tolerances.
    meshes: Vec<(f64, Mesh)>,
    times: TileTimes,
    spool_bytes: u64,
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
const RUN: &str = "run";

impl<'a> Tiles<'a> {
    /// Looks at the heights of a few tiles.
    pub(super) fn new(job: &'a Job<'a>, store: Option<&'a dyn Store>) -> Result<Tiles<'a>, Error> {
        let Job { params, grid, .. } = *job;
        let [few, many] = [(grid.len() / ONE_OF).clamp(1, MOST[0]), grid.len().min(MOST[1])];
        let [few, many] = [few, many].map(|most| sample(grid, most));
        let mut ways = Vec::new();
        if few.len() < many.len() {
            ways.push((Way::Few, Preview { near: 0.15, bias: 1.0 }));
        }
        ways.push((Way::Many, Preview { near: 0.08, bias: polished_share(params.quality) }));
        if params.quality != Quality::None && grid.len() >= FEW {
            ways.push((Way::Polished, Preview { near: 0.04, bias: 1.0 }));
        }
        let (ways, previews) = ways.into_iter().unzip();
        let mut tiles = Tiles {
            job,
            store,
            few,
            many,
            ways,
            previews,
            of_many: Curve::default(),
            start: 1.0,
            step: None,
            makers: Pool::default(),
            meshes: Vec::new(),
            times: TileTimes::default(),
            spool_bytes: 0,
        };
        let heights = tiles.each(&tiles.few, |maker, job, id| maker.look(job, &job.grid.place_of(id)))?;
        let span = heights.iter().map(|h| h.span).fold(0.0, f64::max);
        let goal = params.goal.max_rms.map(|rms| 2.5 * rms);
        let asked = Some(params.tolerance.asked()).filter(|asked| asked.is_finite());
        tiles.start = goal.or(asked).filter(|&t| t > 0.0).or((span > 0.0).then_some(span / 64.0)).unwrap_or(1.0);
        tiles.step = heights.iter().all(|h| h.are_whole).then_some(1.0);
        Ok(tiles)
    }

    /// The mesh of a run that was made, here or in an earlier process.
    pub(super) fn mesh(mut self, tolerance: f64) -> Result<Mesh, Error> {
        let mesh = match self.meshes.iter().position(|(t, _)| *t == tolerance) {
            Some(at) => self.meshes.swap_remove(at).1,
            None => self.make(tolerance)?,
        };
        Ok(Mesh { times: self.times, spool_bytes: self.spool_bytes.max(mesh.spool_bytes), ..mesh })
    }

    /// Makes a run at a tolerance.
    fn make(&mut self, tolerance: f64) -> Result<Mesh, Error> {
        let Job { field, control, .. } = *self.job;
        let params = self.at(tolerance);
        let store = self.store.expect("a store where runs are made");
        let mesh = run_to_the_end(&|pass| store.spool(Some(tolerance), pass), field, &params, control)?;
        let held: u64 = self.meshes.iter().map(|(_, mesh)| mesh.spool.bytes()).sum();
        self.spool_bytes = self.spool_bytes.max(held + mesh.spool_bytes);
        self.times = self.times.plus(mesh.times);
        Ok(mesh)
    }

    /// What decides the mesh of a run at a tolerance.
    fn at(&self, tolerance: f64) -> Params {
        let params = self.job.params;
        Params { tolerance: params.tolerance.at(tolerance), goal: Goal::default(), ..params.clone() }
    }

    /// Does something with each of some tiles, in parallel.
    fn each<T: Send>(
        &self,
        tiles: &[TileId],
        work: impl Fn(&mut TileMaker, &Job<'_>, TileId) -> Result<T, Error> + Sync,
    ) -> Result<Vec<T>, Error> {
        let Job { control, grid, .. } = *self.job;
        let samples = tiles.iter().map(|&id| grid.window(id).len() as u64).sum();
        control.progress.begin(Stage::Survey, tiles.len() as u64, samples);
        let all = tiles.par_iter().map(|&id| {
            control.cancel.check()?;
            let done = self.makers.with(|maker| work(maker, self.job, id))?;
            control.progress.step(Stage::Survey, grid.window(id).len() as u64);
            Ok(done)
        });
        let all: Result<Vec<T>, Error> = all.collect();
        control.progress.end(Stage::Survey);
        all
    }

    /// What tiles come to, with or without polishing, scaled to the whole raster.
    fn made(&self, tiles: &[TileId], polished: bool, tolerance: f64) -> Result<Figures, Error> {
        let (params, job) = (self.at(tolerance), *self.job);
        let wants_errors = job.params.goal.max_rms.is_some();
        let (params, max_stray) = match polished {
            false => (Params { quality: Quality::None, ..params }, f64::INFINITY),
            true => (params, job.max_stray),
        };
        let tried = self.each(tiles, |maker, job, id| {
            let alone = Job { params: &params, max_stray, polishes_seams: false, ..*job };
            maker.probe(&alone, &job.grid.place_of(id), wants_errors)
        })?;
        let (mut cells, mut sum) = (0, Figures::default());
        let (mut squares, mut samples) = (0.0, 0);
        for tile in &tried {
            cells += tile.cells;
            sum.vertices += tile.vertices;
            sum.triangles += tile.triangles;
            squares += tile.squares;
            samples += tile.measured;
        }
        let all = (job.field.width() as f64 - 1.0) * (job.field.height() as f64 - 1.0);
        let rms = if samples == 0 { 0.0 } else { (squares / samples as f64).sqrt() };
        Ok(Figures { rms, ..sum.scaled(all / cells as f64) })
    }

    /// What a tolerance comes to in some way.
    fn try_way(&mut self, way: Way, tolerance: f64) -> Result<Figures, Error> {
        match way {
            Way::Few => self.made(&self.few, false, tolerance),
            Way::Many => self.made(&self.many, false, tolerance),
            Way::Polished => {
                let of_engine = self.made(&self.few, false, tolerance)?;
                let polished = self.made(&self.few, true, tolerance)?;
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
        self.known(RUN, tolerance, |tiles| {
            let mesh = tiles.make(tolerance)?;
            let figures = mesh.figures()?;
            tiles.meshes.push((tolerance, mesh));
            Ok(figures)
        })
    }

    fn keep(&mut self, best: Option<f64>) -> Result<(), Error> {
        let others = self.meshes.extract_if(.., |(tolerance, _)| Some(*tolerance) != best);
        let others: Vec<f64> = others.map(|(tolerance, _)| tolerance).collect();
        others.into_iter().try_for_each(|tolerance| self.store.map_or(Ok(()), |store| store.forget(tolerance)))
    }

    fn start(&self) -> f64 {
        self.start
    }

    fn step(&self) -> Option<f64> {
        self.step
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

/// No more tiles than so many, spread evenly over a raster.
fn sample(grid: TileGrid, most: usize) -> Vec<TileId> {
    let rows = (most * grid.rows() / grid.columns()).isqrt().clamp(1, grid.rows());
    let columns = (most / rows).clamp(1, grid.columns());
    spread(grid.rows(), rows)
        .flat_map(|row| spread(grid.columns(), columns).map(move |column| TileId { column, row }))
        .collect()
}
