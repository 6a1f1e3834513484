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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
    }

    #[test]
    fn samples_lie_on_multiples_of_four() {
        assert_eq!(Point::of_sample(3, 5).sample(), Some((3, 5)));
        assert_eq!(Point { x: 13, y: 20 }.sample(), None);
    }
}
