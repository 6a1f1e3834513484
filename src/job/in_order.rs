//! A run under a [`Goal`](super::Goal): what tiles tell beforehand, and how far each of them goes then.

use rayon::prelude::*;

use super::goal::{Cost, Curves, Floor, GoalTooSmall, Outcome, Told, find_cut};
use super::pool::Pool;
use super::tiles::{Job, Workspace, task, tolerance};
use super::{EngineChoice, Error};
use crate::base::Tile;
use crate::base::control::Stage;
use crate::base::tiling::{TileGrid, TileId};
use crate::job::spool::SpoolError;
use crate::kernel::measure::{Bound, owns};
use crate::kernel::seam::{LateVertex, NestedRim, Rim, Side};
use crate::kernel::triangulate::insertion::{GreedyInsertion, InsertionOptions, Key, Order, Share};

/// Where all tiles end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct End {
    pub(super) cut: Key,
    /// The tolerance that samples are candidates beyond.
    pub(super) lowest: f64,
    pub(super) outcome: Outcome,
    /// Temporary disk that the survey took.
    pub(super) survey_bytes: u64,
}

/// Has every tile tell how its insertion goes, and finds where all of them end. `None` where there is no goal.
pub(super) fn find_end(job: &Job<'_>, workspaces: &Pool<Workspace>) -> Result<Option<End>, Error> {
    let Job { field, params, grid, control, .. } = *job;
    let EngineChoice::GreedyInsertion(options) = params.engine else { return Ok(None) };
    if params.goal.is_none() {
        return Ok(None);
    }
    let failed = |source| SpoolError::File { dir: params.temp_dir.clone(), source };
    if !field.may_have_gaps() {
        check_corners(job)?;
    }
    let lowest = lowest(job);
    let floor = Floor::new(&params.goal, lowest);
    let curves = Curves::new(&params.temp_dir, grid.len()).map_err(failed)?;
    control.progress.begin(Stage::Survey, grid.len() as u64, field.width() as u64 * field.height() as u64);
    let survey = (0..grid.len()).into_par_iter().map(|index| {
        control.cancel.check()?;
        let samples = workspaces.with(|workspace| {
            let samples = workspace.tell(job, options, index, lowest, &floor)?;
            floor.raise(&workspace.told);
            curves.tell(index, &workspace.told, &mut workspace.encoded).map_err(failed)?;
            Ok::<u64, Error>(samples)
        })?;
        let window = grid.window(grid.tile(index));
        control.progress.step(Stage::Survey, (window.len()) as u64);
        Ok::<u64, Error>(samples)
    });
    let samples = survey.try_reduce(|| 0, |a, b| Ok(a + b))?;
    control.progress.end(Stage::Survey);
    let (cut, outcome) = find_cut(&curves, &params.goal, samples, error_needs(job)).map_err(failed)??;
    Ok(Some(End { cut, lowest, outcome, survey_bytes: curves.bytes() }))
}

/// Finds out before all work that a budget is too small for the corners of the tiles.
pub(super) fn check_corners(job: &Job<'_>) -> Result<(), GoalTooSmall> {
    let Job { grid, params, .. } = *job;
    let points = (grid.columns() as u64 + 1) * (grid.rows() as u64 + 1);
    params.goal.check(Cost { points, triangles: 2 * grid.len() as u64 })
}

/// The tolerance beyond which samples are candidates: where a quality is asked for, one at which it is reached.
pub(super) fn lowest(job: &Job<'_>) -> f64 {
    let error = job.params.max_error.is_finite().then(|| tolerance(job.params));
    // With all errors within r, so is their root mean square; but weights below 1 allow larger ones.
    let rms = job.params.goal.max_rms.map(|rms| if job.field.importance().is_some() { 0.0 } else { rms });
    error.into_iter().chain(rms).reduce(f64::min).unwrap_or(0.0)
}

/// The last key that the tolerance needs, where a root mean square is asked for, too.
pub(super) fn error_needs(job: &Job<'_>) -> Option<Key> {
    // A little lower, so that no rounding of an error counts.
    job.params.max_error.is_finite().then(|| Key::last_of(tolerance(job.params) * (1.0 - 1e-9)))
}

/// The key of a rim vertex that comes later, and its owner.
fn late_key(grid: TileGrid, id: TileId, vertex: LateVertex) -> (Key, TileId) {
    let (owner, side) = match vertex.side {
        Some(Side::East) if !grid.is_last_column(id) => (TileId { column: id.column + 1, ..id }, Some(Side::West)),
        Some(Side::South) if !grid.is_last_row(id) => (TileId { row: id.row + 1, ..id }, Some(Side::North)),
        side => (id, side),
    };
    // Those inside come after those of the sides.
    let ordinal = side.map_or(4, |side| side as u64) << 32 | vertex.at as u64;
    (Key::of_rim(vertex.level, grid.index(owner) as u64, ordinal), owner)
}

/// What a rim vertex that comes later costs in all, if the tile owns it: a triangle more wherever its line has ground.
fn late_cost(grid: TileGrid, id: TileId, tile: &Tile, vertex: LateVertex) -> Cost {
    if late_key(grid, id, vertex).1 != id {
        return Cost::default();
    }
    let touches = |place: (usize, usize), quadrants: [usize; 2]| {
        let touched = |q: &usize| tile.validity().touches(place.0 as i32, place.1 as i32, *q);
        quadrants.iter().filter(|q| touched(q)).count() as u64
    };
    let triangles = match vertex.side {
        Some(Side::North) if id.row > 0 => touches((vertex.at, 0), [0, 3]),
        Some(Side::West) if id.column > 0 => touches((0, vertex.at), [0, 1]),
        // The raster's rim, or a loop inside.
        _ => 1,
    };
    Cost { points: 1, triangles }
}

/// A tile's rim as far as a cut.
struct Begun {
    rim: Rim,
    /// Its vertices that are not there from the start, by their keys.
    late: Vec<(Key, u32)>,
    /// What those cost, idle ones among them, by their keys.
    costs: Vec<(Key, Cost)>,
    /// How many of those are idle.
    idle: usize,
    /// Vertices that the tile owns from the start.
    points: u64,
}

impl Workspace {
    /// Loads a tile and makes its rim of the vertices up to a cut.
    fn begin(&mut self, job: &Job<'_>, index: usize, lowest: f64, cut: Key) -> Result<Begun, Error> {
        let id = job.grid.tile(index);
        let window = job.grid.window(id);
        job.field.load_with(window, &mut self.tile, &mut self.loading)?;
        self.find_points(job, window)?;
        let last = (job.grid.is_last_column(id), job.grid.is_last_row(id));
        let key = |v: LateVertex| late_key(job.grid, id, v).0;
        let keeps = |v: LateVertex| key(v) <= cut;
        let NestedRim { rim, late, late_idle } =
            Rim::nested(&self.tile, lowest, &self.points, last, keeps, &job.control.cancel)?;
        let all = late.iter().map(|(_, v)| v).chain(&late_idle);
        let mut costs: Vec<(Key, Cost)> = all.map(|&v| (key(v), late_cost(job.grid, id, &self.tile, v))).collect();
        costs.sort_unstable_by_key(|(key, _)| *key);
        let mut late: Vec<(Key, u32)> = late.into_iter().map(|(vertex, v)| (key(v), vertex)).collect();
        late.sort_unstable();
        let owned = rim.domain.fixed().count() + rim.idle.len() - rim.foreign.len();
        let points = owned as u64 - costs.iter().map(|(_, cost)| cost.points).sum::<u64>();
        Ok(Begun { rim, late, costs, idle: late_idle.len(), points })
    }

    /// Finds out how a tile's insertion goes, as far as anybody may want to know. Returns how many samples of it count.
    pub(super) fn tell(
        &mut self,
        job: &Job<'_>,
        options: InsertionOptions,
        index: usize,
        lowest: f64,
        floor: &Floor,
    ) -> Result<u64, Error> {
        let goal = &job.params.goal;
        let cut = floor.cut();
        let Begun { rim, late, costs, idle, points } = self.begin(job, index, lowest, cut)?;
        let id = job.grid.tile(index);
        let (last_column, last_row) = (job.grid.is_last_column(id), job.grid.is_last_row(id));
        let mut counts = Vec::new();
        let (share, samples) = if self.tile.validity().is_whole() {
            let (columns, rows) =
                (self.tile.width() - usize::from(!last_column), self.tile.height() - usize::from(!last_row));
            (Share::Rectangle { last_column, last_row }, columns * rows)
        } else {
            let places =
                (0..self.tile.height()).flat_map(|row| (0..self.tile.width()).map(move |column| (column, row)));
            counts.extend(places.map(|(column, row)| owns(&self.tile, column, row)));
            (Share::Ground(&counts), counts.iter().filter(|c| **c).count())
        };
        let most = goal.max_points.into_iter().chain(goal.max_triangles).min().unwrap_or(u64::MAX);
        let squares = goal.max_rms.is_some().then_some(share);
        let order = Order { rim: &late, tile: index as u64, cut, most, squares };
        self.told.clear();
        let told = &mut self.told;
        if rim.domain.loops.is_empty() {
            told.push(Told { key: Key::FIRST, cost: Cost { points, triangles: 0 }, squares: 0.0 });
        } else {
            let task = task(&self.tile, &rim, lowest, job);
            let engine = GreedyInsertion { options };
            engine.triangulate_in_order(&task, order, self.engine.insertion(), &mut self.mesh, |e| {
                let cost = match costs.binary_search_by_key(&e.key, |(key, _)| *key) {
                    Ok(i) => costs[i].1,
                    Err(_) if e.key == Key::FIRST => Cost { points, triangles: e.triangles },
                    Err(_) => Cost { points: 1, triangles: e.triangles },
                };
                told.push(Told { key: e.key, cost, squares: e.squares });
            })?;
        }
        if idle > 0 {
            // Nobody inserts them here.
            let inserted: Vec<Key> = late.iter().map(|(key, _)| *key).collect();
            let missing = costs.iter().filter(|(key, _)| inserted.binary_search(key).is_err());
            told.extend(missing.map(|&(key, cost)| Told { key, cost, squares: 0.0 }));
            told.sort_unstable_by_key(|t| t.key);
        }
        Ok(samples as u64)
    }

    /// Makes a tile's mesh as far as the end of all.
    pub(super) fn run_to(&mut self, job: &Job<'_>, index: usize, end: &End) -> Result<(Rim, Bound), Error> {
        let EngineChoice::GreedyInsertion(options) = job.params.engine else {
            unreachable!("only greedy insertion has an end to come to")
        };
        let Begun { rim, late, .. } = self.begin(job, index, end.lowest, end.cut)?;
        if rim.domain.loops.is_empty() {
            self.mesh.clear();
            return Ok((rim, end.bound(job)));
        }
        let order = Order { rim: &late, tile: index as u64, cut: end.cut, most: u64::MAX, squares: None };
        let task = task(&self.tile, &rim, end.lowest, job);
        let engine = GreedyInsertion { options };
        engine.triangulate_in_order(&task, order, self.engine.insertion(), &mut self.mesh, |_| ())?;
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
