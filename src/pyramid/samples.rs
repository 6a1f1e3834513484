//! The samples of the finest grid, wherever they are asked for: those of the area from the field, all others at the height
//! that is taken outside of the raster.

use super::error::PyramidError;
use super::grid::Grid;
use super::source::Area;
use crate::base::{Tile, Window};
use crate::field::{Field, LoadScratch};

/// The finest grid with its heights.
pub(crate) struct Samples {
    pub(crate) grid: Grid,
    pub(crate) field: Field,
    pub(crate) area: Area,
    /// The height of samples that the raster does not give one.
    pub(crate) outside: f64,
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
    tile: Tile,
    load: LoadScratch,
}

impl Samples {
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

    /// Reads a patch.
    pub(crate) fn read(&self, patch: Patch, block: &mut Block) -> Result<(), PyramidError> {
        let Patch { row, width, height, step, .. } = patch;
        block.heights.clear();
        block.heights.resize(width * height, self.outside);
        block.inside.clear();
        block.inside.resize(width * height, false);
        // One row after the other where samples are left out: all between would be read, too.
        let rows_at_once = if step == 1 { height } else { 1 };
        let mut done = 0;
        while done < height {
            let first = row + done as i64 * step;
            let rows = if rows_at_once == 1 { first..first + 1 } else { first..first + height as i64 };
            let within = rows.start.max(self.area.row)..rows.end.min(self.area.row + self.area.height as i64);
            if !within.is_empty() {
                self.read_rows(patch, rows.start, within, done, block)?;
            }
            done += rows_at_once;
        }
        Ok(())
    }

    /// Reads what the area has of some rows of a patch, of which `first_row` is row `done`.
    fn read_rows(
        &self,
        patch: Patch,
        first_row: i64,
        rows: std::ops::Range<i64>,
        done: usize,
        block: &mut Block,
    ) -> Result<(), PyramidError> {
        let around = self.grid.columns();
        let span = (patch.width as i64 - 1) * patch.step + 1;
        let mut at = 0;
        while at < span {
            let in_area = (patch.column + at - self.area.column).rem_euclid(around);
            if in_area >= self.area.width as i64 {
                at += around - in_area;
                continue;
            }
            let length = (self.area.width as i64 - in_area).min(span - at);
            let window = Window {
                column: in_area as usize,
                row: (rows.start - self.area.row) as usize,
                width: length as usize,
                height: (rows.end - rows.start) as usize,
            };
            self.field.load_with(window, &mut block.tile, &mut block.load)?;
            let first = (at + patch.step - 1) / patch.step;
            for (r, row) in rows.clone().enumerate() {
                // All columns are one place there.
                if row == 0 || row == self.grid.rows() {
                    continue;
                }
                let to = (done + (row - first_row) as usize) * patch.width;
                let mut column = first;
                while column * patch.step < at + length {
                    let c = (column * patch.step - at) as usize;
                    if block.tile.validity().is_valid(c as i32, r as i32) {
                        block.heights[to + column as usize] = block.tile.at(c, r);
                        block.inside[to + column as usize] = true;
                    }
                    column += 1;
                }
            }
            at += length;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Heights;

    /// 8 rows and 16 columns around: the area goes over the antimeridian.
    fn samples() -> Samples {
        let (width, height) = (6, 4);
        let heights = (0..width * height).map(|i| if i == 7 { f64::NAN } else { i as f64 }).collect();
        let field = Field::from_heights(width, height, Heights::F64(heights)).expect("a field");
        let area = Area { column: 13, row: 2, width, height };
        Samples { grid: Grid { exponent: 3 }, field, area, outside: -5.0 }
    }

    #[test]
    fn windows_have_all_samples_of_a_square_once() {
        let samples = samples();
        for ((column, row), cells) in (0..16).flat_map(|c| (0..8).flat_map(move |r| [4, 8].map(|n| ((c, r), n)))) {
            let mut seen = std::collections::BTreeMap::new();
            for ((left, top), (width, height)) in samples.windows((column, row), cells, 4) {
                let places = (0..width as i64).flat_map(|c| (0..height as i64).map(move |r| (left + c, top + r)));
                places.for_each(|place| *seen.entry(place).or_insert(0) += 1);
            }
            let is_in = |c: i64, r: i64| (column + c - 13).rem_euclid(16) < 6 && (0..4).contains(&(row + r - 2));
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
        let expected = |column: i64, row: i64| {
            let (c, r) = ((column - 13).rem_euclid(16), row - 2);
            let i = r * 6 + c;
            let is_inside = c < 6 && (0..4).contains(&r) && i != 7;
            if is_inside { (i as f64, true) } else { (-5.0, false) }
        };
        let mut block = Block::default();
        for step in 1..4 {
            for (column, row) in (0..16).flat_map(|c| (0..5).map(move |r| (c, r))) {
                let patch = Patch { column, row, width: 8, height: 3, step };
                samples.read(patch, &mut block).expect("samples");
                for (i, (&height, &inside)) in block.heights.iter().zip(&block.inside).enumerate() {
                    let at = (column + (i % 8) as i64 * step, row + (i / 8) as i64 * step);
                    assert_eq!((height, inside), expected(at.0, at.1), "{patch:?} {at:?}");
                    assert!(!inside || samples.may_have(column, row, 7 * step, 2 * step));
                }
            }
        }
        assert!(!samples.may_have(4, 0, 8, 8) && samples.may_have(12, 0, 1, 8) && !samples.may_have(13, 6, 1, 1));
    }
}
