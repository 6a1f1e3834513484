//! How a run keeps to a memory budget.
//!
//! Memory is held by a fixed number of things, each of a size known beforehand, so the budget is kept by structure, not
//! by watching: a pool of one `TileMaker` per thread, GDAL's block cache of a fixed size, the pages of
//! one window per thread, and what the process has anyway. What does not fit lowers the number of threads; the tile
//! size never follows the budget, because it decides the bytes written.

use crate::base::Band;
use crate::base::tiling::TileGrid;
use crate::job::{EngineChoice, Quality};

/// What the process takes before any tile: the program, GDAL and its libraries, the stacks. Measured 42 MiB.
const BASE: u64 = 52 << 20;

/// What weights add to what a thread needs, per sample: 8 themselves, and 4 as heights are double then, whatever their
/// type.
const BYTES_PER_WEIGHT: u64 = 12;

/// What bridged holes add to what a thread needs, per sample: that of weights, which say where no tolerance binds, a flag,
/// and the place and height of a sample that is bridged.
const BYTES_PER_BRIDGED: u64 = BYTES_PER_WEIGHT + 1 + 16;

/// What the set of all points takes per point, see `PointSet`.
const BYTES_PER_POINT: u64 = 8;

/// What one thread needs for a point of its tile: twice its place, in lists that grow by doubling, and its vertex.
const TILE_BYTES_PER_POINT: u64 = 80;

/// What a cutline takes per vertex: its sides, in lists that grow by doubling; and each thread for those that cross its tile.
const BYTES_PER_CUTLINE_VERTEX: u64 = 64;

/// What a channel adds to that: samples 8, the vertices' values in the chunk, as it grows, 16, and encoded 8.
const BYTES_PER_CHANNEL_SAMPLE: u64 = 32;

/// What trimming adds to that, see [`crate::kernel::boundary`]: 3 bytes and, where every sample is a vertex of a loop, 72 for that.
const BYTES_PER_TRIMMED_SAMPLE: u64 = 75;

/// Mapped pages of one window, see `field::store`; in units of the decoder, one unit and one block.
const PER_THREAD: u64 = 9 << 20;

/// Copies of one source block that decoding it takes at a time: in the file, in GDAL's cache, in our window.
const BLOCK_COPIES: u64 = 3;

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
    /// What triangulates them.
    pub engine: EngineChoice,
    /// How they are polished.
    pub quality: Quality,
    /// How many cells the rim may lose.
    pub trim: u32,
    /// How many samples must be vertices.
    pub points: usize,
    /// Whether holes are bridged.
    pub holes: bool,
}

impl<'a> Load<'a> {
    /// A raster and nothing else, by the engine that is the default.
    pub fn of(band: &'a Band, grid: TileGrid) -> Load<'a> {
        let (engine, quality) = (EngineChoice::default(), Quality::default());
        Load { band, importance: None, channels: &[], grid, engine, quality, trim: 0, points: 0, holes: false }
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
        let Load { band, importance, channels, grid, engine, quality, trim, points, holes } = *load;
        // Blocks of bands that are interleaved are decoded together.
        let blocks = block_bytes(band) + importance.into_iter().chain(channels).map(block_bytes).sum::<u64>();
        let weights = if importance.is_some() { BYTES_PER_WEIGHT } else { 0 };
        let weights = if holes { BYTES_PER_BRIDGED } else { weights };
        let trimming = if trim > 0 { BYTES_PER_TRIMMED_SAMPLE } else { 0 };
        let channels = channels.len() as u64 * BYTES_PER_CHANNEL_SAMPLE;
        let per_sample = engine.bytes_per_sample() + quality.bytes_per_sample() + weights + channels + trimming;
        let cache_bytes = (budget_bytes / CACHE_SHARE).clamp(*CACHE.start(), *CACHE.end());
        let cutline = band.cutline().map_or(0, |c| c.counts().1) * BYTES_PER_CUTLINE_VERTEX;
        let base = BASE + points as u64 * BYTES_PER_POINT + cutline;
        let fixed = base + cache_bytes;
        let per_thread = |samples: usize| {
            let points = samples.min(points) as u64 * TILE_BYTES_PER_POINT;
            samples as u64 * per_sample + points + cutline + PER_THREAD + BLOCK_COPIES * blocks
        };
        let each = per_thread(grid.largest());
        let fitting = budget_bytes.saturating_sub(fixed) / each;
        if fitting == 0 {
            // The smallest cache goes with the smallest budget.
            let smallest_bytes = (base + *CACHE.start() + each).next_multiple_of(1 << 20);
            let fits = |cells: &usize| base + cache_bytes + per_thread((cells + 1) * (cells + 1)) <= budget_bytes;
            let tile = (1..=64).rev().map(|i| i * 32).find(fits);
            if smallest_bytes > budget_bytes {
                return Err(BudgetTooSmall { budget_bytes, smallest_bytes, tile });
            }
        }
        let threads = (fitting.max(1) as usize).min(threads);
        let cache_bytes = if fitting == 0 { *CACHE.start() } else { cache_bytes };
        let needed_bytes = base + cache_bytes + threads as u64 * each;
        let tiles = threads as u64 * grid.largest() as u64 * per_sample;
        let before_tiles_bytes = (budget_bytes + tiles).saturating_sub(needed_bytes);
        Ok(Plan { budget_bytes, threads, cache_bytes, needed_bytes, before_tiles_bytes })
    }
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
