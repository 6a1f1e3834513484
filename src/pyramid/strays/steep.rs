//! Where a tile is so steep that edges can stray.

use super::Straightness;
use crate::pyramid::body::{length, minus};
use crate::pyramid::facet::reach;
use crate::pyramid::quantize::SPAN;
use crate::pyramid::surface::{Surface, SurfaceVertex};

impl Straightness<'_> {
    /// Where triangles are so steep that an edge can stray: between two samples that the surface is within an error of, it is farther off by no more than
    /// half of what it rises in a cell. Squares of the tile, by their first and last column and row, and a cell around.
    pub(super) fn steep(&self, surface: &Surface) -> Vec<[[f64; 2]; 2]> {
        let (grid, body) = (self.samples.grid, self.body);
        let (cells, cell) = (grid.cells(surface.tile.level), grid.cell().to_radians());
        let scale = cells as f64 / SPAN as f64;
        let least = 2.0 * (self.limit() - self.max_error);
        let square = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|i| surface.vertices[i as usize]);
            let place = |v: &SurfaceVertex| [v.u as f64 * scale, (SPAN - v.v) as f64 * scale];
            let (p, q, r) = (place(&a), place(&b), place(&c));
            let rise = |v: &SurfaceVertex| (v.quantum - a.quantum) as f64 * surface.lattice.step;
            let (one, other) = ([q[0] - p[0], q[1] - p[1], rise(&b)], [r[0] - p[0], r[1] - p[1], rise(&c)]);
            let area = one[0] * other[1] - one[1] * other[0];
            let along_row = (one[2] * other[1] - other[2] * one[1]) / area;
            let along_column = (other[2] * one[0] - one[2] * other[0]) / area;
            let long = length(minus(b.at, a.at)).max(length(minus(c.at, b.at))).max(length(minus(a.at, c.at)));
            let (columns, rows) = reach(body, [a, b, c].map(|v| [0, 1, 2].map(|k| v.at[k] + surface.centre[k])), cell);
            // Columns and rows are not straight, nor as wide everywhere; a chord's slant changes along it as the ellipsoid's does. Of most of
            // it is known that it does not matter.
            let bent = 8.0 * columns.max(rows) * cell * body.semi_minor / long;
            let turned = 2.0 * long * cell;
            let steepest = 1.25 * libm::hypot(along_row, along_column) / (1.0 - bent) + turned;
            // What is not a number is steep.
            let is_level = bent < 0.5 && steepest < least;
            let ends = |k: usize, reach: f64| {
                let [low, high] = [p[k].min(q[k]).min(r[k]), p[k].max(q[k]).max(r[k])];
                [low - reach - 1.0, high + reach + 1.0]
            };
            let (columns, rows) = (ends(0, columns), ends(1, rows));
            (!is_level).then_some([[columns[0], rows[0]], [columns[1], rows[1]]])
        };
        surface.triangles.iter().filter_map(square).collect()
    }
}
