//! The surface along an edge, where it crosses rows and columns of samples.

use super::grid::STEPS;
use super::limit::Mean;
use super::plane::U;
use super::walk::begins;

/// An edge, ready to be held against samples.
///
/// As in [`super::plane::Plane`], with M = |z₁ − z₀| and Z = max |z|: a height between the ends is found by three rounded
/// operations and a sum, and the difference from a sample is rounded, so it is off by at most 4u·M + u·Z + u·difference and
/// second-order terms; twice that is allowed for, and a little for underflow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub(super) upper: (i64, i64),
    pub(super) lower: (i64, i64),
    heights: [f64; 2],
    /// What a step along the columns, and one along the rows, adds to the height.
    slopes: (f64, f64),
    /// By how much a height may be off. 0 where the edge is level.
    pub(super) slack: f64,
}

impl Edge {
    /// From one vertex, place and height, to another; `None` if it does not begin at the first ([`begins`]).
    pub(super) fn new((upper, z): ((i64, i64), f64), (lower, end): ((i64, i64), f64)) -> Option<Edge> {
        if !begins(upper, lower) {
            return None;
        }
        let climb = end - z;
        let slopes = (climb / (lower.0 - upper.0) as f64, climb / (lower.1 - upper.1) as f64);
        let slack = match z == end {
            true => 0.0,
            false => 8.0 * U * (climb.abs() + z.abs().max(end.abs())) + 4.0 * f64::MIN_POSITIVE,
        };
        Some(Edge { upper, lower, heights: [z, end], slopes, slack })
    }

    /// A vertex as an edge without a length.
    pub(super) fn of_vertex(place: (i64, i64), height: f64) -> Edge {
        Edge { upper: place, lower: place, heights: [height; 2], slopes: (0.0, 0.0), slack: 0.0 }
    }

    /// Whether both ends have heights.
    pub(super) fn is_finite(&self) -> bool {
        self.heights.iter().all(|z| z.is_finite())
    }

    /// The height where it crosses a row.
    #[inline(always)]
    pub(super) fn at_row(&self, row: i64) -> f64 {
        self.heights[0] + (STEPS * row - self.upper.1) as f64 * self.slopes.1
    }

    /// The height where it crosses a column.
    #[inline(always)]
    pub(super) fn at_column(&self, column: i64) -> f64 {
        self.heights[0] + (STEPS * column - self.upper.0) as f64 * self.slopes.0
    }

    /// The height where it crosses a row, exactly.
    pub(super) fn mean_at_row(&self, row: i64) -> Mean {
        self.mean(STEPS * row - self.upper.1, self.lower.1 - STEPS * row)
    }

    /// The height where it crosses a column, exactly.
    pub(super) fn mean_at_column(&self, column: i64) -> Mean {
        let (from, to) = (STEPS * column - self.upper.0, self.lower.0 - STEPS * column);
        self.mean(from.abs(), to.abs())
    }

    /// The height at its upper end.
    pub(super) fn mean_at_upper(&self) -> Mean {
        self.mean(0, 1)
    }

    /// At a distance from the upper end, and from the lower one.
    fn mean(&self, from: i64, to: i64) -> Mean {
        let [upper, lower] = self.heights;
        Mean { heights: [upper, lower, 0.0], weights: [i128::from(to), i128::from(from), 0] }
    }

    /// Column and row where its height is such a mean, with fractions, rounded.
    pub(super) fn place(&self, mean: &Mean) -> (f64, f64) {
        let [to, from, _] = mean.weights.map(|w| w as f64);
        let between =
            |upper: i64, lower: i64| (upper as f64 + (lower - upper) as f64 * (from / (from + to))) / STEPS as f64;
        (between(self.upper.0, self.lower.0), between(self.upper.1, self.lower.1))
    }
}
