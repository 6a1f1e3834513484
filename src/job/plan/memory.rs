//! How a run keeps to a memory budget.
//!
//! Memory is held by a fixed number of things, each of a size known beforehand, so the budget is kept by structure, not
//! by watching: a pool of one `TileMaker` per thread, GDAL's block cache of a fixed size, the pages of
//! one window per thread, and what the process has anyway. What does not fit lowers the number of threads; the tile
//! size never follows the budget, because it decides the bytes written.
//!
//! `stages` says what a thread holds of a tile. When all tiles are there, one chunk at a time is written, and what tiles
//! took is gone.

use super::holdings::{
    BASE, BESIDE, BLOCK_COPIES, BudgetTooSmall, Fitted, Holdings, PAGES, block_bytes, cacheable_bytes, cutline_bytes,
    share,
};
use super::stages::{samples_bytes, thread_bytes, writing_bytes};
use crate::base::Band;
use crate::base::features::Feature;
use crate::base::tiling::TileGrid;
use crate::job::Params;

/// What the set of all points takes per point, see `PointSet`.
const BYTES_PER_POINT: u64 = 8;

/// What one thread needs for a point of its tile: twice its place, in lists that grow by doubling, and its vertex.
const TILE_BYTES_PER_POINT: u64 = 80;

/// What a goal takes beside tiles: how far they have to tell, and where all of them end.
const GOAL: u64 = 5 << 20;

/// What a run has to work on.
#[derive(Debug, Clone, Copy)]
pub struct Load<'a> {
    /// The heights.
    pub band: &'a Band,
    /// The weights, where there are any.
    pub importance: Option<&'a Band>,
    /// The bands that are channels.
    pub channels: &'a [Band],
    /// The tiles.
    pub grid: TileGrid,
    /// What is made of them: the engine, polishing, goals, trimming.
    pub params: &'a Params,
    /// How many samples must be vertices.
    pub points: usize,
    /// What breaklines take.
    pub lines_bytes: u64,
    /// Whether holes are bridged.
    pub holes: bool,
    /// Whether the mesh becomes a solid.
    pub solid: bool,
    /// Whether vertices have normals.
    pub normals: bool,
}

impl<'a> Load<'a> {
    /// A raster and nothing else.
    pub fn of(band: &'a Band, grid: TileGrid, params: &'a Params) -> Load<'a> {
        Load {
            band,
            importance: None,
            channels: &[],
            grid,
            params,
            points: 0,
            lines_bytes: 0,
            holes: false,
            solid: false,
            normals: false,
        }
    }

    /// The heights, the weights, the channels.
    /// Whether there is a goal that insertion stops at.
    pub(super) fn stops_in_order(&self) -> bool {
        let voids = self.holes.then_some(Feature::FilledVoids);
        let attributes = (!self.channels.is_empty()).then_some(Feature::Attributes);
        !self.params.goal.is_none() && !self.params.is_searched(voids.into_iter().chain(attributes).collect())
    }

    pub(super) fn bands(&self) -> impl Iterator<Item = &'a Band> {
        std::iter::once(self.band).chain(self.importance).chain(self.channels)
    }
}

/// How a run fits into a budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Plan {
    /// The budget.
    pub budget_bytes: u64,
    /// Threads that work at a time.
    pub threads: usize,
    /// GDAL's block cache. In a process that is not terrabite's own it is bounded by `GDAL_CACHEMAX` instead.
    pub cache_bytes: u64,
    /// What the run holds at the most.
    pub needed_bytes: u64,
    /// What may be held beside the fixed things while no tile is worked on.
    #[serde(skip)]
    pub before_tiles_bytes: u64,
}

impl Plan {
    /// Fits a run into `budget_bytes`, with up to `threads` threads.
    ///
    /// # Errors
    /// [`BudgetTooSmall`].
    pub fn new(budget_bytes: u64, load: &Load<'_>, threads: usize) -> Result<Plan, BudgetTooSmall> {
        let reckoning = Reckoning::new(load);
        let samples = load.grid.largest();
        let holdings = reckoning.holdings(samples);
        let fitted = holdings.fit(budget_bytes, threads).map_err(|error| {
            let fits = |cells: &usize| reckoning.holdings((cells + 1).pow(2)).fits(share(budget_bytes), budget_bytes);
            BudgetTooSmall { tile: (1..=64).rev().map(|i| i * 32).find(fits), ..error }
        })?;
        let Fitted { threads, cache_bytes, needed_bytes, .. } = fitted;
        let beside_tiles = threads as u64 * (PAGES + reckoning.per_thread);
        let before_tiles_bytes = budget_bytes.saturating_sub(holdings.fixed(cache_bytes) + beside_tiles);
        Ok(Plan { budget_bytes, threads, cache_bytes, needed_bytes, before_tiles_bytes })
    }
}

/// What a run holds, whatever the budget.
struct Reckoning<'a> {
    load: &'a Load<'a>,
    /// As [`Holdings::base`].
    base: u64,
    /// As [`Holdings::cacheable`].
    cacheable: u64,
    /// What a thread holds, whatever the tile.
    per_thread: u64,
}

impl<'a> Reckoning<'a> {
    fn new(load: &'a Load<'a>) -> Reckoning<'a> {
        let cutline = cutline_bytes(load.band);
        // Blocks of bands that are interleaved are decoded together.
        let blocks: u64 = load.bands().map(block_bytes).sum();
        let cacheable = load.bands().map(cacheable_bytes).sum();
        let goal = if load.stops_in_order() { GOAL } else { 0 };
        let base = BASE + load.points as u64 * BYTES_PER_POINT + load.lines_bytes + cutline + goal;
        Reckoning { load, base, cacheable, per_thread: BESIDE + cutline + BLOCK_COPIES * blocks }
    }

    /// What a process holds whose tiles have this many samples. While samples are copied, the tile has nothing else yet.
    fn holdings(&self, samples: usize) -> Holdings {
        let points = samples.min(self.load.points) as u64 * TILE_BYTES_PER_POINT;
        let loading = samples as u64 * samples_bytes(self.load) + PAGES;
        let each = thread_bytes(self.load, samples as u64).max(loading) + points + self.per_thread;
        let Reckoning { base, cacheable, .. } = *self;
        Holdings { base, cacheable, each, least: writing_bytes(self.load, samples as u64) }
    }
}
