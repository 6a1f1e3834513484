//! Lines over a raster, as they are read.

use std::sync::Arc;

/// Lines over a raster, in columns and rows with fractions: sample (c, r) stands at (c, r). Nothing is said of their order or of
/// what they do to each other.
///
/// Memory: 16 bytes per vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Polylines {
    lines: Arc<Vec<Vec<(f64, f64)>>>,
    without_geometry: u64,
}

impl Polylines {
    /// The most pieces between rows and columns that lines may have in all, to be held in memory.
    pub const MAX_SEGMENTS: usize = 4_000_000;

    /// The farthest vertex, in cells: what is reckoned from it fits 128 bits.
    pub const FARTHEST: f64 = (1u64 << 40) as f64;

    /// The most that edges may be shifted, in cells.
    pub const MAX_SHIFT: f64 = 16.0;

    /// How far edges may be from a line where nothing is said of it, in cells.
    pub const USUAL_SHIFT: f64 = 0.5;

    /// These lines. Coordinates are finite.
    pub fn new(lines: Vec<Vec<(f64, f64)>>) -> Polylines {
        Polylines { lines: Arc::new(lines), without_geometry: 0 }
    }

    /// The same lines, of a layer in which so many features have no geometry.
    pub fn beside(self, without_geometry: u64) -> Polylines {
        Polylines { without_geometry, ..self }
    }

    /// How many features of their layer have no geometry.
    pub fn without_geometry(&self) -> u64 {
        self.without_geometry
    }

    /// The vertices of each line.
    pub fn lines(&self) -> &[Vec<(f64, f64)>] {
        &self.lines
    }
}
