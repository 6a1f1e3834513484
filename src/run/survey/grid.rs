//! Maps: what lies in each of a few hundred squares each way.

/// Squares along the longer side of a raster, at most.
const MOST: usize = 512;

/// What lies in one square of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapCell {
    /// Samples that were measured.
    pub measured: u32,
    /// Samples whose error is above nine tenths of the tolerance.
    pub near: u32,
    /// Samples whose error is above the tolerance.
    pub above: u32,
    /// Faces whose middle lies in it.
    pub faces: u32,
    /// The largest error.
    pub max: f32,
    /// The mean of the heights; NaN where there is none.
    pub height: f64,
}

/// What the samples of a square come to, or of some of its rows.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Square {
    /// Samples that were measured, that have a height, that are near the tolerance and above it.
    pub(super) measured: u32,
    pub(super) heights: u32,
    pub(super) near: u32,
    pub(super) above: u32,
    pub(super) max: f32,
    /// Of the heights.
    pub(super) sum: f64,
}

/// A raster in squares, row by row. Memory: 32 bytes for each of at most 512 × 512 squares, whatever the raster.
#[derive(Debug, Clone, PartialEq)]
pub struct MapGrid {
    /// Samples of the raster, across and down.
    pub samples: (usize, usize),
    /// Samples along the side of a square; those at the right and lower rim may be smaller.
    pub side: usize,
    /// Squares across and down.
    pub size: (usize, usize),
    /// What lies in them.
    pub cells: Vec<MapCell>,
}

impl Square {
    pub(super) fn add(&mut self, other: &Square) {
        self.measured += other.measured;
        self.heights += other.heights;
        self.near += other.near;
        self.above += other.above;
        self.max = self.max.max(other.max);
        self.sum += other.sum;
    }

    fn cell(&self) -> MapCell {
        let Square { measured, near, above, max, .. } = *self;
        MapCell { measured, near, above, faces: 0, max, height: self.sum / f64::from(self.heights) }
    }
}

impl MapGrid {
    /// Without cells.
    pub(super) fn new(samples: (usize, usize)) -> MapGrid {
        let side = samples.0.max(samples.1).div_ceil(MOST);
        let size = (samples.0.div_ceil(side), samples.1.div_ceil(side));
        MapGrid { samples, side, size, cells: Vec::with_capacity(size.0 * size.1) }
    }

    /// Adds the next row of cells, without faces.
    pub(super) fn push(&mut self, row: &[Square]) {
        self.cells.extend(row.iter().map(Square::cell));
    }

    /// Which square the middle of a face is in, by its corners in quarters of cells; those beyond the rim are moved to it.
    pub(super) fn of_face(&self, [a, b, c]: [(i64, i64); 3]) -> usize {
        // Halves are far enough from whole numbers for a quotient that is rounded.
        let per_square = 1.0 / (12 * self.side) as f64;
        let index = |sum: i64, size: usize| (((sum as f64 + 0.5) * per_square) as u32 as usize).min(size - 1);
        index(a.1 + b.1 + c.1, self.size.1) * self.size.0 + index(a.0 + b.0 + c.0, self.size.0)
    }

    /// Samples in a square: fewer at the rim.
    pub fn area(&self, column: usize, row: usize) -> usize {
        let along = |at: usize, all: usize| self.side.min(all - at * self.side);
        along(column, self.samples.0) * along(row, self.samples.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_heights_keep_a_small_relief_far_from_0() {
        let square = |height: f64| Square { measured: 4, heights: 4, sum: 4.0 * height, ..Square::default() };
        let mut map = MapGrid::new((4, 2));
        map.push(&[square(1e9), square(1e9 + 1e-3)]);
        assert!((map.cells[1].height - map.cells[0].height - 1e-3).abs() < 1e-6);
    }
}
