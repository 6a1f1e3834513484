//! The plane of a triangle at samples, exact where it matters.

use super::coarse_doubles;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;

/// The plane of a triangle, as weights of its corners.
///
/// At a place p inside, the weights orient(b,c,p), orient(c,a,p), orient(a,b,p) are not negative and sum up to
/// orient(a,b,c). A value computed from them is off by a few roundings of the largest corner height, however thin the
/// triangle: unlike one carried along by gradients, which on a sliver are nearly infinite.
pub(crate) struct Plane {
    corners: [Vertex; 3],
    /// orient(a,b,c), positive.
    pub(crate) area: i64,
    inverse: f64,
    /// Heights of b and c above a.
    rise: [f64; 2],
}

impl Plane {
    /// Through three vertices with positive orientation.
    #[inline(always)]
    pub(crate) fn new(a: Vertex, b: Vertex, c: Vertex) -> Plane {
        let area = orient(a.at, b.at, c.at);
        debug_assert!(area > 0, "orientation {area} of {a:?} {b:?} {c:?}");
        Plane { corners: [a, b, c], area, inverse: 1.0 / area as f64, rise: [b.height - a.height, c.height - a.height] }
    }

    /// The weights of b and c at a place.
    #[inline(always)]
    fn weights(&self, p: Point) -> (i64, i64) {
        let [a, b, c] = self.corners.map(|v| v.at);
        (orient(c, a, p), orient(a, b, p))
    }

    /// Height above corner a, at a place inside the triangle.
    #[inline(always)]
    pub(crate) fn above_a(&self, p: Point) -> f64 {
        let (wb, wc) = self.weights(p);
        (wb as f64 * self.rise[0] + wc as f64 * self.rise[1]) * self.inverse
    }

    /// Height at a place inside the triangle.
    #[inline(always)]
    pub(crate) fn at(&self, p: Point) -> f64 {
        self.corners[0].height + self.above_a(p)
    }

    /// Rise from one sample to the next of a row.
    pub(crate) fn step(&self) -> f64 {
        let [a, b, c] = self.corners.map(|v| v.at);
        let (wb, wc) = (f64::from(c.y - a.y), f64::from(a.y - b.y));
        (wb * self.rise[0] + wc * self.rise[1]) * self.inverse * f64::from(STEPS)
    }

    /// The weight of corner a at a place inside the triangle, as a share of all three.
    #[inline(always)]
    pub(crate) fn share_of_a(&self, p: Point) -> f64 {
        let [_, b, c] = self.corners.map(|v| v.at);
        orient(b, c, p) as f64 * self.inverse
    }

    /// By how much it grows from one sample to the next of a row.
    pub(crate) fn share_step(&self) -> f64 {
        let [_, b, c] = self.corners.map(|v| v.at);
        f64::from(b.y - c.y) * self.inverse * f64::from(STEPS)
    }

    /// The weights of corners b and c at a place, as shares of all three.
    #[inline(always)]
    fn shares(&self, p: Point) -> [f64; 2] {
        let (wb, wc) = self.weights(p);
        [wb as f64 * self.inverse, wc as f64 * self.inverse]
    }

    /// Rise per lattice step across and down. On a sliver nearly infinite: for estimates.
    #[inline(always)]
    pub(crate) fn gradient(&self) -> [f64; 2] {
        let [Vertex { at: a, .. }, Vertex { at: b, .. }, Vertex { at: c, .. }] = self.corners;
        let (up_b, up_c) = (self.rise[0] * self.inverse, self.rise[1] * self.inverse);
        [
            f64::from(c.y - a.y) * up_b - f64::from(b.y - a.y) * up_c,
            f64::from(b.x - a.x) * up_c - f64::from(c.x - a.x) * up_b,
        ]
    }

    /// The place of corner a.
    pub(crate) fn origin(&self) -> Point {
        self.corners[0].at
    }

    /// The largest distance of a corner's height from `reference`: no value inside is farther.
    pub(crate) fn reach(&self, reference: f64) -> f64 {
        self.corners.iter().map(|v| (v.height - reference).abs()).fold(0.0, f64::max)
    }

    /// How far a height at a place inside is from the plane, correctly rounded.
    pub(crate) fn distance(&self, p: Point, height: f64) -> f64 {
        let (wb, wc) = self.weights(p);
        let [a, b, c] = self.corners.map(|v| v.height);
        crate::base::exact::quotient(&[(self.area - wb - wc, a), (wb, b), (wc, c), (-self.area, height)], self.area)
    }

    /// A bound of what rounding does to a distance from the plane that is found by [`Plane::at`] and [`Plane::step`], beside
    /// the rounding of the distance itself. 0 where the plane is level, and only there: the one subtraction is rounded
    /// correctly. Elsewhere it is never 0, as shares of the smallest numbers there are would be.
    pub(crate) fn doubt(&self) -> f64 {
        let [rise_b, rise_c] = self.rise.map(f64::abs);
        let rise = rise_b.max(rise_c);
        let largest = self.corners.iter().map(|v| v.height.abs()).fold(0.0, f64::max);
        if rise == 0.0 { 0.0 } else { 16.0 * f64::EPSILON * (rise + largest) + coarse_doubles(rise) }
    }

    /// Whether a height at a place inside is within the tolerance of the plane, exactly.
    pub(crate) fn within(&self, p: Point, height: f64, tolerance: f64) -> bool {
        let (wb, wc) = self.weights(p);
        let [a, b, c] = self.corners.map(|v| v.height);
        let terms = [(self.area - wb - wc, a), (wb, b), (wc, c), (-self.area, height)];
        crate::base::exact::within(&terms, self.area, tolerance)
    }
}

/// The shares of a triangle's corners b and c along a row of samples: with them any value over the triangle is known there.
pub(crate) struct RowShares {
    first: [f64; 2],
    step: [f64; 2],
}

impl RowShares {
    /// Along the row of a plane's triangle, from a sample inside it on.
    #[inline(always)]
    pub(crate) fn new(plane: &Plane, first: Point) -> RowShares {
        let [a, b, c] = plane.corners.map(|v| v.at);
        let step = |down: i32| f64::from(down) * plane.inverse * f64::from(STEPS);
        RowShares { first: plane.shares(first), step: [step(c.y - a.y), step(a.y - b.y)] }
    }

    /// A value that rises by so much from a to b and from a to c: by how much it is above a at the first sample, and what it
    /// rises from one sample to the next.
    #[inline(always)]
    pub(crate) fn line(&self, [to_b, to_c]: [f64; 2]) -> (f64, f64) {
        let at = |[b, c]: [f64; 2]| b * to_b + c * to_c;
        (at(self.first), at(self.step))
    }
}
