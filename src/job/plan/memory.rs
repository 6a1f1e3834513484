//! How a run keeps to a memory budget.
//!
//! Memory is held by a fixed number of things, each of a size known beforehand, so the budget is kept by structure, not
//! by watching: a pool of one `TileMaker` per thread, GDAL's block cache of a fixed size, the pages of
//! one window per thread, and what the process has anyway. What does not fit lowers the number of threads; the tile
//! size never follows the budget, because it decides the bytes written.
//!
//! `stages` says what a thread holds of a tile. When all tiles are there, one chunk at a time is written, and what tiles
//! took is gone.

use super::stages::{samples_bytes, thread_bytes, writing_bytes};
use crate::base::Band;
use crate::base::features::Feature;
use crate::base::tiling::TileGrid;
use crate::job::Params;

/// What the process takes before any tile: the program, GDAL and its libraries, the stacks. Measured 57 MiB, of which 46 are
/// pages of the libraries.
const BASE: u64 = 60 << 20;

/// What the set of all points takes per point, see `PointSet`.
const BYTES_PER_POINT: u64 = 8;

/// What one thread needs for a point of its tile: twice its place, in lists that grow by doubling, and its vertex.
const TILE_BYTES_PER_POINT: u64 = 80;

/// What a cutline takes per vertex: its sides, in lists that grow by doubling; and each thread for those that cross its tile.
const BYTES_PER_CUTLINE_VERTEX: u64 = 64;

/// Mapped pages of one window while it is copied, see `field::store`; in units of the decoder, one unit and one block.
const PAGES: u64 = 9 << 20;

/// Copies of one source block that decoding it takes at a time: in the file, in GDAL's cache, in our window.
const BLOCK_COPIES: u64 = 3;

/// What a thread has beside its tile: its stack, the rim, the statistics of errors.
pub(super) const BESIDE: u64 = 256 << 10;

/// What a goal takes beside tiles: how far they have to tell, and where all of them end.
const GOAL: u64 = 5 << 20;

/// GDAL's block cache, as a share of the budget and within limits.
const CACHE_SHARE: u64 = 10;
const CACHE: std::ops::RangeInclusive<u64> = 8 << 20..=64 << 20;

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
    /// GDAL's block cache.
    pub cache_bytes: u64,
    /// What the run holds at the most.
    pub needed_bytes: u64,
    /// What may be held beside the fixed things while no tile is worked on.
    #[serde(skip)]
    pub before_tiles_bytes: u64,
}

/// The budget is too small for even one thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("expected a memory budget of at least {}, found {}{}", mebibytes(*.smallest_bytes), mebibytes(*.budget_bytes), tile_hint(*.tile))]
pub struct BudgetTooSmall {
    /// The budget.
    pub budget_bytes: u64,
    /// The smallest budget that works with this raster and tile size.
    pub smallest_bytes: u64,
    /// The largest tile that fits the budget, in cells; `None` where none does.
    pub tile: Option<usize>,
}

fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

fn tile_hint(tile: Option<usize>) -> String {
    tile.map_or(String::new(), |cells| format!("; a tile of {cells} cells would fit it"))
}

impl Plan {
    /// Fits a run into `budget_bytes`, with up to `threads` threads.
    ///
    /// # Errors
    /// [`BudgetTooSmall`].
    pub fn new(budget_bytes: u64, load: &Load<'_>, threads: usize) -> Result<Plan, BudgetTooSmall> {
        let reckoning = Reckoning::new(load);
        let share = (budget_bytes / CACHE_SHARE).clamp(*CACHE.start(), *CACHE.end());
        let samples = load.grid.largest();
        let (each, writing) = (reckoning.of_thread(samples), writing_bytes(load, samples as u64));
        let fitting = budget_bytes.saturating_sub(reckoning.fixed(share)) / each;
        let fits = |cache: u64, each: u64| reckoning.fixed(cache) + each.max(writing) <= budget_bytes;
        // The smallest cache goes with the smallest budget.
        let cache_bytes = if fits(share, each) { share } else { *CACHE.start() };
        if !fits(cache_bytes, each) {
            let smallest_bytes = (reckoning.fixed(*CACHE.start()) + each.max(writing)).next_multiple_of(1 << 20);
            let tile = (1..=64)
                .rev()
                .map(|i| i * 32)
                .find(|cells: &usize| reckoning.fits(share, (cells + 1).pow(2), budget_bytes));
            return Err(BudgetTooSmall { budget_bytes, smallest_bytes, tile });
        }
        let threads = (fitting.max(1) as usize).min(threads);
        let busy = threads as u64;
        let needed_bytes = reckoning.fixed(cache_bytes) + (busy * each).max(writing);
        let before_tiles_bytes =
            budget_bytes.saturating_sub(reckoning.fixed(cache_bytes) + busy * (PAGES + reckoning.per_thread));
        Ok(Plan { budget_bytes, threads, cache_bytes, needed_bytes, before_tiles_bytes })
    }
}

/// What a run holds, whatever the budget.
struct Reckoning<'a> {
    load: &'a Load<'a>,
    /// Whatever the number of threads, but for the cache.
    base: u64,
    /// What the cache comes to at the most: all blocks of all bands.
    cacheable: u64,
    /// Whatever the tile.
    per_thread: u64,
}

impl<'a> Reckoning<'a> {
    fn new(load: &'a Load<'a>) -> Reckoning<'a> {
        let cutline = load.band.cutline().map_or(0, |c| c.counts().1) * BYTES_PER_CUTLINE_VERTEX;
        // Blocks of bands that are interleaved are decoded together.
        let blocks: u64 = load.bands().map(block_bytes).sum();
        let cacheable = load.bands().map(cacheable_bytes).sum();
        let goal = if load.stops_in_order() { GOAL } else { 0 };
        let base = BASE + load.points as u64 * BYTES_PER_POINT + load.lines_bytes + cutline + goal;
        Reckoning { load, base, cacheable, per_thread: BESIDE + cutline + BLOCK_COPIES * blocks }
    }

    /// All but what threads hold.
    fn fixed(&self, cache_bytes: u64) -> u64 {
        self.base + cache_bytes.min(self.cacheable)
    }

    /// What a thread holds with a tile of so many samples. While these are copied, nothing else is there of the tile.
    fn of_thread(&self, samples: usize) -> u64 {
        let points = samples.min(self.load.points) as u64 * TILE_BYTES_PER_POINT;
        let loading = samples as u64 * samples_bytes(self.load) + PAGES;
        thread_bytes(self.load, samples as u64).max(loading) + points + self.per_thread
    }

    /// Whether one thread with tiles of so many samples keeps to a budget.
    fn fits(&self, cache_bytes: u64, samples: usize, budget_bytes: u64) -> bool {
        let tile = self.of_thread(samples).max(writing_bytes(self.load, samples as u64));
        self.fixed(cache_bytes) + tile <= budget_bytes
    }
}

fn cacheable_bytes(band: &Band) -> u64 {
    let (width, height) = band.block_size();
    let sides = [(band.width(), width), (band.height(), height)].map(|(len, block)| (len + 2 * block) as u64);
    sides[0].saturating_mul(sides[1]).saturating_mul(band.sample_type().bytes() as u64)
}

fn block_bytes(band: &Band) -> u64 {
    let (width, height) = band.block_size();
    (width * height * band.sample_type().bytes()) as u64
}

/// The budget where none is given: a quarter of what the machine or its control group has, at most 2 GiB.
pub fn default_budget() -> u64 {
    const MOST: u64 = 2 << 30;
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| {
        let line = text.lines().find_map(|l| l.strip_prefix("MemTotal:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok().map(|kib| kib << 10)
    });
    // Version 2, then version 1; "max", or a number near 2⁶³, is no limit.
    let group = cgroup_files().into_iter().filter_map(|path| read(&path)?.trim().parse::<u64>().ok()).min();
    machine.into_iter().chain(group).min().map_or(MOST, |bytes| (bytes / 4).min(MOST))
}

/// Where the memory limits of this process's control groups stand, inside a container and outside.
fn cgroup_files() -> Vec<String> {
    let mut files =
        vec!["/sys/fs/cgroup/memory.max".to_string(), "/sys/fs/cgroup/memory/memory.limit_in_bytes".to_string()];
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        if let (Some(controllers), Some(path)) = (parts.next(), parts.next()) {
            match controllers {
                "" => files.push(format!("/sys/fs/cgroup{path}/memory.max")),
                c if c.split(',').any(|c| c == "memory") => {
                    files.push(format!("/sys/fs/cgroup/memory{path}/memory.limit_in_bytes"));
                }
                _ => {}
            }
        }
    }
    files
}
