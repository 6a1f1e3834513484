//! Four rows of a triangle side by side: which samples they have, and the plane at the first one of each.
//!
//! The same sums and products as [`Spans::columns`], in the same order, so the columns are the same, and as exact.

use super::lanes::{FOUR, Lanes};
use crate::base::lattice::{Point, STEPS};
use crate::kernel::triangulate::feasible::{INWARD, NO_FRACTION, Slant, Spans};

/// A number that is linear in the place: `across` and `down` per lattice step, `start` at `origin`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    pub(super) origin: Point,
    pub(super) across: f64,
    pub(super) down: f64,
    pub(super) start: f64,
}

/// Four rows: first and last column, empty if the first is greater, and a number at the first one.
pub(super) struct FourRows {
    pub(super) first: [i32; FOUR],
    pub(super) last: [i32; FOUR],
    pub(super) start: [f32; FOUR],
}

/// A triangle whose rows are asked for.
pub(super) struct RowFinder<D> {
    long: FourSides<D>,
    lower: FourSides<D>,
    upper: FourSides<D>,
    middle: D,
    long_is_left: bool,
    /// Brings where the long side and the other one are crossed inside.
    long_inward: D,
    short_inward: D,
    /// From the first of four rows to each of them, in steps.
    below: D,
    origin: [D; 2],
    across: D,
    down: D,
    start: D,
}

struct FourSides<D> {
    start: D,
    slope: D,
    /// Less where it begins.
    above: D,
}

impl<D: Copy> FourSides<D> {
    #[inline(always)]
    fn new<L: Lanes<Four = D>>(Slant { start, slope, y }: Slant, on: L) -> Self {
        FourSides { start: on.all_doubles(start), slope: on.all_doubles(slope), above: on.all_doubles(-f64::from(y)) }
    }

    #[inline(always)]
    fn at<L: Lanes<Four = D>>(&self, y: D, on: L) -> D {
        on.add_doubles(self.start, on.mul_doubles(self.slope, on.add_doubles(y, self.above)))
    }
}

impl<D: Copy> RowFinder<D> {
    /// Every `stride`th row of a triangle.
    #[inline(always)]
    pub(super) fn new<L: Lanes<Four = D>>(spans: &Spans, number: Slope, stride: i32, on: L) -> Self {
        let sides = spans.sides();
        let inward = if sides.long_is_left { INWARD } else { -INWARD };
        let next = f64::from(stride * STEPS);
        let Slope { origin, across, down, start } = number;
        RowFinder {
            long: FourSides::new(sides.long, on),
            lower: FourSides::new(sides.lower, on),
            upper: FourSides::new(sides.upper, on),
            middle: on.all_doubles(f64::from(sides.middle)),
            long_is_left: sides.long_is_left,
            long_inward: on.all_doubles(inward),
            short_inward: on.all_doubles(-inward),
            below: on.doubles([0.0, next, 2.0 * next, 3.0 * next]),
            origin: [origin.x, origin.y].map(|at| on.all_doubles(-f64::from(at))),
            across: on.all_doubles(across),
            down: on.all_doubles(down),
            start: on.all_doubles(start),
        }
    }

    /// The row and the three that follow. (Those beyond the triangle's last one are of no use.)
    #[inline(always)]
    pub(super) fn rows_from<L: Lanes<Four = D>>(&self, row: i32, on: L) -> FourRows {
        let (no_fraction, fraction) = (on.all_doubles(NO_FRACTION), on.all_doubles(-NO_FRACTION));
        let y = on.add_doubles(on.all_doubles(f64::from(row * STEPS)), self.below);
        let long = on.add_doubles(self.long.at(y, on), self.long_inward);
        let short = on.if_less(y, self.middle, self.lower.at(y, on), self.upper.at(y, on));
        let short = on.add_doubles(short, self.short_inward);
        let (left, right) = if self.long_is_left { (long, short) } else { (short, long) };
        let (left, right) = (on.add_doubles(left, no_fraction), on.add_doubles(right, no_fraction));
        let column = on.add_doubles(left, fraction);
        let x = on.add_doubles(on.mul_doubles(column, on.all_doubles(f64::from(STEPS))), self.origin[0]);
        let y = on.add_doubles(y, self.origin[1]);
        let sum = on.add_doubles(on.mul_doubles(self.across, x), on.mul_doubles(self.down, y));
        let start = on.of_doubles(on.add_doubles(sum, self.start));
        FourRows {
            first: on.of_doubles(left).map(|column| column.to_bits() as i32),
            last: on.of_doubles(right).map(|column| column.to_bits() as i32),
            start: start.map(|start| start as f32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::orient;
    use crate::kernel::polish::lanes::{Array, Kernel, run};

    /// All rows that are asked for, as first and last column and the bits of the number there.
    struct All<'a> {
        spans: &'a Spans,
        slope: Slope,
        stride: i32,
    }

    impl Kernel for All<'_> {
        type Output = Vec<(i32, i32, i32, u32)>;

        #[inline(always)]
        fn run<L: Lanes>(self, on: L) -> Self::Output {
            let finder = RowFinder::new(self.spans, self.slope, self.stride, on);
            let (mut row, end) = (*self.spans.rows().start(), *self.spans.rows().end());
            let mut found = Vec::new();
            while row <= end {
                let FourRows { first, last, start } = finder.rows_from(row, on);
                for i in 0..FOUR {
                    if row <= end {
                        found.push((row, first[i], last[i], start[i].to_bits()));
                    }
                    row += self.stride;
                }
            }
            found
        }
    }

    /// The spans themselves, row by row, are the oracle: for triangles on samples and between them, level sides and slivers among
    /// them.
    #[test]
    fn rows_are_those_of_the_spans() {
        let mut state = 1u64;
        let mut next = |below: i32| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) % below as u64) as i32
        };
        let mut seen = [0; 2];
        for case in 0..4000 {
            let (size, grain) = ([4, 30, 200, 3000][case % 4], if case % 3 == 0 { 1 } else { STEPS });
            let mut corner = || Point { x: next(size) * grain, y: next(size) * grain };
            let [a, b, c] = [corner(), corner(), corner()];
            if orient(a, b, c) == 0 {
                continue;
            }
            let (spans, stride) = (Spans::new(a, b, c), 1 << (case % 5 / 2));
            let slope = Slope { origin: b, across: 0.3 - case as f64, down: 1.0 / (case + 1) as f64, start: 7.1 };
            let expected: Vec<_> = spans
                .rows()
                .step_by(stride as usize)
                .map(|row| {
                    let (first, last) = spans.columns(row);
                    let [x, y] = [first * STEPS - b.x, row * STEPS - b.y].map(f64::from);
                    let start = (slope.across * x + slope.down * y + slope.start) as f32;
                    (row, first, last, start.to_bits())
                })
                .collect();
            let all = || All { spans: &spans, slope, stride };
            assert_eq!(run(all()), expected, "{a:?} {b:?} {c:?}");
            assert_eq!(all().run(Array), expected, "{a:?} {b:?} {c:?}");
            seen[0] += expected.len();
            seen[1] += expected.iter().filter(|row| row.1 > row.2).count();
        }
        assert!(seen[0] > 10_000 && seen[1] > 100, "{seen:?} rows, and empty ones");
    }
}
