//! The error of a finished tile mesh, measured over every sample in a pass of its own.
//!
//! Nothing an engine noted on its way is used: every triangle is scanned again. A tile counts the samples it owns (a
//! sample on a seam belongs to the tile to its right or below, as seam vertices do), so that over all tiles every
//! sample is counted once.

use crate::field::Tile;
use crate::lattice::Point;
use crate::mesh::TileMesh;
use crate::triangulate::feasible::{Plane, Spans};

/// How finely errors are sorted, from 0 to the tolerance.
pub const BINS: usize = 256;

/// Errors over a set of samples: vertical distances between surface and samples, in the heights' units.
#[derive(Debug, Clone, PartialEq)]
pub struct ErrorStats {
    /// How many samples were measured.
    pub samples: u64,
    /// The largest error.
    pub max: f64,
    /// Column and row of the first sample, in the order of measuring, that has it.
    pub worst: (u64, u64),
    /// Sum of the squares of all errors.
    pub squares: f64,
    /// How many samples have an error in each [`BINS`]-th of the tolerance; errors of 0 and 1/256 ε in the first.
    pub histogram: Box<[u64; BINS]>,
}

impl Default for ErrorStats {
    fn default() -> Self {
        ErrorStats { samples: 0, max: 0.0, worst: (0, 0), squares: 0.0, histogram: Box::new([0; BINS]) }
    }
}

impl ErrorStats {
    /// Adds those of other samples. Sums of squares are rounded: add in a fixed order for the same bits.
    pub fn add(&mut self, other: &ErrorStats) {
        if other.max > self.max || self.samples == 0 {
            (self.max, self.worst) = (other.max, other.worst);
        }
        self.samples += other.samples;
        self.squares += other.squares;
        for (sum, count) in self.histogram.iter_mut().zip(other.histogram.iter()) {
            *sum += count;
        }
    }

    /// Root of the mean square error.
    pub fn rms(&self) -> f64 {
        if self.samples == 0 { 0.0 } else { (self.squares / self.samples as f64).sqrt() }
    }

    /// The error that a share of the samples does not exceed, to 1/256 of the tolerance, rounded up but never above
    /// the maximum.
    pub fn percentile(&self, share: f64, tolerance: f64) -> f64 {
        let wanted = (share * self.samples as f64).ceil() as u64;
        let mut seen = 0;
        for (bin, count) in self.histogram.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                return (tolerance * (bin + 1) as f64 / BINS as f64).min(self.max);
            }
        }
        self.max
    }
}

/// Measures one tile after the other, reusing its memory.
#[derive(Debug, Default)]
pub struct Meter {
    seen: Vec<bool>,
}

impl Meter {
    /// Measures `mesh` over the samples that the tile owns: all but the last column and the last row, unless
    /// `last_column` and `last_row` say that they are the raster's. `origin` is the place of the tile's first sample
    /// in the raster.
    ///
    /// # Panics
    /// If a sample the tile owns is not covered by the mesh, or is farther than the tolerance from it: an engine is
    /// broken, and its mesh must not be written.
    pub fn measure(
        &mut self,
        tile: &Tile,
        mesh: &TileMesh,
        tolerance: f64,
        origin: (u64, u64),
        (last_column, last_row): (bool, bool),
    ) -> ErrorStats {
        let owned = (tile.width() - usize::from(!last_column), tile.height() - usize::from(!last_row));
        let mut stats = ErrorStats::default();
        self.seen.clear();
        self.seen.resize(tile.width() * tile.height(), false);
        let bins_per_error = if tolerance > 0.0 { BINS as f64 / tolerance } else { 0.0 };
        for &triangle in &mesh.triangles {
            let [a, b, c] = mesh.corners(triangle);
            let (spans, plane) = (Spans::new(a.at, b.at, c.at), Plane::new(a, b, c));
            for row in spans.rows() {
                let (first, last) = spans.columns(row);
                if first > last || row as usize >= owned.1 {
                    continue;
                }
                let (start, step) = (plane.at(Point::of_sample(first, row)), plane.step());
                let last = last.min(owned.0 as i32 - 1);
                let base = row as usize * tile.width();
                for column in first..=last {
                    if std::mem::replace(&mut self.seen[base + column as usize], true) {
                        continue;
                    }
                    let height = tile.at(column as usize, row as usize);
                    let mut error = (start + step * f64::from(column - first) - height).abs();
                    let place = Point::of_sample(column, row);
                    if error > tolerance && plane.within(place, height, tolerance) {
                        // Only the rounding of this computation is above the tolerance.
                        error = tolerance;
                    }
                    stats.samples += 1;
                    stats.squares += error * error;
                    let bin = ((error * bins_per_error) as usize).min(BINS - 1);
                    stats.histogram[bin] += 1;
                    if error > stats.max || stats.samples == 1 {
                        stats.max = error;
                        stats.worst = (origin.0 + column as u64, origin.1 + row as u64);
                    }
                }
            }
        }
        assert_eq!(stats.samples, (owned.0 * owned.1) as u64, "samples covered of a tile at {origin:?}");
        let (max, worst) = (stats.max, stats.worst);
        assert!(max <= tolerance, "error {max} at sample {worst:?}, {tolerance} is allowed");
        stats
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Heights;
    use crate::mesh::Vertex;

    #[test]
    fn a_plane_over_a_bump() {
        let mut heights = vec![0.0f32; 25];
        heights[12] = 3.0;
        heights[13] = -1.0;
        let tile = Tile::from_heights(5, 5, Heights::F32(heights));
        let vertex = |c, r| Vertex { at: Point::of_sample(c, r), height: 0.0 };
        let mesh = TileMesh {
            vertices: vec![vertex(0, 0), vertex(4, 0), vertex(4, 4), vertex(0, 4)],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            relaxed: 0,
        };
        let all = Meter::default().measure(&tile, &mesh, 4.0, (100, 200), (true, true));
        assert_eq!((all.samples, all.max, all.worst, all.squares), (25, 3.0, (102, 202), 10.0));
        assert_eq!(all.percentile(0.5, 4.0), 4.0 / 256.0);
        assert_eq!(all.percentile(1.0, 4.0), 3.0);
        let owned = Meter::default().measure(&tile, &mesh, 4.0, (0, 0), (false, true));
        assert_eq!(owned.samples, 20);
    }
}
