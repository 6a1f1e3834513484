//! The samples of the finest grid, wherever they are asked for: those of the area from the store, all others at the height
//! that is taken outside of the raster.

use std::cell::RefCell;
use std::fs::File;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use super::error::PyramidError;
use super::grid::Grid;
use super::outline::{Count, Outline, THINNED};
use super::own::OwnStore;
use super::source::Area;
use super::store::{BLOCK, Cache, Store};
use super::voids::VOID;
use crate::base::control::Control;

/// The finest grid with its heights.
pub(crate) struct Samples {
    pub(crate) grid: Grid,
    pub(crate) store: Arc<Store>,
    pub(crate) area: Area,
    /// The height of samples that the raster does not give one.
    pub(crate) outside: f64,
    /// The raster's own samples, where tiles have to be within their errors at those, too.
    pub(super) own: Option<Arc<OwnStore>>,
    /// That of marked voids.
    pub(super) void: f64,
}

/// A window of the grid, of which every `step`th sample is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Patch {
    /// The first column; those beyond the grid's last begin anew.
    pub(crate) column: i64,
    /// The first row.
    pub(crate) row: i64,
    /// Samples across and down.
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Grid cells from one to the next.
    pub(crate) step: i64,
}

/// The samples of a patch, row by row.
#[derive(Default)]
pub(crate) struct Block {
    pub(crate) heights: Vec<f64>,
    /// Which of them the raster gives a height.
    pub(crate) inside: Vec<bool>,
    /// Which of them are in marked voids.
    pub(crate) is_void: Vec<bool>,
    cache: Rc<RefCell<Cache>>,
}

impl Block {
    /// Another one that shares what has been read.
    pub(super) fn beside(&self) -> Block {
        Block { cache: Rc::clone(&self.cache), ..Block::default() }
    }
}

/// Samples of a block that are so few are read one by one, where they do not follow one another.
const FEW: usize = 3;

impl Samples {
    /// Keeps the heights of an area in a file, which is in a folder. `fill` is given the first sample of a block and its heights, all NaN, and
    /// says whether any has become a height; none outside of the area may.
    pub(super) fn make<S>(
        grid: Grid,
        area: Area,
        outside: f64,
        file: (File, &Path),
        scratch: impl Fn() -> Result<S, PyramidError> + Sync,
        fill: impl Fn(&mut S, (i64, i64), &mut [f64]) -> Result<bool, PyramidError> + Sync,
        control: &Control<'_>,
    ) -> Result<Samples, PyramidError> {
        let first = area.first_block();
        let last = (area.column + area.width as i64 - 1, area.row + area.height as i64 - 1);
        let blocks = |first: i64, last: i64| ((last - first) / BLOCK as i64 + 1) as usize;
        let size = (blocks(first.0, last.0), blocks(first.1, last.1));
        let at = |(column, row): (usize, usize)| (first.0 + (column * BLOCK) as i64, first.1 + (row * BLOCK) as i64);
        let fill = |scratch: &mut S, block: (usize, usize), heights: &mut [f64]| fill(scratch, at(block), heights);
        Ok(Samples::of(grid, Store::make(size, file, scratch, fill, control)?, area, outside))
    }

    /// Those of a store. Voids are as high as the ground outside.
    pub(super) fn of(grid: Grid, store: Store, area: Area, outside: f64) -> Samples {
        Samples { grid, store: Arc::new(store), area, outside, void: outside, own: None }
    }

    /// The same samples with voids at a height.
    pub(super) fn with_voids(&self, void: f64) -> Samples {
        Samples { store: Arc::clone(&self.store), void, own: self.own.clone(), ..*self }
    }

    /// Whether the raster may give a sample of a window a height, ends included.
    pub(crate) fn may_have(&self, column: i64, row: i64, width: i64, height: i64) -> bool {
        let below = row + height >= self.area.row && row < self.area.row + self.area.height as i64;
        let around = self.grid.columns();
        let first = (self.area.column - column).rem_euclid(around);
        let beside = first <= width || first + self.area.width as i64 > around;
        below && beside
    }

    /// The windows, of at most `size` cells each way, that together have all samples of the raster in a square, whose first sample and
    /// cells along the side are given, its whole border included. Windows are counted from the square's corner: each is the
    /// offset of its first sample and how many samples it has across and down.
    pub(crate) fn windows(&self, origin: (i64, i64), cells: i64, size: i64) -> Vec<((i64, i64), (usize, usize))> {
        let starts = |first: i64, count: usize| {
            let (low, high) = (first.max(0), (first + count as i64 - 1).min(cells));
            (low / size * size..=high).step_by(size as usize).filter(move |_| low <= high)
        };
        let rows = starts(self.area.row - origin.1, self.area.height);
        let first = (self.area.column - origin.0).rem_euclid(self.grid.columns());
        // Around the ellipsoid the area begins once more.
        let around = [first - self.grid.columns(), first];
        let mut columns: Vec<i64> = around.into_iter().flat_map(|first| starts(first, self.area.width)).collect();
        columns.sort_unstable();
        columns.dedup();
        let samples = |start: i64| size.min(cells + 1 - start) as usize;
        let window = |(left, top): (i64, i64)| ((left, top), (samples(left), samples(top)));
        rows.flat_map(|top| columns.iter().map(move |&left| (left, top))).map(window).collect()
    }

    /// Whether all samples of a square, its border included, are of the area.
    pub(crate) fn has_all(&self, origin: (i64, i64), cells: i64) -> bool {
        let first = (origin.0 - self.area.column).rem_euclid(self.grid.columns());
        let row = origin.1 - self.area.row;
        first + cells < self.area.width as i64 && row >= 0 && row + cells < self.area.height as i64
    }

    /// Whether the raster gives any sample of a patch a height; it may say so where none has.
    pub(crate) fn has_any(&self, patch: Patch) -> bool {
        let (columns, rows) = self.runs(patch);
        rows.iter().any(|row| columns.iter().any(|column| self.store.is_filled((column.block, row.block))))
    }

    /// Reads a patch.
    pub(crate) fn read(&self, patch: Patch, block: &mut Block) -> Result<(), PyramidError> {
        let Patch { width, height, step, .. } = patch;
        let Block { heights, inside, is_void, cache } = block;
        heights.clear();
        heights.resize(width * height, self.outside);
        inside.clear();
        inside.resize(width * height, false);
        is_void.clear();
        is_void.resize(width * height, false);
        let mut cache = cache.borrow_mut();
        let (columns, rows) = self.runs(patch);
        for row in &rows {
            for column in columns.iter().filter(|column| self.store.is_filled((column.block, row.block))) {
                let at = (column.block, row.block);
                let to = row.first * width + column.first;
                let from = row.offset * BLOCK + column.offset;
                let mut put = |to: usize, height: f64| {
                    if height == VOID {
                        (heights[to], is_void[to]) = (self.void, true);
                    } else if !height.is_nan() {
                        (heights[to], inside[to]) = (height, true);
                    }
                };
                let step = step as usize;
                let places = || (0..row.count).flat_map(|r| (0..column.count).map(move |c| (c, r)));
                if [step, row.offset, column.offset].iter().all(|at| at % THINNED == 0) {
                    let outline = self.store.outline(at)?;
                    let height = |(c, r)| outline.height(column.offset + c * step, row.offset + r * step);
                    places().for_each(|(c, r)| put(to + r * width + c, height((c, r))));
                    continue;
                }
                if step > 1 && row.count * column.count <= FEW {
                    for (c, r) in places() {
                        put(to + r * width + c, cache.one(&self.store, at, from + (r * BLOCK + c) * step)?);
                    }
                    continue;
                }
                let (read, is_whole) = cache.block(&self.store, at)?;
                if step == 1 && is_whole {
                    for r in 0..row.count {
                        let (to, from) = (to + r * width, from + r * BLOCK);
                        heights[to..to + column.count].copy_from_slice(&read[from..from + column.count]);
                        inside[to..to + column.count].fill(true);
                    }
                    continue;
                }
                for r in 0..row.count {
                    let read = read[from + r * step * BLOCK..].iter().step_by(step).take(column.count);
                    (to + r * width..).zip(read).for_each(|(to, &height)| put(to, height));
                }
            }
        }
        Ok(())
    }

    /// Calls `look` with the outlines of a rectangle's blocks that have heights, each with the offset of its first sample and which of its samples
    /// count, given the rectangle's first sample and how many it has across and down: a whole number of blocks, or one more. Whether
    /// all are known: not where they are no whole blocks of the store, or one has a pole in it.
    pub(super) fn each_outline(
        &self,
        first: (i64, i64),
        (width, height): (usize, usize),
        mut look: impl FnMut((usize, usize), &Outline, Count),
    ) -> Result<bool, PyramidError> {
        let (size, around) = (BLOCK as i64, self.grid.columns());
        let is_aligned = first.0 % size == 0 && first.1 % size == 0 && width % BLOCK <= 1 && height % BLOCK <= 1;
        // So far around a block may be two of the store.
        let is_once = self.area.width as i64 + 2 * size < around;
        let end = first.1 + height.next_multiple_of(BLOCK) as i64;
        if !is_aligned || !is_once || first.1 <= 0 || end > self.grid.rows() {
            return Ok(false);
        }
        let (area, (across, down)) = (self.area.first_block(), self.store.size());
        for top in (0..height).step_by(BLOCK) {
            let row = (first.1 + top as i64 - area.1).div_euclid(size);
            if !(0..down as i64).contains(&row) {
                continue;
            }
            for left in (0..width).step_by(BLOCK) {
                let column = (first.0 + left as i64 - area.0).rem_euclid(around) / size;
                let at = (column as usize, row as usize);
                if at.0 < across && self.store.is_filled(at) {
                    let outline = self.store.outline(at)?;
                    look((left, top), &outline, outline.count(width - left > 1, height - top > 1));
                }
            }
        }
        Ok(true)
    }

    /// A patch's columns and rows as runs in blocks; those of the poles are in none, as all columns are one place there.
    fn runs(&self, patch: Patch) -> (Vec<Run>, Vec<Run>) {
        let (around, area) = (self.grid.columns(), self.area);
        let first = area.first_block();
        let column = |i: i64| {
            let in_area = (patch.column + i * patch.step - area.column).rem_euclid(around);
            (in_area < area.width as i64).then_some((in_area + area.column - first.0) as usize)
        };
        let poles = [0, self.grid.rows()];
        let row = |i: i64| {
            let row = patch.row + i * patch.step;
            let in_area = (area.row..area.row + area.height as i64).contains(&row) && !poles.contains(&row);
            in_area.then_some((row - first.1) as usize)
        };
        let step = patch.step as usize;
        (Run::all((0..patch.width as i64).map(column), step), Run::all((0..patch.height as i64).map(row), step))
    }
}

/// Columns or rows of a patch that follow one another and lie in one block.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// The column or row of the block.
    block: usize,
    /// The place of the first in the block.
    offset: usize,
    /// The place of the first in the patch.
    first: usize,
    /// How many.
    count: usize,
}

impl Run {
    /// From the places in the store, from its first block on.
    fn all(places: impl Iterator<Item = Option<usize>>, step: usize) -> Vec<Run> {
        let mut runs: Vec<Run> = Vec::new();
        for (i, place) in places.enumerate() {
            let Some(place) = place else { continue };
            let (block, offset) = (place / BLOCK, place % BLOCK);
            match runs.last_mut() {
                Some(run) if run.block == block && run.offset + (i - run.first) * step == offset => run.count += 1,
                _ => runs.push(Run { block, offset, first: i, count: 1 }),
            }
        }
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 128 rows and 256 columns around: the area goes over the antimeridian, and over blocks.
    const GRID: Grid = Grid { exponent: 7 };
    const AREA: Area = Area { column: 253, row: 62, width: 6, height: 4 };

    /// The place in the area, row by row.
    fn place(column: i64, row: i64) -> Option<i64> {
        let (c, r) = ((column - AREA.column).rem_euclid(GRID.columns()), row - AREA.row);
        (c < 6 && (0..4).contains(&r)).then_some(r * 6 + c)
    }

    fn samples() -> Samples {
        let fill = |_: &mut (), (column, row): (i64, i64), heights: &mut [f64]| {
            let mut is_filled = false;
            for (i, height) in heights.iter_mut().enumerate() {
                let place = place(column + (i % BLOCK) as i64, row + (i / BLOCK) as i64).filter(|&place| place != 7);
                place.inspect(|&place| *height = place as f64);
                is_filled |= place.is_some();
            }
            Ok(is_filled)
        };
        let folder = crate::fuzzing::temp_dir();
        let file = crate::pyramid::store::temporary(&folder).expect("a file");
        Samples::make(GRID, AREA, -5.0, (file, &folder), || Ok(()), fill, &Control::default()).expect("samples")
    }

    /// Where squares begin: from all sides of the area on.
    fn corners() -> impl Iterator<Item = (i64, i64)> {
        (240..256).chain(0..8).flat_map(|c| (58..67).map(move |r| (c, r)))
    }

    #[test]
    fn windows_have_all_samples_of_a_square_once() {
        let samples = samples();
        for ((column, row), cells) in corners().flat_map(|corner| [4, 8].map(|n| (corner, n))) {
            let mut seen = std::collections::BTreeMap::new();
            for ((left, top), (width, height)) in samples.windows((column, row), cells, 4) {
                let places = (0..width as i64).flat_map(|c| (0..height as i64).map(move |r| (left + c, top + r)));
                places.for_each(|place| *seen.entry(place).or_insert(0) += 1);
            }
            let is_in = |c: i64, r: i64| place(column + c, row + r).is_some();
            for (c, r) in (0..=cells).flat_map(|c| (0..=cells).map(move |r| (c, r))) {
                let count = seen.remove(&(c, r)).unwrap_or(0);
                assert!(count <= 1 && (count == 1 || !is_in(c, r)), "{c}, {r} of {column}, {row}: {count}");
            }
            assert!(seen.is_empty());
            let all = (0..=cells).all(|c| (0..=cells).all(|r| is_in(c, r)));
            assert_eq!(samples.has_all((column, row), cells), all, "{column}, {row}, {cells}");
        }
    }

    #[test]
    fn every_window_and_step_has_the_same_samples() {
        let samples = samples();
        let expected = |column: i64, row: i64| match place(column, row).filter(|&place| place != 7) {
            Some(place) => (place as f64, true),
            None => (-5.0, false),
        };
        let mut block = Block::default();
        for (step, (column, row)) in [1, 2, 3, 64, 128].into_iter().flat_map(|step| corners().map(move |at| (step, at)))
        {
            let patch = Patch { column, row, width: 8, height: 3, step };
            samples.read(patch, &mut block).expect("samples");
            assert!(samples.has_any(patch) || !block.inside.contains(&true));
            for (i, (&height, &inside)) in block.heights.iter().zip(&block.inside).enumerate() {
                let at = (column + (i % 8) as i64 * step, row + (i / 8) as i64 * step);
                assert_eq!((height, inside), expected(at.0, at.1), "{patch:?} {at:?}");
                assert!(!inside || samples.may_have(column, row, 7 * step, 2 * step));
            }
        }
        assert!(!samples.may_have(4, 60, 8, 8) && samples.may_have(252, 60, 1, 8) && !samples.may_have(253, 66, 1, 1));
        assert!(!samples.has_any(Patch { column: 0, row: 0, width: 200, height: 60, step: 1 }));
    }
}
