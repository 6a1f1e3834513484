//! What comes before the first pass under a [`Goal`](crate::job::Goal): every tile tells how its insertion goes, and the
//! place is found where all of them end.
//!
//! It is a step of its own and no [`Pass`](super::Pass), because it makes no chunks: what tiles tell are curves
//! ([`Curves`]), and what comes of all of them together is one [`End`] for all tiles, which every tile of the first pass
//! needs. Tiles tell independently of each other; a [`Floor`] only saves what nobody will want to know.

use std::ops::Range;

use rayon::prelude::*;

use super::pool::Pool;
use super::tiles::{TileMaker, task};
use super::{Job, Workspace};
use crate::base::Tile;
use crate::base::control::Stage;
use crate::base::handed_over::make_room;
use crate::base::tiling::{TileGrid, TileId, TilePlace};
use crate::job::Error;
use crate::job::goal::{Cost, Curves, Floor, GoalTooSmall, Outcome, Told, find_cut};
use crate::job::spool::SpoolError;
use crate::kernel::measure::{Bound, owns};
use crate::kernel::seam::{LateVertex, NestedRim, Rim, Side};
use crate::kernel::triangulate::Progressive;
use crate::kernel::triangulate::progressive::{Key, Order, Share};

/// Where all tiles end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::job) struct End {
    pub(in crate::job) cut: Key,
    /// The tolerance that samples are candidates beyond.
    pub(in crate::job) lowest: f64,
    pub(in crate::job) outcome: Outcome,
    /// Temporary disk that the survey took.
    pub(in crate::job) survey_bytes: u64,
}

/// Has every tile tell how its insertion goes, and finds where all of them end. `None` where there is no goal.
pub(super) fn find_end(job: &Job<'_>) -> Result<Option<End>, Error> {
    let Job { field, params, grid, control, .. } = *job;
    if params.goal.is_none() {
        return Ok(None);
    }
    if !field.may_have_gaps() {
        check_corners(job)?;
    }
    let survey = Survey::new(job, grid.len())?;
    control.progress.begin(Stage::Survey, grid.len() as u64, field.width() as u64 * field.height() as u64);
    let samples = survey.tell(0..grid.len())?;
    control.progress.end(Stage::Survey);
    survey.end(samples).map(Some)
}

/// What tiles tell, and how far they need to go.
struct Survey<'a> {
    job: &'a Job<'a>,
    engine: &'a dyn Progressive,
    lowest: f64,
    floor: Floor,
    curves: Curves,
}

impl<'a> Survey<'a> {
    /// A survey of this number of tiles, of which none has reported yet.
    fn new(job: &'a Job<'a>, tiles: usize) -> Result<Survey<'a>, Error> {
        let engine =
            job.params.engine.progressive().ok_or_else(|| Error::NoStop { engine: job.params.engine.name() })?;
        let lowest = lowest(job);
        let curves = Curves::new(&job.params.temp_dir, tiles).map_err(failed(job))?;
        Ok(Survey { job, engine, lowest, floor: Floor::new(&job.params.goal, lowest), curves })
    }

    /// Has a range of tiles tell. Returns how many of their samples count.
    fn tell(&self, tiles: Range<usize>) -> Result<u64, Error> {
        let Job { grid, control, .. } = *self.job;
        let makers = Pool::default();
        let each = tiles.into_par_iter().map(|index| {
            control.cancel.check()?;
            let place = grid.place(index);
            let samples = makers.with(|maker: &mut TileMaker| {
                let samples = maker.tell(self.job, self.engine, &place, self.lowest, &self.floor)?;
                self.floor.raise(&maker.told);
                self.curves.tell(index, &maker.told, &mut maker.shared.encoded).map_err(failed(self.job))?;
                Ok::<u64, Error>(samples)
            })?;
            control.progress.step(Stage::Survey, place.window.len() as u64);
            Ok::<u64, Error>(samples)
        });
        each.try_reduce(|| 0, |a, b| Ok(a + b))
    }

    /// Where all tiles end, once each has told; `samples` of them count in all.
    fn end(&self, samples: u64) -> Result<End, Error> {
        let Survey { job, lowest, curves, .. } = self;
        let (cut, outcome) = find_cut(curves, &job.params.goal, samples, error_needs(job)).map_err(failed(job))??;
        Ok(End { cut, lowest: *lowest, outcome, survey_bytes: curves.bytes() })
    }
}

fn failed<'a>(job: &Job<'a>) -> impl Fn(std::io::Error) -> SpoolError + use<'a> {
    let dir = &job.params.temp_dir;
    |source| SpoolError::File { dir: dir.clone(), source }
}

/// Finds out before all work that a budget is too small for the corners of the tiles.
pub(in crate::job) fn check_corners(job: &Job<'_>) -> Result<(), GoalTooSmall> {
    let Job { grid, params, .. } = *job;
    let points = (grid.columns() as u64 + 1) * (grid.rows() as u64 + 1);
    params.goal.check(Cost { points, triangles: 2 * grid.len() as u64 })
}

/// The tolerance beyond which samples are candidates: where a quality is asked for, one at which it is reached.
pub(in crate::job) fn lowest(job: &Job<'_>) -> f64 {
    let error = (!job.params.tolerance.is_open()).then(|| job.params.tolerance.kept());
    // With all errors within r, so is their root mean square; but weights below 1 allow larger ones.
    let rms = job.params.goal.max_rms.map(|rms| if job.field.importance().is_some() { 0.0 } else { rms });
    error.into_iter().chain(rms).reduce(f64::min).unwrap_or(0.0)
}

/// The last key that the tolerance needs, where a root mean square is asked for, too.
pub(in crate::job) fn error_needs(job: &Job<'_>) -> Option<Key> {
    // A little lower, so that no rounding of an error counts.
    (!job.params.tolerance.is_open()).then(|| Key::last_of(job.params.tolerance.kept() * (1.0 - 1e-9)))
}

/// The key of a rim vertex that comes later, and its owner.
fn late_key(grid: TileGrid, place: &TilePlace, vertex: LateVertex) -> (Key, TileId) {
    let id = place.id;
    let (owner, side) = match vertex.side {
        Some(Side::East) if !place.last_column => (TileId { column: id.column + 1, ..id }, Some(Side::West)),
        Some(Side::South) if !place.last_row => (TileId { row: id.row + 1, ..id }, Some(Side::North)),
        side => (id, side),
    };
    // Those inside come after those of the sides.
    let ordinal = side.map_or(4, |side| side as u64) << 32 | vertex.at as u64;
    (Key::of_rim(vertex.level, grid.index(owner) as u64, ordinal), owner)
}

/// What a rim vertex that comes later costs in all, if the tile owns it: a triangle more wherever its line has ground.
fn late_cost(grid: TileGrid, place: &TilePlace, tile: &Tile, vertex: LateVertex) -> Cost {
    let id = place.id;
    if late_key(grid, place, vertex).1 != id {
        return Cost::default();
    }
    let touches = |(column, row): (usize, usize), quadrants: [usize; 2]| {
        let touched = |q: &usize| tile.validity().touches(column as i32, row as i32, *q);
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

impl TileMaker {
    /// Loads a tile and makes its rim of the vertices up to a cut.
    fn begin(&mut self, job: &Job<'_>, place: &TilePlace, lowest: f64, cut: Key) -> Result<Begun, Error> {
        self.shared.load(job.field, job.params, place.window)?;
        self.find_points(job, place.window)?;
        let Workspace { tile, points, .. } = &self.shared;
        let key = |v: LateVertex| late_key(job.grid, place, v).0;
        let keeps = |v: LateVertex| key(v) <= cut;
        let NestedRim { rim, late, late_idle } = Rim::nested(tile, lowest, points, place, keeps, &job.control.cancel)?;
        let all = late.iter().map(|(_, v)| v).chain(&late_idle);
        let mut costs: Vec<(Key, Cost)> = all.map(|&v| (key(v), late_cost(job.grid, place, tile, v))).collect();
        costs.sort_unstable_by_key(|(key, _)| *key);
        let mut late: Vec<(Key, u32)> = late.into_iter().map(|(vertex, v)| (key(v), vertex)).collect();
        late.sort_unstable();
        let owned = rim.domain.fixed().count() + rim.idle.len() - rim.foreign.len();
        let points = owned as u64 - costs.iter().map(|(_, cost)| cost.points).sum::<u64>();
        Ok(Begun { rim, late, costs, idle: late_idle.len(), points })
    }

    /// Finds out how a tile's insertion goes, as far as anybody may want to know. Returns how many samples of it count.
    pub(in crate::job) fn tell(
        &mut self,
        job: &Job<'_>,
        engine: &dyn Progressive,
        place: &TilePlace,
        lowest: f64,
        floor: &Floor,
    ) -> Result<u64, Error> {
        let goal = &job.params.goal;
        let cut = floor.cut();
        let Begun { rim, late, costs, idle, points } = self.begin(job, place, lowest, cut)?;
        let tile = &self.shared.tile;
        let mut counts = Vec::new();
        let (share, samples) = if tile.validity().is_whole() {
            let TilePlace { last_column, last_row, .. } = *place;
            (Share::Rectangle { last_column, last_row }, place.owned_samples())
        } else {
            let places = (0..tile.height()).flat_map(|row| (0..tile.width()).map(move |column| (column, row)));
            counts.extend(places.map(|(column, row)| owns(tile, column, row)));
            (Share::Ground(&counts), counts.iter().filter(|c| **c).count() as u64)
        };
        let most = goal.max_points.into_iter().chain(goal.max_triangles).min().unwrap_or(u64::MAX);
        let squares = goal.max_rms.is_some().then_some(share);
        let order = Order { rim: &late, tile: place.index as u64, cut, most, squares };
        make_room(&mut self.told, tile.width() * tile.height() + 1);
        let told = &mut self.told;
        if rim.domain.loops.is_empty() {
            told.push(Told { key: Key::FIRST, cost: Cost { points, triangles: 0 }, squares: 0.0 });
        } else {
            let task = task(&self.shared.tile, &rim.domain, lowest, job);
            engine.triangulate_in_order(&task, order, &mut self.engine, &mut self.mesh, &mut |e| {
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
        Ok(samples)
    }

    /// Makes a tile's mesh as far as the end of all.
    pub(in crate::job) fn run_to(
        &mut self,
        job: &Job<'_>,
        place: &TilePlace,
        end: &End,
    ) -> Result<(Rim, Bound), Error> {
        let Begun { rim, late, .. } = self.begin(job, place, end.lowest, end.cut)?;
        if rim.domain.loops.is_empty() {
            self.mesh.clear();
            return Ok((rim, end.bound(job)));
        }
        let order = Order { rim: &late, tile: place.index as u64, cut: end.cut, most: u64::MAX, squares: None };
        let task = task(&self.shared.tile, &rim.domain, end.lowest, job);
        let engine =
            job.params.engine.progressive().ok_or_else(|| Error::NoStop { engine: job.params.engine.name() })?;
        engine.triangulate_in_order(&task, order, &mut self.engine, &mut self.mesh, &mut |_| ())?;
        Ok((rim, end.bound(job)))
    }
}

impl End {
    /// What the errors of a mesh that ends here are bound by.
    fn bound(&self, job: &Job<'_>) -> Bound {
        if self.outcome.ended_by.is_none() && !job.params.tolerance.is_open() {
            return Bound::Within(job.params.tolerance.kept());
        }
        Bound::Scale(if self.outcome.threshold.is_finite() { self.outcome.threshold } else { 0.0 })
    }

    /// What errors are sorted by, for percentiles.
    pub(in crate::job) fn scale(&self, job: &Job<'_>) -> f64 {
        match self.bound(job) {
            Bound::Within(scale) | Bound::Scale(scale) => scale,
        }
    }
}
