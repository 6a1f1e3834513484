//! How tiles keep to a memory budget: by fewer threads, and fewer that have a large tile at a time.
//!
//! What a thread holds has a bound: that of a part while it is made, of an ordinary tile while it is measured, of the raster's samples
//! while they are brought to the grid, whichever is the largest. Tiles of more triangles are large: whoever has one waits for a
//! permit, of which there are as many as the budget has room for, and at least one. A tile that has more vertices than the format numbers is
//! refused before it is measured. None of it decides a byte.

use std::borrow::Cow;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use super::encode::MOST_VERTICES;
use super::error::PyramidError;
use super::facet::POLAR_BYTES;
use super::grid::{Grid, Level, TileKey};
use super::ground::{Ground, levels_of};
use super::measure::BYTES_PER_TRIANGLE;
use super::own;
use super::prepare::Prepared;
use super::source::{Area, MOST_OF_BLOCK};
use super::store::{BLOCK, CACHE_BYTES};
use super::{Judging, TilesRequest};
use crate::base::handed_over::KEPT_BYTES;
use crate::job::plan::{Fitted, Holdings, POLISHING, all_cores, default_budget};
use crate::kernel::triangulate::Engine;
use crate::kernel::triangulate::insertion::GreedyInsertion;
use crate::raster::bound_gdal_cache;

/// Vertices that a part is given by its engine at the most: a tile of two thirds of them cannot be written.
pub(super) const MOST_IN_PART: usize = MOST_VERTICES + MOST_VERTICES / 2;

/// Samples of a part at the most.
const SAMPLES_OF_PART: u64 = 513 * 513;

/// What a sample of a part takes: its height, above the ellipsoid and above a plane, and weight, whether it has one, is outside or in a void, and which are near
/// such.
const BYTES_PER_SAMPLE: u64 = 2 * 8 + 8 + 1 + 2 + 2;

/// Triangles up to which tiles are ordinary ones.
const ORDINARY: usize = 48 << 10;

/// Triangles of a tile at the most: two for each vertex.
const MOST_TRIANGLES: usize = 2 * MOST_VERTICES;

/// What a thread keeps while it works on anything: blocks that it has read, and ways to transform places.
const BESIDE: u64 = CACHE_BYTES + (2 << 20);

/// What the finest grid takes in memory for each of its blocks: whether it has heights, its checksum, and both as they are kept.
const BYTES_PER_BLOCK: u64 = 24;

/// What a tile takes, of whichever level, as long as the set is made: its relief, its key, and what came of it.
const BYTES_PER_TILE: u64 = 200;

/// What a sample takes on a line that a part's side is looked for on: its height, above the ellipsoid and above a plane, whether it is inside and free, its limit, the best way
/// from it to the end.
const BYTES_ON_LINE: u64 = 108;

/// What a sample of the raster itself takes while its place is found: as read, with its place and block, once more while they are sorted, and
/// as it is written, in a list that grows by doubling.
const BYTES_TO_PLACE: u64 = (8 + 8 + 1) + 40 + 40 + 36;

/// What those take that are beside a line: as read, and as they bind the side.
const BYTES_BESIDE_LINE: u64 = 40 + 72 + 72 / 2;

/// Those that a thread has of a tile while it is measured.
const OWN_OF_TILE: u64 = 24 << 20;

/// What a tile takes that is only looked for: its file, and itself compressed.
const FOUND_TILE: u64 = 4 << 20;

/// The memory of a run, and its threads.
pub(super) struct Memory {
    pub(super) fitted: Fitted,
    permits: Permits,
}

impl Memory {
    /// For bringing samples to the grid.
    pub(super) fn to_bring(prepared: &Prepared, request: &TilesRequest) -> Result<Memory, PyramidError> {
        let (reading, extent) =
            (Holdings::of_reading(&prepared.raster.to_band()?), Extent::of_raster(prepared, request)?);
        let each = reading.each + bringing(request) + BESIDE;
        Memory::fit(request, Holdings { base: reading.base + extent.common(), each, ..reading }, None)
    }

    /// For that, and for making tiles.
    pub(super) fn to_make(prepared: &Prepared, request: &TilesRequest) -> Result<Memory, PyramidError> {
        let (reading, extent) =
            (Holdings::of_reading(&prepared.raster.to_band()?), Extent::of_raster(prepared, request)?);
        let each = (reading.each + bringing(request)).max(making(&extent, request)) + BESIDE;
        Memory::fit(request, Holdings { base: reading.base + extent.common(), each, ..reading }, Some(&extent))
    }

    /// For making tiles from samples that are there.
    pub(super) fn to_work(ground: &Ground, request: &TilesRequest) -> Result<Memory, PyramidError> {
        let (process, extent) = (Holdings::of_process(), Extent::of_ground(ground));
        let each = process.each + making(&extent, request) + BESIDE;
        Memory::fit(request, Holdings { base: process.base + extent.common(), each, ..process }, Some(&extent))
    }

    /// For putting together tiles that are there.
    pub(super) fn to_merge(ground: &Ground, request: &TilesRequest) -> Result<Memory, PyramidError> {
        let (process, extent) = (Holdings::of_process(), Extent::of_ground(ground));
        let each = process.each + FOUND_TILE;
        Memory::fit(request, Holdings { base: process.base + extent.common(), each, ..process }, None)
    }

    /// For judging tiles on a grid.
    pub(super) fn to_judge(
        prepared: &Prepared,
        grid: Grid,
        judging: Judging,
        request: &TilesRequest,
    ) -> Result<Memory, PyramidError> {
        let reading = Holdings::of_reading(&prepared.raster.to_band()?);
        let extent = Extent { grid, area: prepared.source.area(grid)?, levels: [][..].into() };
        let each = reading.each + bringing(request).max(judging.each) + BESIDE;
        let base = reading.base + extent.common() + judging.in_common;
        Memory::fit(request, Holdings { base, each, ..reading }, None)
    }

    /// `extent`: where tiles are made.
    fn fit(request: &TilesRequest, holdings: Holdings, extent: Option<&Extent<'_>>) -> Result<Memory, PyramidError> {
        let wanted = request.threads.map_or_else(all_cores, usize::from);
        let budget = request.memory.unwrap_or_else(default_budget);
        let large = extent.map_or(0, Extent::large);
        let mut fitted = Holdings { base: holdings.base + large, ..holdings }.fit(budget, wanted)?;
        let left = fitted.budget_bytes - fitted.needed_bytes;
        let more = left.checked_div(large).unwrap_or(0).min(fitted.threads as u64 - 1);
        fitted.needed_bytes += more * large;
        bound_gdal_cache(fitted.cache_bytes);
        Ok(Memory { fitted, permits: Permits::new(1 + more as usize) })
    }

    /// So many threads that have all the room that they may need.
    #[cfg(test)]
    pub(super) fn of_threads(threads: usize) -> Memory {
        let fitted = Holdings::of_process().fit(u64::MAX, threads).expect("room");
        Memory { fitted, permits: Permits::new(threads) }
    }

    /// Does something on its threads.
    pub(super) fn install<T: Send>(
        &self,
        work: impl FnOnce() -> Result<T, PyramidError> + Send,
    ) -> Result<T, PyramidError> {
        let threads = self.fitted.threads;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_err(|e| PyramidError::Threads { threads, reason: e.to_string() })?.install(work)
    }

    /// The room of a tile, before it is made.
    pub(super) fn room(&self) -> Room<'_> {
        Room { permits: &self.permits, is_large: false }
    }
}

/// The samples of the grid, as far as they are known before they are.
struct Extent<'a> {
    grid: Grid,
    area: Area,
    levels: Cow<'a, [Level]>,
}

impl Extent<'_> {
    fn of_raster(prepared: &Prepared, request: &TilesRequest) -> Result<Extent<'static>, PyramidError> {
        let grid = prepared.source.grid(request.grid_factor.trailing_zeros())?;
        let levels = levels_of(&prepared.body, grid, request)?;
        Ok(Extent { grid, area: prepared.source.area(grid)?, levels: levels.into() })
    }

    fn of_ground(ground: &Ground) -> Extent<'_> {
        Extent { grid: ground.samples.grid, area: ground.samples.area, levels: (&ground.levels).into() }
    }

    /// What a triangle takes while its tile is measured.
    fn triangle(&self) -> u64 {
        let near = self.grid.rows() / 90;
        let is_polar = self.area.row < near || self.area.row + self.area.height as i64 > self.grid.rows() - near;
        BYTES_PER_TRIANGLE + if is_polar { POLAR_BYTES } else { 0 }
    }

    /// What a large tile takes beside what an ordinary one does.
    fn large(&self) -> u64 {
        (MOST_TRIANGLES - ORDINARY) as u64 * self.triangle()
    }

    /// What is held in common: what is known of blocks and tiles.
    fn common(&self) -> u64 {
        let (width, height) = (self.area.width as u64, self.area.height as u64);
        let count = |cells: u64| (width / cells + 2) * (height / cells + 2);
        let tiles: u64 = self.levels.iter().map(|level| count(self.grid.cells(level.level) as u64)).sum();
        count(BLOCK as u64) * BYTES_PER_BLOCK + tiles * BYTES_PER_TILE
    }

    /// What the side of a part takes, at the most, of those that pass the area: for its samples, and for the raster's own beside it.
    fn line(&self, own_samples: bool) -> u64 {
        let Area { column, row, width, height } = self.area;
        // Whether there is a line of tiles or parts among the columns or rows of the area, those beside it included.
        let is_passed = |first: i64, count: usize, cells: i64| {
            (first - 2).div_euclid(cells) != (first + count as i64).div_euclid(cells)
        };
        let of_level = |level: &Level| {
            let tile_cells = self.grid.cells(level.level);
            let cells = tile_cells / i64::from(level.parts);
            let beside = |span: usize| {
                let wide = (2.02 * own::band(tile_cells)).ceil() as u64 + 1;
                if own_samples { (span as u64).min(cells as u64) * wide * BYTES_BESIDE_LINE } else { 0 }
            };
            let along = |first: i64, across: usize, span: usize| {
                if is_passed(first, across, cells) { (cells + 1) as u64 * BYTES_ON_LINE + beside(span) } else { 0 }
            };
            along(column, width, height).max(along(row, height, width))
        };
        self.levels.iter().map(of_level).max().unwrap_or(0)
    }
}

/// What a thread takes to bring samples to the grid, beside what reading does.
fn bringing(request: &TilesRequest) -> u64 {
    let own = own::WINDOW as u64 * own::WINDOW as u64 * BYTES_TO_PLACE;
    MOST_OF_BLOCK as u64 * (8 + 8 + 1) + if request.own_samples { own } else { 0 }
}

/// What a thread takes to make tiles, but for what large ones take beside.
fn making(extent: &Extent<'_>, request: &TilesRequest) -> u64 {
    let stage = GreedyInsertion::default().bytes_per_sample().max(POLISHING);
    let part = SAMPLES_OF_PART * BYTES_PER_SAMPLE + MOST_IN_PART as u64 * stage;
    let own = if request.own_samples { OWN_OF_TILE } else { 0 };
    let measuring = ORDINARY as u64 * extent.triangle() + own;
    KEPT_BYTES + extent.line(request.own_samples) + part.max(measuring)
}

/// How many threads may have a large tile at a time.
struct Permits {
    free: Mutex<usize>,
    given_back: Condvar,
}

impl Permits {
    fn new(count: usize) -> Permits {
        Permits { free: Mutex::new(count), given_back: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, usize> {
        self.free.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The room that a tile takes while it is made.
pub(super) struct Room<'a> {
    permits: &'a Permits,
    is_large: bool,
}

impl Room<'_> {
    /// Waits for room for a tile of so many triangles, if it is a large one.
    ///
    /// # Errors
    /// [`PyramidError::Vertices`] where the format has too few numbers for their vertices.
    pub(super) fn hold(&mut self, tile: TileKey, triangles: usize) -> Result<(), PyramidError> {
        if triangles > MOST_TRIANGLES {
            // By Euler's formula, with a border of its four corners.
            return Err(PyramidError::Vertices { tile, found: triangles / 2 + 3 });
        }
        if triangles > ORDINARY && !self.is_large {
            let free = self.permits.lock();
            let mut free =
                self.permits.given_back.wait_while(free, |free| *free == 0).unwrap_or_else(PoisonError::into_inner);
            *free -= 1;
            self.is_large = true;
        }
        Ok(())
    }
}

impl Drop for Room<'_> {
    fn drop(&mut self) {
        if self.is_large {
            *self.permits.lock() += 1;
            self.permits.given_back.notify_one();
        }
    }
}
