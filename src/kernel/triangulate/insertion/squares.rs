//! Squared errors, triangle by triangle, for goals of root mean square.

use super::scan::Scan;
use crate::base::Tile;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::Spans;
use crate::kernel::triangulate::progressive::Share;

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

/// The sum of squared errors of those samples that are a triangle's own (a sample on an edge belongs to one of its
/// triangles) and of the tile's share. `locked` edges, i from corner i, have no other triangle.
pub(super) fn of_triangle(tile: &Tile, corners: [Vertex; 3], share: Share<'_>, locked: [bool; 3]) -> f64 {
    let (scan, [a, b, c]) = (Scan::new(tile.width(), corners), corners);
    let spans = Spans::new(a.at, b.at, c.at);
    let mut sum = 0.0;
    let mut add = |column: i32, row: i32| {
        let error = scan.error(column, row, tile.at(column as usize, row as usize));
        sum += error * error;
    };
    match share {
        Share::Rectangle { last_column, last_row } => {
            let (right, bottom) = (tile.width() as i32 - 1, tile.height() as i32 - 1);
            let (most_right, most_down) = (right - i32::from(!last_column), bottom - i32::from(!last_row));
            for row in spans.rows().filter(|&row| row <= most_down) {
                let (first, last) = spans.own_columns(row, right, bottom);
                (first..=last.min(most_right)).for_each(|column| add(column, row));
            }
        }
        Share::Ground(counts) => {
            for row in spans.rows() {
                let (own_first, own_last) = spans.own_columns(row, NO_RIM, NO_RIM);
                if locked == [false; 3] {
                    (own_first..=own_last).for_each(|column| add(column, row));
                    continue;
                }
                let (first, last) = spans.columns(row);
                for column in first..=last {
                    let is_own = match place(corners, Point::of_sample(column, row)) {
                        Place::Corner => false,
                        Place::Edge(i) if locked[i] => counts[row as usize * tile.width() + column as usize],
                        Place::Edge(_) => own_first <= column && column <= own_last,
                        Place::Inside => true,
                    };
                    if is_own {
                        add(column, row);
                    }
                }
            }
        }
    }
    sum
}

/// Neither a column nor a row: the sides of the tile are locked edges like others.
const NO_RIM: i32 = i32::MAX;

enum Place {
    Corner,
    Edge(usize),
    Inside,
}

/// Where a sample of a closed triangle is.
fn place(corners: [Vertex; 3], p: Point) -> Place {
    if corners.iter().any(|v| v.at == p) {
        return Place::Corner;
    }
    let on = |&i: &usize| orient(corners[i].at, corners[(i + 1) % 3].at, p) == 0;
    (0..3).find(on).map_or(Place::Inside, Place::Edge)
}
