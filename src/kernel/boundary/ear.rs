//! Ears of the ground, and whether one may go.

use std::ops::RangeInclusive;

use super::{Strip, sample};
use crate::base::lattice::{Point, orient};

/// A corner of a loop with its neighbours; all on samples. It is cut off along the line from the one to the other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ear {
    pub(super) before: Point,
    pub(super) tip: Point,
    pub(super) after: Point,
}

/// What samples are to a loop.
pub(super) trait Occupied {
    /// Whether a vertex of a loop, or a point, stands on a sample.
    fn is_occupied(&self, column: i32, row: i32) -> bool;
}

impl Ear {
    /// Twice its area, in square lattice steps; 0 where the tip is on the way from the one neighbour to the other.
    pub(super) fn area(&self) -> i64 {
        orient(self.before, self.tip, self.after)
    }

    /// Whether a sample other than the ear's corners is occupied, or one that would be lost is outside of the strip, or a
    /// cell is; else how many samples with heights would be lost. All samples of the ear are on the ground.
    pub(super) fn samples_lost(&self, strip: &Strip<'_>, occupied: &impl Occupied) -> Option<u64> {
        if self.area() == 0 {
            return Some(0);
        }
        let sides = Sides::new([self.before, self.tip, self.after].map(sample));
        let corners = [self.before, self.tip, self.after].map(sample);
        let mut lost = 0;
        for row in sides.rows() {
            for column in sides.columns(row) {
                let is_corner = corners.contains(&(column, row));
                if !is_corner && occupied.is_occupied(column, row) {
                    return None;
                }
                if orient(self.before, self.after, Point::of_sample(column, row)) != 0 {
                    lost += u64::from(!strip.is_bridged(column, row));
                    if !strip.has(column, row) {
                        return None;
                    }
                }
            }
            if row < *sides.rows().end() && !sides.cells(row).all(|column| strip.has_cell(column, row)) {
                return None;
            }
        }
        Some(lost)
    }
}

/// The sides of a triangle with corners on samples, crossed with rows, in integers.
struct Sides {
    low: (i32, i32),
    mid: (i32, i32),
    high: (i32, i32),
    mid_is_right: bool,
}

impl Sides {
    fn new(mut corners: [(i32, i32); 3]) -> Sides {
        corners.sort_unstable_by_key(|&(column, row)| (row, column));
        let [low, mid, high] = corners;
        let [a, b, c] = corners.map(|(column, row)| Point::of_sample(column, row));
        Sides { low, mid, high, mid_is_right: orient(a, c, b) < 0 }
    }

    fn rows(&self) -> RangeInclusive<i32> {
        self.low.1..=self.high.1
    }

    /// The columns of the samples of a row.
    fn columns(&self, row: i32) -> RangeInclusive<i32> {
        let short = if row < self.mid.1 { (self.low, self.mid) } else { (self.mid, self.high) };
        let (left, right) = self.in_order((self.low, self.high), short);
        ceil(left, row)..=floor(right, row)
    }

    /// The columns of the cells below a row that the triangle's interior meets: all between the outermost places of both
    /// sides, as corners are on rows.
    fn cells(&self, row: i32) -> RangeInclusive<i32> {
        let short = if row < self.mid.1 { (self.low, self.mid) } else { (self.mid, self.high) };
        let (left, right) = self.in_order((self.low, self.high), short);
        let first = floor(left, row).min(floor(left, row + 1));
        let end = ceil(right, row).max(ceil(right, row + 1));
        first..=end - 1
    }

    fn in_order<T>(&self, long: T, short: T) -> (T, T) {
        if self.mid_is_right { (long, short) } else { (short, long) }
    }
}

/// Two places, the upper first.
type Side = ((i32, i32), (i32, i32));

/// Where a side crosses a row, as a fraction with a positive denominator. A level side ends where it begins.
fn crossing((from, to): Side, row: i32) -> (i64, i64) {
    let down = i64::from(to.1 - from.1);
    if down == 0 {
        return (i64::from(from.0), 1);
    }
    (i64::from(from.0) * down + i64::from(to.0 - from.0) * i64::from(row - from.1), down)
}

fn floor(side: Side, row: i32) -> i32 {
    let (numerator, denominator) = crossing(side, row);
    numerator.div_euclid(denominator) as i32
}

fn ceil(side: Side, row: i32) -> i32 {
    let (numerator, denominator) = crossing(side, row);
    -(-numerator).div_euclid(denominator) as i32
}
