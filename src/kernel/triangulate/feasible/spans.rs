//! Scan conversion of triangles, exact.

use std::ops::RangeInclusive;

use crate::base::lattice::{Point, STEPS};

/// Scan conversion: the samples of a closed triangle, as a span of columns for each row.
///
/// Exact although it computes in doubles: where an edge crosses a row, its column is a fraction with a denominator
/// below 2²², so it is an integer or at least 2⁻²² away from one, while the rounding of the computation stays below
/// 2⁻³⁰ (coordinates are below 2²⁰ steps, see [`crate::base::lattice`]). [`NUDGE`] lies between.
pub(crate) struct Spans {
    low: Point,
    mid: Point,
    high: Point,
    /// Columns per step of y along the edge from the lowest to the highest vertex, and along the two others.
    long: f64,
    lower: f64,
    upper: f64,
    mid_is_right: bool,
    rows: RangeInclusive<i32>,
}

const NUDGE: f64 = 1.0 / (1u32 << 25) as f64;
/// From where a row crosses a side to the middle between the last sample outside and the first one inside, about: what is
/// rounded from there is the sample inside.
pub(crate) const INWARD: f64 = 0.5 - NUDGE;
const COLUMN: f64 = 1.0 / STEPS as f64;

/// What leaves no room for a fraction in a sum with a number below 2³¹ in magnitude; the lower half of its bits is the integer.
pub(crate) const NO_FRACTION: f64 = 1.5 * (1u64 << 52) as f64;

/// The nearest integer of a number below 2³¹ in magnitude, never half-way between two. By an addition that leaves no room
/// for a fraction: a conversion that saturates takes several times as long, and there are two to every row.
#[inline(always)]
fn rounded(value: f64) -> i32 {
    (value + NO_FRACTION).to_bits() as i32
}

/// Three places from the lowest row to the highest, without a branch: which way these would go is as good as random.
#[inline(always)]
fn by_row(a: Point, b: Point, c: Point) -> [Point; 3] {
    let [a, b, c] = [packed(a), packed(b), packed(c)];
    let (low, high) = (a.min(b), a.max(b));
    let (low, rest) = (low.min(c), low.max(c));
    [unpacked(low), unpacked(rest.min(high)), unpacked(rest.max(high))]
}

#[inline(always)]
fn packed(p: Point) -> i64 {
    i64::from(p.y) << 32 | i64::from(p.x as u32)
}

#[inline(always)]
fn unpacked(p: i64) -> Point {
    Point { x: p as i32, y: (p >> 32) as i32 }
}

/// Columns per step of y from one place to another.
#[inline(always)]
fn slope(p: Point, q: Point) -> f64 {
    if p.y == q.y { 0.0 } else { f64::from(q.x - p.x) / f64::from(q.y - p.y) * COLUMN }
}

/// A part of a triangle between two of its sides: from the first row to the last, none if that is less.
#[derive(Clone, Copy)]
pub(crate) struct Half {
    pub(crate) first: i32,
    pub(crate) last: i32,
    left: Slant,
    right: Slant,
}

/// A side: its column at y, and how that grows.
#[derive(Clone, Copy)]
pub(crate) struct Slant {
    pub(crate) start: f64,
    pub(crate) slope: f64,
    pub(crate) y: i32,
}

/// A triangle's sides: one from its lowest corner to its highest, and two by way of the one between, `middle` steps down.
pub(crate) struct Sides {
    pub(crate) long: Slant,
    pub(crate) lower: Slant,
    pub(crate) upper: Slant,
    pub(crate) middle: i32,
    pub(crate) long_is_left: bool,
}

impl Slant {
    #[inline(always)]
    fn at(&self, y: i32) -> f64 {
        self.start + self.slope * f64::from(y - self.y)
    }
}

impl Half {
    /// First and last column of the samples in one of the rows; empty if the first is greater.
    #[inline(always)]
    pub(crate) fn columns(&self, row: i32) -> (i32, i32) {
        let y = row * STEPS;
        (rounded(self.left.at(y) + INWARD), rounded(self.right.at(y) - INWARD))
    }
}

impl Spans {
    /// The samples of the triangle with these corners, in any order, not all on a line.
    #[inline(always)]
    pub(crate) fn new(a: Point, b: Point, c: Point) -> Spans {
        let [low, mid, high] = by_row(a, b, c);
        Spans {
            long: slope(low, high),
            lower: slope(low, mid),
            upper: slope(mid, high),
            mid_is_right: crate::base::lattice::orient(low, high, mid) < 0,
            rows: ((low.y + STEPS - 1).div_euclid(STEPS))..=high.y.div_euclid(STEPS),
            low,
            mid,
            high,
        }
    }

    /// Whether no row has more than `samples` samples. `area` is twice the triangle's: its longest row times its height.
    #[inline(always)]
    pub(crate) fn longest_has_at_most(&self, samples: usize, area: i64) -> bool {
        area <= (samples as i64 - 1) * i64::from(STEPS) * i64::from(self.high.y - self.low.y)
    }

    /// The row of the middle vertex, where the spans are longest.
    pub(crate) fn middle_row(&self) -> i32 {
        self.mid.y.div_euclid(STEPS)
    }

    /// The rows that may hold samples of the triangle.
    pub(crate) fn rows(&self) -> RangeInclusive<i32> {
        self.rows.clone()
    }

    /// First and last column of the samples in one of these rows; empty if the first is greater.
    #[inline(always)]
    pub(crate) fn columns(&self, row: i32) -> (i32, i32) {
        let (left, right) = self.crossings(row);
        (rounded(left + INWARD), rounded(right - INWARD))
    }

    /// The triangle above its middle vertex, and from there on down: [`Half::columns`] is [`Spans::columns`] in its rows.
    #[inline(always)]
    pub(crate) fn halves(&self) -> [Half; 2] {
        let (first, last) = (*self.rows.start(), *self.rows.end());
        // The first row that is not above the middle vertex.
        let middle = (self.mid.y + STEPS - 1).div_euclid(STEPS);
        let Sides { long, lower, upper, long_is_left, .. } = self.sides();
        let half = |first: i32, last: i32, short: Slant| {
            let (left, right) = if long_is_left { (long, short) } else { (short, long) };
            Half { first, last, left, right }
        };
        [half(first, last.min(middle - 1), lower), half(first.max(middle), last, upper)]
    }

    /// Its sides.
    #[inline(always)]
    pub(crate) fn sides(&self) -> Sides {
        let long = Slant { start: f64::from(self.low.x) * COLUMN, slope: self.long, y: self.low.y };
        let lower = Slant { slope: self.lower, ..long };
        let upper = Slant { start: f64::from(self.mid.x) * COLUMN, slope: self.upper, y: self.mid.y };
        Sides { long, lower, upper, middle: self.mid.y, long_is_left: self.mid_is_right }
    }

    /// The same for a triangle that may reach beyond columns 0 to `width` − 1: of these columns only.
    pub(crate) fn columns_within(&self, row: i32, width: usize) -> (i32, i32) {
        let (left, right) = self.crossings(row);
        let (first, last) = ((left - NUDGE).ceil(), (right + NUDGE).floor());
        (first.max(0.0) as i32, last.min(width as f64 - 1.0) as i32)
    }

    /// The same for the half-open triangle, so that every sample of a triangulated region belongs to one triangle: its
    /// left and upper sides are its own, its right and lower sides are not. Beyond the last column `right_rim` and below
    /// the last row `lower_rim` there is no triangle to own them, so there they are its own, too.
    #[inline(always)]
    pub(crate) fn own_columns(&self, row: i32, right_rim: i32, lower_rim: i32) -> (i32, i32) {
        const NONE: (i32, i32) = (1, 0);
        let (left, right) = self.crossings(row);
        // At a corner the row only touches the triangle.
        if right - left < NUDGE || row * STEPS == self.high.y && row != lower_rim {
            return NONE;
        }
        let first = rounded(left + INWARD);
        let closed = rounded(right - INWARD);
        let last = if closed == right_rim { closed } else { rounded(right + INWARD) - 1 };
        (first, last)
    }

    /// Where a row enters and leaves the triangle, in columns.
    #[inline(always)]
    fn crossings(&self, row: i32) -> (f64, f64) {
        let y = row * STEPS;
        let long = f64::from(self.low.x) * COLUMN + self.long * f64::from(y - self.low.y);
        let short = if y < self.mid.y {
            f64::from(self.low.x) * COLUMN + self.lower * f64::from(y - self.low.y)
        } else {
            f64::from(self.mid.x) * COLUMN + self.upper * f64::from(y - self.mid.y)
        };
        if self.mid_is_right { (long, short) } else { (short, long) }
    }
}
