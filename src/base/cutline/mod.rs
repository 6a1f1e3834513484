//! Polygons over a raster, as the samples inside them.

mod polygon;

pub use polygon::Polygon;

use std::sync::Arc;

use crate::base::Window;

/// Polygons over a raster: a sample is inside where it stands in any of them, holes left out (the even-odd rule). On a
/// side, of the two polygons beside it the one that the sample's right (or, on a level side, what is below) belongs to
/// has it, so polygons that share sides share no sample.
///
/// Memory: 32 bytes per vertex. What it tells depends on the polygons alone, not on their order or on the window asked
/// for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cutline {
    polygons: Arc<Vec<Polygon>>,
    vertices: u64,
    /// Column and row of the window's first sample in the raster for which the polygons were read.
    first: (usize, usize),
}

impl Cutline {
    /// Whether the samples of a window are inside, row by row; replaces what is in `mask`.
    ///
    /// Cost: a look at every 256 sides, and at the sides there that reach into rows of the window: O(log) per row that
    /// such a side crosses.
    pub fn mask(&self, window: Window, mask: &mut Vec<bool>) {
        mask.clear();
        mask.resize(window.len(), false);
        let (column, row) = (window.column + self.first.0, window.row + self.first.1);
        let window = Window { column, row, ..window };
        self.polygons.iter().for_each(|polygon| polygon.mark(window, mask));
    }

    /// How many polygons there are, and how many vertices they have.
    pub fn counts(&self) -> (u64, u64) {
        (self.polygons.len() as u64, self.vertices)
    }

    /// A checksum of the polygons as they lie on the samples, for what identifies a job.
    pub fn checksum(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        self.polygons.iter().for_each(|polygon| polygon.hash(&mut hasher));
        if self.first != (0, 0) {
            [self.first.0, self.first.1].iter().for_each(|n| hasher.update(&(*n as u64).to_le_bytes()));
        }
        hasher.finalize()
    }

    /// The same polygons over a window whose first sample has this column and row.
    pub fn of_window(&self, column: usize, row: usize) -> Cutline {
        let first = (self.first.0 + column, self.first.1 + row);
        Cutline { polygons: self.polygons.clone(), vertices: self.vertices, first }
    }

    /// The polygons over a raster, their places in columns and rows of it: sample (c, r) stands at (c, r).
    pub fn new(polygons: Vec<Polygon>) -> Cutline {
        let vertices = polygons.iter().map(Polygon::sides).sum();
        Cutline { polygons: Arc::new(polygons), vertices, first: (0, 0) }
    }
}
