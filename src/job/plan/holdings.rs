//! What a process holds of memory, and how that fits into a budget: by fewer threads, where it does not.

use crate::base::Band;

/// What the process takes before any tile: the program, GDAL and its libraries, the stacks. Measured 57 MiB, of which 46 are
/// pages of the libraries.
pub(super) const BASE: u64 = 60 << 20;

/// What a cutline takes per vertex: its sides, in lists that grow by doubling; and each thread for those that cross its tile.
const BYTES_PER_CUTLINE_VERTEX: u64 = 64;

/// Mapped pages of one window while it is copied, see `field::store`; in units of the decoder, one unit and one block.
pub(super) const PAGES: u64 = 9 << 20;

/// Copies of one source block that decoding it takes at a time: in the file, in GDAL's cache, in our window.
pub(super) const BLOCK_COPIES: u64 = 3;

/// What a thread has beside its tile: its stack, the rim, the statistics of errors.
pub(super) const BESIDE: u64 = 256 << 10;

/// GDAL's block cache, as a share of the budget and within limits.
const CACHE_SHARE: u64 = 10;
const CACHE: std::ops::RangeInclusive<u64> = 8 << 20..=64 << 20;

/// What a process holds at a time, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Holdings {
    /// Whatever the number of threads, but for GDAL's cache.
    pub(crate) base: u64,
    /// What the cache comes to at the most: all blocks of all bands.
    pub(crate) cacheable: u64,
    /// What each thread holds.
    pub(crate) each: u64,
    /// What all threads together hold at some time at the least, however few they are.
    pub(crate) least: u64,
}

/// How a process fits into a budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Fitted {
    /// The budget.
    pub budget_bytes: u64,
    /// Threads that work at a time.
    pub threads: usize,
    /// GDAL's block cache. In a process that is not terrabite's own it is bounded by `GDAL_CACHEMAX` instead.
    pub cache_bytes: u64,
    /// What is held at the most.
    pub needed_bytes: u64,
}

/// GDAL's block cache, before it is known whether that leaves enough.
pub(super) fn share(budget_bytes: u64) -> u64 {
    (budget_bytes / CACHE_SHARE).clamp(*CACHE.start(), *CACHE.end())
}

impl Holdings {
    /// What reading windows of a band takes, the process itself included.
    #[cfg(feature = "gdal")]
    pub(crate) fn of_reading(band: &Band) -> Holdings {
        let cutline = cutline_bytes(band);
        let each = BESIDE + PAGES + cutline + BLOCK_COPIES * block_bytes(band);
        Holdings { base: BASE + cutline, cacheable: cacheable_bytes(band), each, least: 0 }
    }

    /// What the process itself takes.
    #[cfg(feature = "gdal")]
    pub(crate) fn of_process() -> Holdings {
        Holdings { base: BASE, cacheable: 0, each: BESIDE, least: 0 }
    }

    /// All but what threads hold.
    pub(super) fn fixed(&self, cache_bytes: u64) -> u64 {
        self.base + cache_bytes.min(self.cacheable)
    }

    /// What so many threads hold, and all else.
    fn needed(&self, cache_bytes: u64, threads: usize) -> u64 {
        self.fixed(cache_bytes) + (threads as u64 * self.each).max(self.least)
    }

    /// Whether one thread keeps to a budget.
    pub(super) fn fits(&self, cache_bytes: u64, budget_bytes: u64) -> bool {
        self.needed(cache_bytes, 1) <= budget_bytes
    }

    /// Fits them into a budget, with up to `threads` threads.
    ///
    /// # Errors
    /// [`BudgetTooSmall`], which does not say what tile would fit.
    pub(crate) fn fit(&self, budget_bytes: u64, threads: usize) -> Result<Fitted, BudgetTooSmall> {
        let share = share(budget_bytes);
        // The smallest cache goes with the smallest budget.
        let cache_bytes = if self.fits(share, budget_bytes) { share } else { *CACHE.start() };
        if !self.fits(cache_bytes, budget_bytes) {
            let smallest_bytes = self.needed(*CACHE.start(), 1).next_multiple_of(1 << 20);
            return Err(BudgetTooSmall { budget_bytes, smallest_bytes, tile: None });
        }
        let fitting = budget_bytes.saturating_sub(self.fixed(share)) / self.each;
        let threads = (fitting.max(1) as usize).min(threads);
        Ok(Fitted { budget_bytes, threads, cache_bytes, needed_bytes: self.needed(cache_bytes, threads) })
    }
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

pub(crate) fn mebibytes(bytes: u64) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

fn tile_hint(tile: Option<usize>) -> String {
    tile.map_or(String::new(), |cells| format!("; a tile of {cells} cells would fit it"))
}

pub(super) fn cutline_bytes(band: &Band) -> u64 {
    band.cutline().map_or(0, |c| c.counts().1) * BYTES_PER_CUTLINE_VERTEX
}

pub(super) fn cacheable_bytes(band: &Band) -> u64 {
    let (width, height) = band.block_size();
    let sides = [(band.width(), width), (band.height(), height)].map(|(len, block)| (len + 2 * block) as u64);
    sides[0].saturating_mul(sides[1]).saturating_mul(band.sample_type().bytes() as u64)
}

pub(super) fn block_bytes(band: &Band) -> u64 {
    let (width, height) = band.block_size();
    (width * height * band.sample_type().bytes()) as u64
}
