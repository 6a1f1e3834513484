//! How a run keeps to a memory budget.
//!
//! Memory is held by a fixed number of things, each of a size known beforehand, so the budget is kept by structure, not
//! by watching: a pool of one [`super::tiles::Workspace`] per thread, GDAL's block cache of a fixed size, the pages of
//! one window per thread, and what the process has anyway. What does not fit lowers the number of threads; the tile
//! size never follows the budget, because it decides the bytes written.

use crate::raster::Raster;
use crate::tiling::TileGrid;

/// What the process takes before any tile: the program, GDAL and its libraries, the stacks. Measured 42 MiB.
const BASE: u64 = 52 << 20;

/// What one thread needs for a tile, per sample, at the most: as many vertices as samples and twice as many triangles.
///
/// Samples 8 and as they are stored 8, the meter's marks 1, the mesh 16 + 24, its chunk 16 + 24 and the encoded chunk
/// 16 + 24, the nodes of the front and its queues about 40; tiles of half a million triangles took 163.
const BYTES_PER_SAMPLE: u64 = 180;

/// What a channel adds to that: samples 8, the vertices' values in the chunk, as it grows, 16, and encoded 8.
const BYTES_PER_CHANNEL_SAMPLE: u64 = 32;

/// Mapped pages of one window, see `field::store`; in units of the decoder, one unit and one block.
const PER_THREAD: u64 = 9 << 20;

/// Copies of one source block that decoding it takes at a time: in the file, in GDAL's cache, in our window.
const BLOCK_COPIES: u64 = 3;

/// GDAL's block cache, as a share of the budget and within limits.
const CACHE_SHARE: u64 = 10;
const CACHE: std::ops::RangeInclusive<u64> = 8 << 20..=64 << 20;

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
    /// Fits a run over `raster` in tiles of `grid` into `budget_bytes`, with up to `threads` threads.
    ///
    /// # Errors
    /// [`BudgetTooSmall`].
    pub fn new(budget_bytes: u64, raster: &Raster, grid: TileGrid, threads: usize) -> Result<Plan, BudgetTooSmall> {
        Plan::with_channels(budget_bytes, raster, grid, threads, &[])
    }

    /// The same for a run with these bands of `raster` as channels.
    ///
    /// # Errors
    /// [`BudgetTooSmall`].
    pub fn with_channels(
        budget_bytes: u64,
        raster: &Raster,
        grid: TileGrid,
        threads: usize,
        channels: &[Raster],
    ) -> Result<Plan, BudgetTooSmall> {
        let (block_width, block_height) = raster.block_size();
        let block = (block_width * block_height * raster.sample_type().bytes()) as u64;
        // Blocks of bands that are interleaved are decoded together.
        let blocks =
            channels.iter().fold(block, |sum, c| sum + (block_width * block_height * c.sample_type().bytes()) as u64);
        let bytes_per_sample = BYTES_PER_SAMPLE + channels.len() as u64 * BYTES_PER_CHANNEL_SAMPLE;
        let cache_bytes = (budget_bytes / CACHE_SHARE).clamp(*CACHE.start(), *CACHE.end());
        let fixed = BASE + cache_bytes;
        let per_thread = |samples: usize| samples as u64 * bytes_per_sample + PER_THREAD + BLOCK_COPIES * blocks;
        let each = per_thread(grid.largest());
        let fitting = budget_bytes.saturating_sub(fixed) / each;
        if fitting == 0 {
            // The smallest cache goes with the smallest budget.
            let smallest_bytes = (BASE + *CACHE.start() + each).next_multiple_of(1 << 20);
            let fits = |cells: &usize| BASE + cache_bytes + per_thread((cells + 1) * (cells + 1)) <= budget_bytes;
            let tile = (1..=64).rev().map(|i| i * 32).find(fits);
            if smallest_bytes > budget_bytes {
                return Err(BudgetTooSmall { budget_bytes, smallest_bytes, tile });
            }
        }
        let threads = (fitting.max(1) as usize).min(threads);
        let cache_bytes = if fitting == 0 { *CACHE.start() } else { cache_bytes };
        Ok(Plan { budget_bytes, threads, cache_bytes, needed_bytes: BASE + cache_bytes + threads as u64 * each })
    }
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
