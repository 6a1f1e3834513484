//! Where edges cross a quarter row.

use std::cmp::Ordering;

/// Where an edge crosses a quarter row, in lattice steps, exactly: `whole` + `part` / `of`, `part` below `of`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    pub(super) whole: i64,
    part: u64,
    of: u64,
}

impl Crossing {
    /// At a lattice point.
    pub(super) fn at(x: i64) -> Crossing {
        Crossing { whole: x, part: 0, of: 1 }
    }

    /// In parts of a step, of which its own parts are a divisor.
    pub(super) fn parts(self, parts: i128) -> i128 {
        i128::from(self.whole) * parts + i128::from(self.part) * parts / i128::from(self.of)
    }

    /// Of the edge between two lattice points, the first one above the other, with a quarter row that both are on or
    /// beside. Coordinates are below 2⁴¹, products below 2⁸².
    pub(super) fn of(upper: (i64, i64), lower: (i64, i64), y: i64) -> Crossing {
        let (run, rise, down) = (lower.0 - upper.0, lower.1 - upper.1, y - upper.1);
        if run == 0 {
            return Crossing::at(upper.0);
        }
        let (steps, part) = match run.checked_mul(down) {
            Some(product) => (product.div_euclid(rise), product.rem_euclid(rise)),
            None => {
                let (product, rise) = (i128::from(run) * i128::from(down), i128::from(rise));
                (product.div_euclid(rise) as i64, product.rem_euclid(rise) as i64)
            }
        };
        Crossing { whole: upper.0 + steps, part: part as u64, of: rise as u64 }
    }
}

impl Ord for Crossing {
    fn cmp(&self, other: &Crossing) -> Ordering {
        self.whole.cmp(&other.whole).then_with(|| match (self.part, other.part) {
            (0, 0) => Ordering::Equal,
            (part, other_part) => {
                (u128::from(part) * u128::from(other.of)).cmp(&(u128::from(other_part) * u128::from(self.of)))
            }
        })
    }
}

impl PartialOrd for Crossing {
    fn partial_cmp(&self, other: &Crossing) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Crossing {
    fn eq(&self, other: &Crossing) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Crossing {}

/// A side of something within a quarter row: where it crosses the line above, and the line below.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Side {
    pub(super) top: Crossing,
    pub(super) bottom: Crossing,
}

impl Side {
    /// Whether it is nowhere to the right of another. Sides are straight: what holds at both lines holds between them.
    pub(super) fn is_left_of(&self, other: &Side) -> bool {
        self.top <= other.top && self.bottom <= other.bottom
    }
}

/// What lies between two sides, within a quarter row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Span {
    pub(super) left: Side,
    pub(super) right: Side,
}

impl Span {
    /// Whether it holds all of another.
    pub(super) fn holds(&self, other: &Span) -> bool {
        self.left.is_left_of(&other.left) && other.right.is_left_of(&self.right)
    }

    /// Whether it lies to the left of another, all of it.
    pub(super) fn is_before(&self, other: &Span) -> bool {
        self.right.is_left_of(&other.left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_are_exact() {
        let third = Crossing::of((0, 0), (1, 3), 1);
        let other = Crossing::of((-2, -5), (5, 10), 0);
        assert_eq!(third, other);
        assert!(Crossing::of((0, 0), (-1, 3), 1) < Crossing::at(0));
        assert!(Crossing::of((0, 0), (-1, 3), 1) > Crossing::at(-1));
        assert_eq!(Crossing::of((7, 2), (3, 6), 6), Crossing::at(3));
        let far = 1 << 40;
        let (near, nearer) =
            (Crossing::of((0, 0), (far - 1, far), far / 2), Crossing::of((0, 0), (far, far + 1), far / 2));
        assert!(near < nearer && nearer < Crossing::at(far / 2));
        assert_eq!((near.whole, near.part, near.of), (far / 2 - 1, far as u64 / 2, far as u64));
    }
}
