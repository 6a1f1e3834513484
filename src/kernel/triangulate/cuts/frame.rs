//! Coordinates of an edge: along it and away from it.

use crate::base::lattice::{Point, STEPS, distance2, dot, orient};
use crate::base::mesh::Vertex;

/// An edge a–b as a frame of coordinates, both in units of its length: `along` runs from 0 at a to 1 at b, `away` to the
/// left of the edge's line. A plane through the edge is given by its tilt: how much it rises over one length away.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) a: Vertex,
    pub(super) b: Vertex,
    /// From a to b, in lattice steps.
    u: (f64, f64),
    /// The square of the length.
    length2: f64,
    inverse: f64,
    rise: f64,
}

/// The coordinates of the samples of one row, before the division by the length's square: integers, exact in doubles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    along: f64,
    along_step: f64,
    away: f64,
    away_step: f64,
}

impl Frame {
    pub(super) fn new(a: Vertex, b: Vertex) -> Frame {
        let length2 = distance2(a.at, b.at) as f64;
        let u = (f64::from(b.at.x - a.at.x), f64::from(b.at.y - a.at.y));
        Frame { a, b, u, length2, inverse: 1.0 / length2, rise: b.height - a.height }
    }

    /// The edge's length, in cells.
    pub(super) fn length(&self) -> f64 {
        self.length2.sqrt() / f64::from(STEPS)
    }

    /// How many samples there are to the triangle over the edge whose apex is 1 away, about.
    pub(super) fn samples(&self) -> f64 {
        self.length2 / f64::from(2 * STEPS * STEPS)
    }

    /// Along and away of a place.
    #[inline(always)]
    pub(super) fn coordinates(&self, p: Point) -> (f64, f64) {
        let (a, b) = (self.a.at, self.b.at);
        (dot(a, b, p) as f64 * self.inverse, orient(a, b, p) as f64 * self.inverse)
    }

    /// Column and row of a place.
    #[inline(always)]
    pub(super) fn place(&self, along: f64, away: f64) -> (f64, f64) {
        const CELLS: f64 = 1.0 / STEPS as f64;
        let x = f64::from(self.a.at.x) + self.u.0 * along - self.u.1 * away;
        let y = f64::from(self.a.at.y) + self.u.1 * along + self.u.0 * away;
        (x * CELLS, y * CELLS)
    }

    /// The samples of a row.
    #[inline(always)]
    pub(super) fn row(&self, row: i32) -> Row {
        let (x, y) = (f64::from(self.a.at.x), f64::from(row * STEPS - self.a.at.y));
        Row {
            along: self.u.1 * y - self.u.0 * x,
            along_step: self.u.0 * f64::from(STEPS),
            away: self.u.0 * y + self.u.1 * x,
            away_step: -self.u.1 * f64::from(STEPS),
        }
    }

    /// Along and away of a sample of a row. The sign of away is exact.
    #[inline(always)]
    pub(super) fn in_row(&self, row: &Row, column: f64) -> (f64, f64) {
        ((row.along + row.along_step * column) * self.inverse, (row.away + row.away_step * column) * self.inverse)
    }

    /// How far a height is above the edge's line, read at the foot of the perpendicular from its place.
    #[inline(always)]
    pub(super) fn above(&self, along: f64, height: f64) -> f64 {
        (height - self.a.height) - self.rise * along
    }

    /// Near places up to a few lengths from the edge, the rounding of [`Frame::above`] is below 2⁻⁵⁰ of this and of
    /// what it returns.
    pub(super) fn magnitude(&self) -> f64 {
        self.a.height.abs() + 4.0 * self.rise.abs()
    }
}
