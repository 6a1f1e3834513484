//! Places as seen from an edge of the front, and whether a bite may reach them.

use super::Edge;
use super::front::{Apex, Front};
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::Tester;

/// Whether the triangle from an edge to a place is inside the ground and feasible, and what it meets there.
pub(super) fn feasible_apex(front: &Front, tester: &Tester<'_>, edge: Edge, vertex: Vertex) -> Option<Apex> {
    let apex = front.visible_apex(edge, vertex)?;
    let (a, b) = (front.vertex(edge.0), front.vertex(edge.1));
    tester.feasible([a, b, vertex], &[(a, vertex), (b, vertex)]).then_some(apex)
}

/// The vertex at the sample nearest to a place, given in cells; `None` beyond the tile.
pub(super) fn nearest_sample(tester: &Tester<'_>, column: f64, row: f64) -> Option<Vertex> {
    let (column, row) = (column.round(), row.round());
    let tile = tester.tile();
    let inside = column >= 0.0 && row >= 0.0 && column < tile.width() as f64 && row < tile.height() as f64;
    inside.then(|| Vertex {
        at: Point::of_sample(column as i32, row as i32),
        height: tile.at(column as usize, row as usize),
    })
}

/// An edge as seen from its left side, in cells.
pub(super) struct Base {
    middle: (f64, f64),
    along: (f64, f64),
    normal: (f64, f64),
    pub(super) length: f64,
}

impl Base {
    pub(super) fn of(a: Point, b: Point) -> Base {
        let cells = |steps: i32| f64::from(steps) / f64::from(STEPS);
        let (dx, dy) = (cells(b.x - a.x), cells(b.y - a.y));
        let length = (dx * dx + dy * dy).sqrt();
        let along = (dx / length, dy / length);
        let middle = (cells(a.x + b.x) / 2.0, cells(a.y + b.y) / 2.0);
        Base { middle, along, normal: (-along.1, along.0), length }
    }

    /// The sample nearest to a place, given by its distance from the middle along the edge and away from it.
    pub(super) fn sample(&self, tester: &Tester<'_>, along: f64, away: f64) -> Option<Vertex> {
        let column = self.middle.0 + self.along.0 * along + self.normal.0 * away;
        let row = self.middle.1 + self.along.1 * along + self.normal.1 * away;
        nearest_sample(tester, column, row)
    }
}
