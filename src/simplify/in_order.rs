//! A run under a [`Goal`](super::Goal): what tiles tell beforehand, and how far each of them goes then.

use rayon::prelude::*;

use super::goal::{Base, Cost, Curves, Floor, Outcome, Told, find_cut};
use super::pool::Pool;
use super::tiles::{Job, Workspace, task, tolerance};
use super::{EngineChoice, Error};
use crate::control::Stage;
use crate::lattice::Point;
use crate::measure::Bound;
use crate::raster::Window;
use crate::seam::{Rim, Side, SideVertex};
use crate::spool::SpoolError;
use crate::tiling::{TileGrid, TileId};
use crate::triangulate::insertion::{GreedyInsertion, InsertionOptions, Key, Order};

/// Where all tiles end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct End {
    cut: Key,
    /// The tolerance that samples are candidates beyond.
    lowest: f64,
    pub(super) outcome: Outcome,
    /// Temporary disk that the survey took.
    pub(super) survey_bytes: u64,
}

/// Has every tile tell how its insertion goes, and finds where all of them end. `None` where there is no goal.
pub(super) fn find_end(job: &Job<'_>, workspaces: &Pool<Workspace>) -> Result<Option<End>, Error> {
    let Job { field, params, grid, control, .. } = *job;
    params.takes_goal()?;
    params.takes_heights()?;
    let EngineChoice::GreedyInsertion(options) = params.engine else { return Ok(None) };
    if params.goal.is_none() {
        return Ok(None);
    }
    let failed = |source| SpoolError::File { dir: params.temp_dir.clone(), source };
    let base = Base {
        points: (grid.columns() as u64 + 1) * (grid.rows() as u64 + 1),
        triangles: 2 * grid.len() as u64,
        samples: field.width() as u64 * field.height() as u64,
    };
    params.goal.check(&base)?;
    let lowest = lowest(job);
    let floor = Floor::new(&params.goal, lowest);
    let curves = Curves::new(&params.temp_dir, grid.len()).map_err(failed)?;
    control.progress.begin(Stage::Survey, grid.len() as u64, base.samples);
    (0..grid.len()).into_par_iter().try_for_each(|index| {
        control.cancel.check()?;
        workspaces.with(|workspace| {
            workspace.tell(job, options, index, lowest, &floor)?;
            floor.raise(&workspace.told);
            curves.tell(index, &workspace.told, &mut workspace.encoded).map_err(failed).map_err(Error::from)
        })?;
        let window = grid.window(grid.tile(index));
        control.progress.step(Stage::Survey, (window.len()) as u64);
        Ok::<(), Error>(())
    })?;
    control.progress.end(Stage::Survey);
    let (cut, outcome) = find_cut(&curves, &params.goal, base, error_needs(job)).map_err(failed)??;
    Ok(Some(End { cut, lowest, outcome, survey_bytes: curves.bytes() }))
}

/// The tolerance beyond which samples are candidates: where a quality is asked for, one at which it is reached.
fn lowest(job: &Job<'_>) -> f64 {
    let error = job.params.max_error.is_finite().then(|| tolerance(job.params));
    // With all errors within r, so is their root mean square; but weights below 1 allow larger ones.
    let rms = job.params.goal.max_rms.map(|rms| if job.field.importance().is_some() { 0.0 } else { rms });
    error.into_iter().chain(rms).reduce(f64::min).unwrap_or(0.0)
}

/// The last key that the tolerance needs, where a root mean square is asked for, too.
fn error_needs(job: &Job<'_>) -> Option<Key> {
    // A little lower, so that no rounding of an error counts.
    job.params.max_error.is_finite().then(|| Key::last_of(tolerance(job.params) * (1.0 - 1e-9)))
}

/// The key of a rim vertex, and what it costs the tile that asks.
fn rim_key(grid: TileGrid, id: TileId, vertex: SideVertex) -> (Key, Cost) {
    let (last_column, last_row) = (grid.is_last_column(id), grid.is_last_row(id));
    let own = |side: Side, is_outer: bool| (id, side, true, is_outer);
    let (owner, side, owned, is_outer) = match vertex.side {
        Side::North => own(Side::North, id.row == 0),
        Side::West => own(Side::West, id.column == 0),
        Side::East if last_column => own(Side::East, true),
        Side::South if last_row => own(Side::South, true),
        Side::East => (TileId { column: id.column + 1, ..id }, Side::West, false, false),
        Side::South => (TileId { row: id.row + 1, ..id }, Side::North, false, false),
    };
    let ordinal = (side as u64) << 32 | vertex.at as u64;
    let triangles = if is_outer { 1 } else { 2 };
    let cost = if owned { Cost { points: 1, triangles } } else { Cost::default() };
    (Key::of_rim(vertex.level, grid.index(owner) as u64, ordinal), cost)
}

impl Workspace {
    /// Loads a tile and makes its rim of the vertices up to a cut, with their keys and costs.
    fn begin(&mut self, job: &Job<'_>, index: usize, lowest: f64, cut: Key) -> Result<(Rim, Vec<(Key, Cost)>), Error> {
        let id = job.grid.tile(index);
        let window = job.grid.window(id);
        job.field.load(window, &mut self.tile)?;
        if !self.tile.validity().is_whole() {
            let Window { column, row, width, height } = window;
            return Err(Error::GoalWithNodata { column, row, width, height });
        }
        self.find_points(job, window)?;
        let last = (job.grid.is_last_column(id), job.grid.is_last_row(id));
        let (rim, order) = Rim::nested(&self.tile, lowest, &self.points, last, |v| rim_key(job.grid, id, v).0 <= cut);
        let far = self.tile.far_corner();
        let is_corner = |p: Point| (p.x == 0 || p.x == far.x) && (p.y == 0 || p.y == far.y);
        let mut order = order.into_iter();
        let keys = rim.domain.vertices.iter().map(|v| match is_corner(v.at) {
            true => (Key::FIRST, Cost::default()),
            false => rim_key(job.grid, id, order.next().expect("a key for every vertex between corners")),
        });
        let keys = keys.collect();
        Ok((rim, keys))
    }

    /// Finds out how a tile's insertion goes, as far as anybody may want to know.
    fn tell(
        &mut self,
        job: &Job<'_>,
        options: InsertionOptions,
        index: usize,
        lowest: f64,
        floor: &Floor,
    ) -> Result<(), Error> {
        let goal = &job.params.goal;
        let cut = floor.cut();
        let (rim, keyed) = self.begin(job, index, lowest, cut)?;
        let (keys, _): (Vec<Key>, Vec<Cost>) = keyed.iter().copied().unzip();
        let mut costs = keyed;
        costs.sort_unstable_by_key(|(key, _)| *key);
        let id = job.grid.tile(index);
        let last = (job.grid.is_last_column(id), job.grid.is_last_row(id));
        let most = goal.max_points.into_iter().chain(goal.max_triangles).min().unwrap_or(u64::MAX);
        let order =
            Order { keys: &keys, tile: index as u64, cut, most, squares: goal.max_rms.is_some().then_some(last) };
        let inside = rim.domain.points.len() as u64;
        self.told.clear();
        let told = &mut self.told;
        let from_the_start = Cost { points: inside, triangles: 2 * inside };
        told.push(Told { key: Key::FIRST, cost: from_the_start, squares: 0.0 });
        let task = task(&self.tile, &rim, lowest, job);
        GreedyInsertion { options }.triangulate_in_order(
            &task,
            order,
            self.engine.insertion(),
            &mut self.mesh,
            |e| {
                if e.key == Key::FIRST {
                    told[0].squares = e.squares;
                    return;
                }
                let cost = match costs.binary_search_by_key(&e.key, |(key, _)| *key) {
                    Ok(i) => costs[i].1,
                    Err(_) => Cost { points: 1, triangles: 2 },
                };
                told.push(Told { key: e.key, cost, squares: e.squares });
            },
        )?;
        Ok(())
    }

    /// Makes a tile's mesh as far as the end of all.
    pub(super) fn run_to(&mut self, job: &Job<'_>, index: usize, end: &End) -> Result<(Rim, Bound), Error> {
        let EngineChoice::GreedyInsertion(options) = job.params.engine else {
            unreachable!("only greedy insertion has an end to come to")
        };
        let (rim, keyed) = self.begin(job, index, end.lowest, end.cut)?;
        let keys: Vec<Key> = keyed.into_iter().map(|(key, _)| key).collect();
        let order = Order { keys: &keys, tile: index as u64, cut: end.cut, most: u64::MAX, squares: None };
        let task = task(&self.tile, &rim, end.lowest, job);
        GreedyInsertion { options }.triangulate_in_order(
            &task,
            order,
            self.engine.insertion(),
            &mut self.mesh,
            |_| (),
        )?;
        Ok((rim, end.bound(job)))
    }
}

impl End {
    /// What the errors of a mesh that ends here are bound by.
    fn bound(&self, job: &Job<'_>) -> Bound {
        if self.outcome.ended_by.is_none() && job.params.max_error.is_finite() {
            return Bound::Within(tolerance(job.params));
        }
        Bound::Scale(if self.outcome.threshold.is_finite() { self.outcome.threshold } else { 0.0 })
    }

    /// What errors are sorted by, for percentiles.
    pub(super) fn scale(&self, job: &Job<'_>) -> f64 {
        match self.bound(job) {
            Bound::Within(scale) | Bound::Scale(scale) => scale,
        }
    }
}
