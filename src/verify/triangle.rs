//! A face, as rows of samples meet it.

use super::grid::{Grid, STEPS, orientation};

/// A triangle that has an area, its corners ordered so that [`orientation`] is positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    pub(super) face: u64,
    pub(super) corners: [(i64, i64); 3],
    pub(super) heights: [f64; 3],
}

/// Words of a triangle's record.
pub(super) const TRIANGLE_WORDS: usize = 11;

/// A triangle's record: sorts by first row, then by face.
pub(super) type TriangleWords = [u64; TRIANGLE_WORDS];

/// The samples of one row in a closed triangle, and those in its interior, as first and last columns. The interior is
/// empty where its first column is after its last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RowSpan {
    pub(super) closed: (i64, i64),
    pub(super) interior: (i64, i64),
}

impl Triangle {
    /// Puts the corners in positive order; `None` where they lie on one line.
    pub(super) fn new(face: u64, corners: [(i64, i64); 3], heights: [f64; 3]) -> Option<Triangle> {
        let ([a, b, c], [za, zb, zc]) = (corners, heights);
        match orientation(a, b, c) {
            0 => None,
            1.. => Some(Triangle { face, corners, heights }),
            _ => Some(Triangle { face, corners: [a, c, b], heights: [za, zc, zb] }),
        }
    }

    pub(super) fn double_area(&self) -> i128 {
        let [a, b, c] = self.corners;
        orientation(a, b, c)
    }

    /// Whether all coordinates are below 2²⁸: 64 bits hold the product of any two differences, times [`STEPS`].
    pub(super) fn is_small(&self) -> bool {
        const LIMIT: i64 = 1 << 28;
        self.corners.iter().all(|(x, y)| x.abs() < LIMIT && y.abs() < LIMIT)
    }

    /// The first and the last row of samples that the closed triangle touches, the first one after the last where it
    /// lies between two rows or off the raster.
    pub(super) fn rows(&self, grid: &Grid) -> (i64, i64) {
        let ys = self.corners.map(|c| c.1);
        let (low, high) = (ys[0].min(ys[1]).min(ys[2]), ys[0].max(ys[1]).max(ys[2]));
        (-(-low).div_euclid(STEPS).min(0), high.div_euclid(STEPS).min(grid.height - 1))
    }

    /// The same, and the row below where it ends between two rows.
    pub(super) fn rows_around(&self, grid: &Grid) -> (i64, i64) {
        let (first, last) = self.rows(grid);
        let high = self.corners[0].1.max(self.corners[1].1).max(self.corners[2].1);
        (first, (-(-high).div_euclid(STEPS)).min(grid.height - 1).max(last))
    }

    pub(super) fn words(&self, first_row: i64) -> TriangleWords {
        let [(ax, ay), (bx, by), (cx, cy)] = self.corners.map(|(x, y)| (x as u64, y as u64));
        let [za, zb, zc] = self.heights.map(f64::to_bits);
        [first_row as u64, self.face, ax, ay, bx, by, cx, cy, za, zb, zc]
    }

    pub(super) fn from_words(w: &TriangleWords) -> Triangle {
        let corner = |at: usize| (w[at] as i64, w[at + 1] as i64);
        Triangle {
            face: w[1],
            corners: [corner(2), corner(4), corner(6)],
            heights: [w[8], w[9], w[10]].map(f64::from_bits),
        }
    }

    /// The samples of a row of `width` samples in the closed triangle, exactly; `None` where there are none.
    pub(super) fn row_span(&self, row: i64, width: i64) -> Option<RowSpan> {
        let (mut closed, mut interior) = ((0, width - 1), (0, width - 1));
        let [a, b, c] = self.corners;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            // A sample at x is to the inner side of pq where at_zero − rise·x > 0, and on it where that is 0.
            let (run, rise) = (i128::from(q.0 - p.0), i128::from(q.1 - p.1));
            let at_zero = rise * i128::from(p.0) + run * i128::from(STEPS * row - p.1);
            let step = i128::from(STEPS) * rise.abs();
            match rise {
                0 if at_zero < 0 => return None,
                0 if at_zero == 0 => interior = (0, -1),
                0 => {}
                1.. => {
                    let (column, on_edge) = divide_wide(at_zero, step);
                    closed.1 = closed.1.min(column);
                    interior.1 = interior.1.min(column - on_edge);
                }
                _ => {
                    let (column, on_edge) = divide_wide(at_zero, step);
                    closed.0 = closed.0.max(-column);
                    interior.0 = interior.0.max(-column + on_edge);
                }
            }
        }
        (closed.0 <= closed.1).then_some(RowSpan { closed, interior })
    }
}

/// The quotient by a positive number, rounded down, and what is left over.
pub(super) fn divide(numerator: i64, step: i64) -> (i64, i64) {
    // Below 2⁵³ a quotient of doubles is rounded to no whole number that it has not reached: those are farther from it than
    // its own last bit. It is found several times as fast.
    let quotient = match numerator.unsigned_abs() < 1 << 52 && step < 1 << 52 {
        true => (numerator as f64 / step as f64) as i64,
        false => numerator / step,
    };
    let rest = numerator - quotient * step;
    if rest < 0 { (quotient - 1, rest + step) } else { (quotient, rest) }
}

/// The quotient rounded down, and 1 where nothing is left over, else 0. Most numerators are small, and a 64-bit
/// division is several times faster.
fn divide_wide(numerator: i128, step: i128) -> (i64, i64) {
    if let (Ok(n), Ok(s)) = (i64::try_from(numerator), i64::try_from(step)) {
        let (quotient, rest) = divide(n, s);
        return (quotient, i64::from(rest == 0));
    }
    let quotient = numerator.div_euclid(step).clamp(-(1 << 60), 1 << 60);
    (quotient as i64, i64::from(numerator.rem_euclid(step) == 0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::base::GeoTransform;

    fn naive(t: &Triangle, column: i64, row: i64) -> (bool, bool) {
        let (p, [a, b, c]) = ((4 * column, 4 * row), t.corners);
        let turns = [orientation(a, b, p), orientation(b, c, p), orientation(c, a, p)];
        (turns.iter().all(|&t| t >= 0), turns.iter().all(|&t| t > 0))
    }

    proptest! {
        #[test]
        fn spans_hold_the_samples_that_orientation_finds(corners in any::<[(i8, i8); 3]>(), row in 0i64..20) {
            let corners = corners.map(|(x, y)| (i64::from(x) / 2, i64::from(y) / 2));
            let Some(t) = Triangle::new(0, corners, [0.0; 3]) else { return Ok(()) };
            let span = t.row_span(row, 12);
            for column in 0..12 {
                let inside = |(first, last): (i64, i64)| first <= column && column <= last;
                let found = (span.is_some_and(|s| inside(s.closed)), span.is_some_and(|s| inside(s.interior)));
                prop_assert_eq!(found, naive(&t, column, row), "column {}, {:?}", column, span);
            }
            let grid = Grid { width: 12, height: 20, transform: GeoTransform::DEFAULT, frame: crate::base::CoordinateFrame::PLAIN };
            let (first, last) = t.rows(&grid);
            let touched = corners.iter().map(|c| c.1).min() <= Some(4 * row) && corners.iter().map(|c| c.1).max() >= Some(4 * row);
            prop_assert_eq!(first <= row && row <= last, touched);
        }
    }

    proptest! {
        #[test]
        fn quotients_are_rounded_down(
            step in prop_oneof![1i64..100, 1i64..1 << 31, 1i64..1 << 52, 1i64..1 << 60], multiple in any::<i32>(), off in -2i64..3,
            any in any::<i64>(),
        ) {
            let near = step.saturating_mul(i64::from(multiple)).saturating_add(off);
            for numerator in [near, any] {
                prop_assert_eq!(divide(numerator, step), (numerator.div_euclid(step), numerator.rem_euclid(step)));
            }
        }
    }

    #[test]
    fn words_come_back() {
        let t = Triangle::new(7, [(-4, 9), (1 << 40, -8), (3, 1 << 39)], [1.5, f64::NAN, -0.0]).unwrap();
        assert_eq!(Triangle::from_words(&t.words(2)).words(2), t.words(2));
    }
}
