//! Heights of their own: which ones there are, and where.

use crate::base::Tile;
use crate::base::exact;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;
use crate::kernel::quantum::Quantum;

/// How vertices are fitted: they stand on any place of the lattice, near the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitting {
    tolerance: f64,
    quantum: Quantum,
}

impl Fitting {
    /// For a tolerance that is a normal number.
    pub(super) fn new(tolerance: f64) -> Fitting {
        Fitting { tolerance, quantum: Quantum::new(tolerance) }
    }

    /// A vertex, `rise` tolerances higher and rounded: `None` where no height is near. Also says by how much it rose.
    pub(super) fn raised(&self, from: Vertex, rise: f32) -> Option<(Vertex, f32)> {
        let height = self.quantum.round(from.height + f64::from(rise) * self.tolerance)?;
        let rise = ((height - from.height) / self.tolerance) as f32;
        Some((Vertex { height, ..from }, rise))
    }

    /// The vertex some tolerances higher, as it comes.
    pub(super) fn guess(&self, from: Vertex, at: Point, rise: f64) -> Vertex {
        Vertex { at, height: from.height + rise * self.tolerance }
    }
}

/// Whether a vertex between samples is within the tolerance of the bilinear surface of its cell, exactly. (At a sample, the
/// triangles' own test says it.)
///
/// Nothing is where one of the samples that have a part in it is missing. Along a grid line that surface is the line between two samples. Of the samples that have a part in it, the smallest
/// limit holds.
pub(in crate::kernel) fn near_surface(tile: &Tile, vertex: Vertex, tolerance: f64) -> bool {
    let Point { x, y } = vertex.at;
    let [(column, right), (row, lower)] = [x, y].map(|v| (v.div_euclid(STEPS), i64::from(v.rem_euclid(STEPS))));
    let steps = i64::from(STEPS);
    let (left, upper) = (steps - right, steps - lower);
    if right == 0 && lower == 0 {
        return true;
    }
    let mut limit = f64::INFINITY;
    let mut terms = [(0, 0.0); 5];
    let corners = [(0, 0, left * upper), (1, 0, right * upper), (0, 1, left * lower), (1, 1, right * lower)];
    for (term, (i, j, weight)) in terms.iter_mut().zip(corners) {
        if weight > 0 {
            if !tile.validity.is_valid(column + i, row + j) {
                return false;
            }
            let (column, row) = ((column + i) as usize, (row + j) as usize);
            *term = (weight, tile.at(column, row));
            limit = limit.min(tile.limit(column, row, tolerance));
        }
    }
    terms[4] = (-steps * steps, vertex.height);
    exact::within(&terms, steps * steps, limit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Heights;

    #[test]
    fn heights_are_multiples_of_a_power_of_two() {
        let from = Vertex { at: Point { x: 1, y: 2 }, height: 1234.567 };
        for (tolerance, quantum) in [(5.0, 1.0 / 256.0), (1.0, 1.0 / 1024.0), (0.3, 1.0 / 4096.0)] {
            let (vertex, rise) = Fitting::new(tolerance).raised(from, -0.625).expect("near");
            assert_eq!((vertex.height / quantum).fract(), 0.0);
            assert!((vertex.height - (from.height - 0.625 * tolerance)).abs() <= quantum / 2.0);
            assert!((f64::from(rise) * tolerance - (vertex.height - from.height)).abs() < quantum * 1e-3);
        }
        let zero = Fitting::new(8.0).raised(Vertex { height: 1e-9, ..from }, -1e-9).expect("near").0;
        assert_eq!(zero.height.to_bits(), 0);
        assert!(Fitting::new(1e30).raised(from, 2.0).is_none());
    }

    #[test]
    fn between_samples_the_bilinear_surface_counts_and_every_sample_of_it() {
        let tile = Tile::from_heights(3, 2, Heights::F32(vec![0.0, 4.0, 100.0, 8.0, 20.0, 200.0]));
        let near = |tile: &Tile, x, y, height| near_surface(tile, Vertex { at: Point { x, y }, height }, 1.0);
        // A quarter across and half-way down: (3·0 + 4)/8 + (3·8 + 20)/8 = 6.
        for (height, within) in [(6.0, true), (7.0, true), (5.0, true), (7.0 + 1e-12, false), (5.0 - 1e-12, false)] {
            assert_eq!(near(&tile, 1, 2, height), within, "{height}");
        }
        // On lines only their two samples count, on the last ones, too.
        assert!(near(&tile, 2, 0, 3.0) && near(&tile, 8, 1, 126.0) && near(&tile, 6, 4, 109.0));
        assert!(!near(&tile, 2, 0, 3.1) && !near(&tile, 8, 1, 126.1) && !near(&tile, 6, 4, 108.9));
        assert!(near(&tile, 4, 4, 1e6), "at a sample the triangles decide");
        let weighted = tile.with_weights(vec![1.0, 0.5, 0.0, 1.0, 4.0, 1.0]);
        assert!(near(&weighted, 1, 2, 6.25) && !near(&weighted, 1, 2, 6.26));
        assert!(near(&weighted, 2, 0, 3.0) && !near(&weighted, 2, 0, 3.1));
    }
}
