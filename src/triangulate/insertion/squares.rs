//! Squared errors, triangle by triangle, for goals of root mean square.

use super::scan::Scan;
use crate::field::Tile;
use crate::mesh::Vertex;
use crate::triangulate::feasible::Spans;

/// The sum of squares of every triangle. Memory: 8 bytes per triangle.
#[derive(Debug, Default)]
pub(super) struct Squares {
    of: Vec<f64>,
}

impl Squares {
    pub(super) fn clear(&mut self) {
        self.of.clear();
    }

    /// Notes a triangle's sum; what it was before, 0 for a new triangle.
    pub(super) fn replace(&mut self, t: u32, now: f64) -> f64 {
        if t as usize >= self.of.len() {
            self.of.resize(t as usize + 1, 0.0);
        }
        std::mem::replace(&mut self.of[t as usize], now)
    }
}

/// The sum of squared errors of the samples that are a triangle's own (a sample on an edge belongs to one of its
/// triangles) and the tile's: all but those in its last column and row, unless `owns` says that it has them.
pub(super) fn of_triangle(tile: &Tile, corners: [Vertex; 3], (last_column, last_row): (bool, bool)) -> f64 {
    let (scan, [a, b, c]) = (Scan::new(tile.width(), corners), corners);
    let spans = Spans::new(a.at, b.at, c.at);
    let (right, bottom) = (tile.width() as i32 - 1, tile.height() as i32 - 1);
    let (most_right, most_down) = (right - i32::from(!last_column), bottom - i32::from(!last_row));
    let mut sum = 0.0;
    for row in spans.rows().filter(|&row| row <= most_down) {
        let (first, last) = spans.own_columns(row, right, bottom);
        for column in first..=last.min(most_right) {
            let error = scan.error(column, row, tile.at(column as usize, row as usize));
            sum += error * error;
        }
    }
    sum
}
