//! How sharp triangles may be, seen from above.
//!
//! The smallest angle lies between the two longer sides and is at most 60°, so it grows with the square of its sine,
//! which takes no root: (twice the area)² over the product of the two longer sides' squares. Its factors are exact, it is
//! the same for every order of the corners, and nothing of it is left to a library's rounding.

use crate::base::lattice::{distance2, orient};
use crate::base::mesh::Vertex;

/// A floor for the smallest angle of every triangle that is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Angles {
    least: f64,
}

/// What a move may make of the triangles it replaces.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sharpest {
    least: f64,
}

impl Angles {
    /// No floor.
    pub(super) const ANY: Angles = Angles { least: 0.0 };

    /// A floor in degrees, from 0 to 60.
    pub(super) fn at_least(degrees: f64) -> Angles {
        assert!((0.0..=60.0).contains(&degrees), "a floor for angles of {degrees} degrees");
        let sine = sine(degrees * (std::f64::consts::PI / 180.0));
        Angles { least: sine * sine }
    }

    /// How sharp triangles may be that replace these: as the floor says, or where one of these is sharper, as that.
    #[inline(always)]
    pub(super) fn bound(&self, replaced: impl Iterator<Item = [Vertex; 3]>) -> Sharpest {
        if self.least == 0.0 {
            return Sharpest { least: 0.0 };
        }
        let mut least = self.least;
        for corners in replaced {
            // Few are that sharp, and only these take a division.
            if !(Sharpest { least: least * (1.0 + 8.0 * f64::EPSILON) }).allows(corners) {
                least = least.min(sharpness(corners));
            }
        }
        Sharpest { least }
    }
}

impl Sharpest {
    /// Whether every triangle will do.
    #[inline(always)]
    pub(super) fn allows_any(&self) -> bool {
        self.least == 0.0
    }

    /// Whether a triangle with positive orientation may be made.
    #[inline(always)]
    pub(super) fn allows(&self, corners: [Vertex; 3]) -> bool {
        if self.allows_any() {
            return true;
        }
        let (area, sides) = area_and_sides(corners);
        area * area >= self.least * sides
    }
}

/// The square of the sine of the smallest angle.
pub(super) fn sharpness(corners: [Vertex; 3]) -> f64 {
    let (area, sides) = area_and_sides(corners);
    // As much less as may be lost when it is multiplied again: a triangle is never sharper than itself.
    area * area / sides * (1.0 - 4.0 * f64::EPSILON)
}

/// Twice the area, and the product of the two longer sides' squares.
#[inline(always)]
fn area_and_sides(corners: [Vertex; 3]) -> (f64, f64) {
    let [a, b, c] = corners.map(|v| v.at);
    let [ab, bc, ca] = [distance2(a, b), distance2(b, c), distance2(c, a)].map(|square| square as f64);
    (orient(a, b, c) as f64, (ab * bc).max(bc * ca).max(ca * ab))
}

/// By its series, up to π/3: standard libraries differ in the last bit.
fn sine(x: f64) -> f64 {
    let (mut term, mut sum) = (x, x);
    for n in 1..12 {
        term *= -x * x / f64::from(2 * n * (2 * n + 1));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::Point;

    #[test]
    fn a_right_angle_halved_is_45_degrees() {
        let vertex = |x, y| Vertex { at: Point { x, y }, height: 0.0 };
        let corners = [vertex(0, 0), vertex(8, 0), vertex(0, 8)];
        assert!((sharpness(corners) - 0.5).abs() < 1e-15);
        let [a, b, c] = corners;
        assert_eq!(sharpness([b, c, a]), sharpness(corners));
        for (floor, allowed) in [(0.0, true), (44.9, true), (45.1, false)] {
            let bound = Angles::at_least(floor).bound(std::iter::empty());
            assert_eq!(bound.allows(corners), allowed, "{floor}");
        }
        let sharp = [vertex(0, 0), vertex(80, 0), vertex(80, 1)];
        let bound = Angles::at_least(30.0).bound([corners, sharp].into_iter());
        assert!(bound.allows(sharp) && !bound.allows([vertex(0, 0), vertex(81, 0), vertex(81, 1)]));
    }

    #[test]
    fn the_series_is_the_sine() {
        for i in 0..=60 {
            let x = f64::from(i).to_radians();
            assert!((sine(x) - x.sin()).abs() < 1e-15, "{i}");
        }
    }
}
