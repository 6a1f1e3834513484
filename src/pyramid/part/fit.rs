//! How far triangles of a part are from the samples of the grid: estimates that steer, nothing that certifies.

use super::Place;
use crate::pyramid::lines::Vertex;
use crate::pyramid::measure::clipped;
use crate::pyramid::quantize::SPAN;
use crate::pyramid::samples::Block;

/// A part, all samples of which are in a block.
pub(super) struct Ground<'a> {
    pub(super) block: &'a Block,
    pub(super) place: &'a Place,
}

impl Ground<'_> {
    /// The largest error at a sample of the raster on a triangle, in height, the triangle plane on the lattice of the format. The fall
    /// of the ellipsoid is left out: triangles around a vertex that is inserted are small.
    pub(super) fn error(&self, corners: [&Vertex; 3]) -> f64 {
        let [a, b, c] = corners.map(|vertex| self.at(vertex));
        let from_a = |[x, y, z]: [f64; 3]| [x - a[0], y - a[1], z - a[2]];
        let (p, q) = (from_a(b), from_a(c));
        let area = p[0] * q[1] - p[1] * q[0];
        let across = (p[2] * q[1] - q[2] * p[1]) / area;
        let down = (q[2] * p[0] - p[2] * q[0]) / area;
        let side = self.place.cells as usize + 1;
        let (top, bottom) = (a[1].min(b[1]).min(c[1]), a[1].max(b[1]).max(c[1]));
        let mut error = 0.0f64;
        for row in clipped(top, bottom, side) {
            let y = row as f64;
            let first = row * side;
            for column in clipped_row([a, b, c], y, side) {
                if self.block.inside[first + column] {
                    let height = a[2] + across * (column as f64 - a[0]) + down * (y - a[1]);
                    error = error.max((height - self.block.heights[first + column]).abs());
                }
            }
        }
        error
    }

    /// Column, row and height.
    fn at(&self, vertex: &Vertex) -> [f64; 3] {
        let Place { tile_cells, first, .. } = *self.place;
        let (u, v) = vertex.coordinates(tile_cells);
        let cells = |at: i64, first: i64| at as f64 * tile_cells as f64 / SPAN as f64 - first as f64;
        [cells(u, first.0), cells(SPAN - v, first.1), vertex.height]
    }
}

/// The columns of a row that are between the edges of a triangle.
fn clipped_row([a, b, c]: [[f64; 3]; 3], row: f64, count: usize) -> std::ops::Range<usize> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for ([px, py, _], [qx, qy, _]) in [(a, b), (b, c), (c, a)] {
        if py.min(qy) <= row && row <= py.max(qy) {
            let met = if py == qy { [px, qx] } else { [px + (row - py) / (qy - py) * (qx - px); 2] };
            (low, high) = met.iter().fold((low, high), |(low, high), x| (low.min(*x), high.max(*x)));
        }
    }
    clipped(low, high, count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::Body;
    use crate::pyramid::fall::Fall;
    use crate::pyramid::grid::Grid;
    use proptest::prelude::*;

    proptest! {
        /// Against a look at every sample of the part.
        #[test]
        fn the_worst_sample_is_found(
            corners in prop::array::uniform3((0i64..=16, 0i64..=16, -50.0f64..50.0)),
            heights in prop::collection::vec(-50.0f64..50.0, 17 * 17),
            gap in 0usize..17 * 17,
        ) {
            let mut block = Block::default();
            block.inside = vec![true; heights.len()];
            block.inside[gap] = false;
            block.heights = heights;
            // The lattice has a place for each sample then, and none between.
            let body = Body { semi_major: 1.0, semi_minor: 1.0 };
            let fall = Fall { body, grid: Grid { exponent: 16 }, top: 75, cells: 16 };
            let (tolerance, tolerance_of_sides) = (1.0, 1.0);
            let (origin, first, cells) = ((3, 5), (40, 70), 16);
            let place = Place { origin, tile_cells: SPAN, first, cells, tolerance, tolerance_of_sides, snap: 1, max_stray: 1.5, fall };
            let vertices = corners.map(|(c, r, height)| Vertex::of_sample(40 + c, 70 + r, height));
            let [a, b, c] = corners;
            let turn = |p: (i64, i64), q: (i64, i64), s: (i64, i64)| {
                (q.0 - p.0) * (s.1 - p.1) - (q.1 - p.1) * (s.0 - p.0)
            };
            let [pa, pb, pc] = [a, b, c].map(|(c, r, _)| (c, r));
            let area = turn(pa, pb, pc);
            prop_assume!(area != 0);
            let mut expected = 0.0f64;
            for i in (0..17 * 17).filter(|&i| i != gap) {
                let at = (i as i64 % 17, i as i64 / 17);
                let weights = [turn(pb, pc, at), turn(pc, pa, at), turn(pa, pb, at)].map(|w| w * area.signum());
                if weights.iter().all(|w| *w >= 0) {
                    let sum: f64 = weights.iter().zip([a.2, b.2, c.2]).map(|(w, height)| *w as f64 * height).sum();
                    expected = expected.max((sum / area.abs() as f64 - block.heights[i]).abs());
                }
            }
            let found = Ground { block: &block, place: &place }.error([&vertices[0], &vertices[1], &vertices[2]]);
            // Samples on an edge may be missed by a rounding.
            prop_assert!(found <= expected + 1e-9, "{} of {}", found, expected);
            let inner = (0..17 * 17).filter(|&i| i != gap).filter(|&i| {
                let at = (i as i64 % 17, i as i64 / 17);
                [turn(pb, pc, at), turn(pc, pa, at), turn(pa, pb, at)].iter().all(|w| w * area.signum() > 0)
            });
            for i in inner {
                let at = (i as i64 % 17, i as i64 / 17);
                let weights = [turn(pb, pc, at), turn(pc, pa, at), turn(pa, pb, at)];
                let sum: f64 = weights.iter().zip([a.2, b.2, c.2]).map(|(w, height)| *w as f64 * height).sum();
                prop_assert!(found >= (sum / area as f64 - block.heights[i]).abs() - 1e-9);
            }
        }
    }
}
