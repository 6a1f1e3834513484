//! Places in fixed point: the lattice of quarter cells, and the exact predicates on it.
//!
//! A tile's local lattice has its origin at the tile's first sample; the sample at local column c, row r lies on
//! (4c, 4r). y runs down the rows, so a positive turn here is clockwise on a north-up map. Coordinates stay below
//! [`MAX_SPAN`], which makes every product of two differences exact in `i64` and in `f64`.

/// Lattice steps in one cell.
pub const STEPS: i32 = 4;

/// The longest side of a tile, in cells: spans stay below 2²⁰ steps.
pub const MAX_TILE_CELLS: usize = (1 << 18) - 1;

/// Upper bound of a difference of two tile-local coordinates.
pub const MAX_SPAN: i32 = 1 << 20;

/// A place on a tile's lattice of quarter cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Point {
    /// Across, in quarter cells.
    pub x: i32,
    /// Down, in quarter cells.
    pub y: i32,
}

impl Point {
    /// The place of the sample at this column and row.
    pub const fn of_sample(column: i32, row: i32) -> Point {
        Point { x: column * STEPS, y: row * STEPS }
    }

    /// Column and row of the sample at this place, if there is one.
    pub fn sample(self) -> Option<(usize, usize)> {
        let on_grid = self.x % STEPS == 0 && self.y % STEPS == 0 && self.x >= 0 && self.y >= 0;
        on_grid.then_some(((self.x / STEPS) as usize, (self.y / STEPS) as usize))
    }
}

/// Twice the signed area of the triangle `a`, `b`, `c`, in square lattice steps; positive where `c` lies to the left
/// of a→b in the lattice's own orientation. Exact.
#[inline(always)]
pub fn orient(a: Point, b: Point, c: Point) -> i64 {
    let (ux, uy) = ((b.x - a.x) as i64, (b.y - a.y) as i64);
    let (vx, vy) = ((c.x - a.x) as i64, (c.y - a.y) as i64);
    ux * vy - uy * vx
}

/// Scalar product of a→b and a→c. Exact.
#[inline(always)]
pub fn dot(a: Point, b: Point, c: Point) -> i64 {
    let (ux, uy) = ((b.x - a.x) as i64, (b.y - a.y) as i64);
    let (vx, vy) = ((c.x - a.x) as i64, (c.y - a.y) as i64);
    ux * vx + uy * vy
}

/// Square of the distance. Exact.
#[inline(always)]
pub fn distance2(a: Point, b: Point) -> i64 {
    dot(a, b, b)
}

/// Spans up to which the incircle determinant fits an `i64`: with differences of at most n its three products are at
/// most 2n²·n² each in magnitude, together below 6·n⁴, and 6·35,000⁴ ≈ 9.004·10¹⁸ < 2⁶³ ≈ 9.22·10¹⁸.
const NARROW_SPAN: i32 = 35_000;

/// Whether `d` lies strictly inside the circle through `a`, `b`, `c` (positive orientation). Exact for every tile:
/// differences are taken to `d` first, so what counts is how far the four places lie apart, not where; up to
/// 35,000 steps 64 bits hold the determinant, and below [`MAX_SPAN`] = 2²⁰ it stays below 6·2⁸⁰, so 128 bits do.
#[inline]
pub fn in_circle(a: Point, b: Point, c: Point, d: Point) -> bool {
    let from_d = [a, b, c].map(|p| (p.x - d.x, p.y - d.y));
    let narrow = from_d.iter().all(|(x, y)| x.abs() <= NARROW_SPAN && y.abs() <= NARROW_SPAN);
    if narrow {
        let [a, b, c] = from_d.map(|(x, y)| (i64::from(x), i64::from(y)));
        let lift = |p: (i64, i64)| p.0 * p.0 + p.1 * p.1;
        let minor = |p: (i64, i64), q: (i64, i64)| p.0 * q.1 - p.1 * q.0;
        return lift(a) * minor(b, c) + lift(b) * minor(c, a) + lift(c) * minor(a, b) > 0;
    }
    let [a, b, c] = from_d.map(|(x, y)| (i128::from(x), i128::from(y)));
    let lift = |p: (i128, i128)| p.0 * p.0 + p.1 * p.1;
    let minor = |p: (i128, i128), q: (i128, i128)| p.0 * q.1 - p.1 * q.0;
    lift(a) * minor(b, c) + lift(b) * minor(c, a) + lift(c) * minor(a, b) > 0
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// The determinant as it stands in books, in integers of any size.
    fn book_in_circle(a: Point, b: Point, c: Point, d: Point) -> bool {
        let row = |p: Point| {
            let (x, y) = (BigInt::from(p.x) - d.x, BigInt::from(p.y) - d.y);
            let lift = &x * &x + &y * &y;
            [x, y, lift]
        };
        let ([ax, ay, az], [bx, by, bz], [cx, cy, cz]) = (row(a), row(b), row(c));
        let det = &ax * (&by * &cz - &bz * &cy) - &ay * (&bx * &cz - &bz * &cx) + &az * (&bx * &cy - &by * &cx);
        det > BigInt::from(0)
    }

    fn wide(a: Point, b: Point, c: Point) -> i128 {
        let d = |p: i32, q: i32| i128::from(q) - i128::from(p);
        d(a.x, b.x) * d(a.y, c.y) - d(a.y, b.y) * d(a.x, c.x)
    }

    proptest! {
        #[test]
        fn orientation_is_exact_over_the_whole_span(v in prop::array::uniform6(0..MAX_SPAN)) {
            let [a, b, c] = [(v[0], v[1]), (v[2], v[3]), (v[4], v[5])].map(|(x, y)| Point { x, y });
            prop_assert_eq!(i128::from(orient(a, b, c)), wide(a, b, c));
            prop_assert_eq!(orient(a, b, c), orient(b, c, a));
            prop_assert_eq!(orient(a, b, c), -orient(b, a, c));
        }

        #[test]
        fn the_circle_test_is_exact_whatever_the_span(
            v in prop::array::uniform8(0..MAX_SPAN), scale in prop_oneof![Just(1), Just(16), Just(30), Just(1 << 17)],
        ) {
            let at = |i: usize| Point { x: v[i] / scale, y: v[i + 1] / scale };
            let [a, b, c, d] = [at(0), at(2), at(4), at(6)];
            prop_assume!(orient(a, b, c) != 0);
            let (b, c) = if orient(a, b, c) > 0 { (b, c) } else { (c, b) };
            prop_assert_eq!(in_circle(a, b, c, d), book_in_circle(a, b, c, d));
        }
    }

    #[test]
    fn four_places_on_a_circle_are_not_inside() {
        for n in [1, 35_000, 35_001, MAX_SPAN - 1] {
            let [a, b, c, d] = [(0, 0), (n, 0), (n, n), (0, n)].map(|(x, y)| Point { x, y });
            assert!(!in_circle(a, b, c, d) && !in_circle(b, c, d, a));
            assert!(in_circle(a, b, c, Point { x: 0, y: n - 1 }) || n == 1);
        }
    }

    #[test]
    fn samples_lie_on_multiples_of_four() {
        assert_eq!(Point::of_sample(3, 5).sample(), Some((3, 5)));
        assert_eq!(Point { x: 13, y: 20 }.sample(), None);
    }
}
