use super::exact::within;
use super::grid::STEPS;
use super::triangle::{RowSpan, Triangle};

/// Half the distance from 1 to the next double: the relative error of one rounded operation.
const U: f64 = f64::EPSILON / 2.0;

/// The surface over one triangle, ready to be held against samples.
///
/// The weights wb, wc of a sample (twice the areas it spans with the opposite edges) are whole numbers not above D, the
/// weight of the whole triangle, so below 2⁵³ they are exact doubles. The surface is then za + (wb·pb + wc·pc) with
/// pb ≈ (zb − za)/D, pc ≈ (zc − za)/D. With M = max(|zb − za|, |zc − za|) and Z = max |z|, each of the two products is
/// off by at most 3 rounded operations and their sum by one more: 4u·M, since wb + wc ≤ D. Adding za rounds a number
/// not above Z (+ 4u·M), and subtracting from the sample rounds the error itself. So the error found is off by at
/// most 4u·M + u·Z + u·error and second-order terms; twice that is allowed for, and a little for underflow.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub(super) triangle: Triangle,
    double_area: i128,
    slopes: (f64, f64),
    tolerance: f64,
    /// At most this, and the sample is within the tolerance for sure.
    surely_within: f64,
    /// More than this, and it is not for sure.
    surely_above: f64,
}

/// A sample's vertical distance to the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Judged {
    /// The distance, rounded, but at most the tolerance if and only if `within`.
    pub(super) error: f64,
    /// The surface's height, rounded.
    pub(super) surface: f64,
    /// Whether the distance is exactly at most the tolerance.
    pub(super) within: bool,
}

impl Plane {
    pub(super) fn new(triangle: Triangle, tolerance: f64) -> Plane {
        let double_area = triangle.double_area();
        let [za, zb, zc] = triangle.heights;
        let (rise_b, rise_c) = (zb - za, zc - za);
        let area = double_area as f64;
        let slack =
            8.0 * U * (rise_b.abs().max(rise_c.abs()) + za.abs().max(zb.abs()).max(zc.abs())) + 4.0 * f64::MIN_POSITIVE;
        let filtered = double_area < 1 << 53 && slack.is_finite();
        let (surely_within, surely_above) = match filtered {
            true => ((tolerance - slack) * (1.0 - 4.0 * U), (tolerance + slack) * (1.0 + 4.0 * U)),
            false => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let slopes = (rise_b / area, rise_c / area);
        Plane { triangle, double_area, slopes, tolerance, surely_within, surely_above }
    }

    /// Whether all three corners have a height; a surface without one is within no tolerance of anything.
    pub(super) fn has_heights(&self) -> bool {
        self.triangle.heights.iter().all(|z| z.is_finite())
    }

    /// Judges the samples of a span in order; `samples` is the whole row.
    pub(super) fn judge_row(&self, row: i64, span: &RowSpan, samples: &[f64], mut visit: impl FnMut(i64, Judged)) {
        let [a, b, c] = self.triangle.corners;
        let (first, last) = span.closed;
        let [_, wb, wc] = self.weights(first, row);
        let (wb, wc) = (wb as f64, wc as f64);
        let (step_b, step_c) = ((STEPS * (c.1 - a.1)) as f64, (STEPS * (a.1 - b.1)) as f64);
        let za = self.triangle.heights[0];
        for column in first..=last {
            let steps = (column - first) as f64;
            let surface = za + ((wb + steps * step_b) * self.slopes.0 + (wc + steps * step_c) * self.slopes.1);
            let sample = samples[column as usize];
            let error = (sample - surface).abs();
            let judged = if error <= self.surely_within {
                Judged { error, surface, within: true }
            } else if error > self.surely_above {
                Judged { error, surface, within: false }
            } else {
                self.judge_exactly(column, row, sample, surface, error)
            };
            visit(column, judged);
        }
    }

    #[cold]
    fn judge_exactly(&self, column: i64, row: i64, sample: f64, surface: f64, error: f64) -> Judged {
        let within = within(sample, self.triangle.heights, self.weights(column, row), self.tolerance);
        // Rounding (or, with numbers near the largest, overflow) must not contradict the exact answer.
        let error = match within {
            true => error.min(self.tolerance),
            false if error > self.tolerance => error,
            false => self.tolerance.next_up(),
        };
        Judged { error, surface, within }
    }

    /// wa, wb, wc of a sample.
    fn weights(&self, column: i64, row: i64) -> [i128; 3] {
        let (x, y) = (STEPS * column, STEPS * row);
        let [a, b, c] = self.triangle.corners;
        let turn = |p: (i64, i64), q: (i64, i64)| {
            i128::from(q.0 - p.0) * i128::from(y - p.1) - i128::from(q.1 - p.1) * i128::from(x - p.0)
        };
        let (wb, wc) = (turn(c, a), turn(a, b));
        [self.double_area - wb - wc, wb, wc]
    }
}
