use crate::lattice::{Point, STEPS, distance2, dot, orient};
use crate::mesh::Vertex;

/// An edge a–b as a frame of coordinates: `along` runs from 0 at a to 1 at b, `away` from the edge's line to its left,
/// both in units of the edge's length. The planes through the edge have one free parameter, the tilt.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) a: Vertex,
    pub(super) b: Vertex,
    /// The square of the length, in steps; an integer.
    pub(super) length2: f64,
    inverse: f64,
    rise: f64,
}

impl Frame {
    pub(super) fn new(a: Vertex, b: Vertex) -> Frame {
        let length2 = distance2(a.at, b.at) as f64;
        Frame { a, b, length2, inverse: 1.0 / length2, rise: b.height - a.height }
    }

    /// Along and away, rounded.
    #[inline(always)]
    pub(super) fn coordinates(&self, p: Point) -> (f64, f64) {
        let along = dot(self.a.at, self.b.at, p) as f64;
        let away = orient(self.a.at, self.b.at, p) as f64;
        (along * self.inverse, away * self.inverse)
    }

    /// What one column more adds to along and away.
    pub(super) fn step(&self) -> (f64, f64) {
        let (ux, uy) = (self.b.at.x - self.a.at.x, self.b.at.y - self.a.at.y);
        (f64::from(ux * STEPS) * self.inverse, f64::from(-uy * STEPS) * self.inverse)
    }

    /// Column and row of a place.
    pub(super) fn place(&self, along: f64, away: f64) -> (f64, f64) {
        let (ux, uy) = (f64::from(self.b.at.x - self.a.at.x), f64::from(self.b.at.y - self.a.at.y));
        let cells = 1.0 / f64::from(STEPS);
        let x = f64::from(self.a.at.x) + ux * along - uy * away;
        let y = f64::from(self.a.at.y) + uy * along + ux * away;
        (x * cells, y * cells)
    }

    /// How far a height is above the edge's line, read at the foot of the place's perpendicular.
    #[inline(always)]
    pub(super) fn above(&self, along: f64, height: f64) -> f64 {
        (height - self.a.height) - self.rise * along
    }

    /// The size of the numbers that `above` computes with: its rounding error is a few units of 2⁻⁵³ of this and of
    /// its result, for places up to a few lengths away.
    pub(super) fn magnitude(&self) -> f64 {
        self.a.height.abs() + 4.0 * self.rise.abs()
    }
}
