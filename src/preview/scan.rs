//! The places of a grid inside a triangle.

use std::ops::Range;

/// A corner of a triangle in the plane.
pub(super) type Point = (f64, f64);

/// Calls `visit` for every whole-numbered point (x, y) in the triangle, its rim included, that lies in the ranges.
/// The triangle may turn either way; one without area has no points.
pub(super) fn points_inside(
    triangle: [Point; 3],
    xs: Range<usize>,
    ys: Range<usize>,
    mut visit: impl FnMut(usize, usize),
) {
    let [a, b, c] = triangle;
    let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let [a, b, c] = if area > 0.0 { [a, b, c] } else { [a, c, b] };
    let top = a.1.min(b.1).min(c.1).max(ys.start as f64).ceil();
    let bottom = a.1.max(b.1).max(c.1).min(ys.end as f64 - 1.0).floor();
    let mut y = top;
    while y <= bottom {
        // Each edge a half-plane, so each a bound on x. The slack keeps points on a shared edge from falling between
        // the two triangles by rounding.
        let (mut from, mut to) = (xs.start as f64, xs.end as f64 - 1.0);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (dx, dy) = (q.0 - p.0, q.1 - p.1);
            if dy == 0.0 {
                if dx * (y - p.1) < 0.0 {
                    to = f64::NEG_INFINITY;
                }
                continue;
            }
            let x = p.0 + dx * (y - p.1) / dy;
            if dy > 0.0 { to = to.min(x + SLACK) } else { from = from.max(x - SLACK) }
        }
        let mut x = from.ceil();
        while x <= to {
            visit(x as usize, y as usize);
            x += 1.0;
        }
        y += 1.0;
    }
}

const SLACK: f64 = 1e-7;

#[cfg(test)]
mod tests {
    use super::*;

    fn inside(triangle: [Point; 3]) -> Vec<(usize, usize)> {
        let mut found = Vec::new();
        points_inside(triangle, 0..10, 0..10, |x, y| found.push((x, y)));
        found
    }

    #[test]
    fn both_turns_hold_the_rim() {
        let expected = [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (0, 2)];
        assert_eq!(inside([(0.0, 0.0), (2.0, 0.0), (0.0, 2.0)]), expected);
        assert_eq!(inside([(0.0, 0.0), (0.0, 2.0), (2.0, 0.0)]), expected);
    }

    #[test]
    fn outside_and_flat_triangles_hold_nothing() {
        assert_eq!(inside([(20.0, 0.0), (22.0, 0.0), (20.0, 2.0)]), []);
        assert_eq!(inside([(-5.0, -5.0), (-1.0, -5.0), (-5.0, -1.0)]), []);
        assert_eq!(inside([(0.0, 0.0), (5.0, 5.0), (9.0, 9.0)]), []);
        assert_eq!(inside([(0.0, f64::NAN), (5.0, 5.0), (9.0, 2.0)]), []);
    }

    #[test]
    fn a_covering_triangle_is_clipped() {
        assert_eq!(inside([(-100.0, -100.0), (300.0, -100.0), (-100.0, 300.0)]).len(), 100);
    }
}
