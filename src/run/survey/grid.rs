//! Maps: what lies in each of a few hundred squares each way.

/// Squares along the longer side of a raster, at most.
const MOST: usize = 512;

/// What lies in one square of a map.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MapCell {
    /// Samples that were measured.
    pub measured: u32,
    /// Samples with a height.
    pub heights: u32,
    /// Samples whose error is above nine tenths of the tolerance.
    pub near: u32,
    /// Samples whose error is above the tolerance.
    pub above: u32,
    /// Faces whose middle lies in it.
    pub faces: u32,
    /// The largest error.
    pub max: f32,
    /// The sum of the heights.
    pub sum: f64,
}

/// A raster in squares, row by row. Memory: 40 bytes for each of at most 512 × 512 squares, whatever the raster.
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

impl MapCell {
    pub(super) fn add(&mut self, other: &MapCell) {
        self.measured += other.measured;
        self.heights += other.heights;
        self.near += other.near;
        self.above += other.above;
        self.max = self.max.max(other.max);
        self.sum += other.sum;
    }

    /// The mean of the heights; NaN where there is none.
    pub fn height(&self) -> f64 {
        self.sum / f64::from(self.heights)
    }
}

impl MapGrid {
    pub(super) fn new(samples: (usize, usize)) -> MapGrid {
        let side = samples.0.max(samples.1).div_ceil(MOST);
        let size = (samples.0.div_ceil(side), samples.1.div_ceil(side));
        MapGrid { samples, side, size, cells: vec![MapCell::default(); size.0 * size.1] }
    }

    /// Which square a place in quarters of cells is in, those beyond the rim moved to it.
    pub(super) fn at(&self, (x, y): (i64, i64)) -> usize {
        let index = |quarters: i64, size: usize| {
            let square = quarters.max(0) as usize / (4 * self.side);
            square.min(size - 1)
        };
        let (column, row) = (index(x, self.size.0), index(y, self.size.1));
        row * self.size.0 + column
    }

    /// Samples in a square: fewer at the rim.
    pub fn area(&self, column: usize, row: usize) -> usize {
        let along = |at: usize, all: usize| self.side.min(all - at * self.side);
        along(column, self.samples.0) * along(row, self.samples.1)
    }
}
