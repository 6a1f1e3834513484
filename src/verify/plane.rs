//! The plane of a face at samples, exact.

use super::exact::{agreeing, rounded_error, within, within_interval, within_weighted};
use super::grid::STEPS;
use super::line::Line;
use super::samples::Samples;
use super::triangle::{RowSpan, Triangle};

/// Half the distance from 1 to the next double: the relative error of one rounded operation.
pub(super) const U: f64 = f64::EPSILON / 2.0;

/// The surface over one triangle, ready to be held against samples.
///
/// The weights wb, wc of a sample (twice the areas it spans with the opposite edges) are whole numbers not above D, the
/// weight of the whole triangle, so below 2⁵³ they are exact doubles. The surface is then za + (wb·pb + wc·pc) with
/// pb ≈ (zb − za)/D, pc ≈ (zc − za)/D. With M = max(|zb − za|, |zc − za|) and Z = max |z|, each of the two products is
/// off by at most 3 rounded operations and their sum by one more: 4u·M, since wb + wc ≤ D. Adding za rounds a number
/// not above Z (+ 4u·M), and subtracting from the sample rounds the error itself. So the error found is off by at
/// most 4u·M + u·Z + u·error and second-order terms; twice that is allowed for, and a little for underflow.
///
/// Where errors are weighted, (error ± slack) × weight is held against the tolerance; the sum, the product
/// and the limit are rounded, too, which is allowed for several times over. Tolerances near the smallest numbers go the
/// exact way alone, because products might underflow.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub(super) triangle: Triangle,
    double_area: i128,
    is_small: bool,
    slopes: (f64, f64),
    tolerance: f64,
    slack: f64,
    /// At most this, and the sample is within the tolerance for sure.
    surely_within: f64,
    /// More than this, and it is not for sure.
    surely_above: f64,
}

/// A sample's vertical distance to the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Judged {
    /// The distance, rounded; no more than the limit's own rounding above it where it is `within`.
    pub(super) error: f64,
    /// What is held against the tolerance, the distance or distance × weight: rounded, but at most the tolerance if and
    /// only if `within`.
    pub(super) counted: f64,
    /// The surface's height, rounded.
    pub(super) surface: f64,
    /// Whether what counts is exactly at most the tolerance.
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
        Plane {
            triangle,
            double_area,
            is_small: triangle.is_small(),
            slopes,
            tolerance,
            slack,
            surely_within,
            surely_above,
        }
    }

    /// What errors are held against.
    pub(super) fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// By how much an error that was found by [`Plane::judge_line`] may be off. 0 where the surface is level, and the error
    /// rounded once.
    pub(super) fn slack(&self) -> f64 {
        let [za, zb, zc] = self.triangle.heights;
        if za == zb && za == zc { 0.0 } else { self.slack }
    }

    /// The same judgement with the error rounded correctly: two meshes of one surface, or two programs, find the same number.
    #[cold]
    pub(super) fn refined(&self, column: i64, row: i64, sample: f64, weight: Option<f64>, judged: Judged) -> Judged {
        let error = rounded_error(sample, self.triangle.heights, self.weights(column, row));
        let counted = agreeing(error * weight.unwrap_or(1.0), judged.within, self.tolerance);
        let error = if weight.is_none() { counted } else { error };
        Judged { error, counted, ..judged }
    }

    /// Whether all three corners have a height; a surface without one is within no tolerance of anything.
    pub(super) fn has_heights(&self) -> bool {
        self.triangle.heights.iter().all(|z| z.is_finite())
    }

    /// The surface over the samples of a row.
    pub(super) fn line(&self, row: i64, span: &RowSpan) -> Line {
        let [a, b, c] = self.triangle.corners;
        let first = span.closed.0;
        let weights = match self.is_small {
            true => {
                let (x, y) = (STEPS * first, STEPS * row);
                let turn = |p: (i64, i64), q: (i64, i64)| ((q.0 - p.0) * (y - p.1) - (q.1 - p.1) * (x - p.0)) as f64;
                (turn(c, a), turn(a, b))
            }
            false => {
                let [_, wb, wc] = self.weights(first, row);
                (wb as f64, wc as f64)
            }
        };
        let steps = ((STEPS * (c.1 - a.1)) as f64, (STEPS * (a.1 - b.1)) as f64);
        Line { row, first, height: self.triangle.heights[0], weights, steps, slopes: self.slopes }
    }

    /// Whether samples with errors of at most this are within the tolerance for sure; it is not asked of weighted errors.
    pub(super) fn is_surely_within(&self, error: f64) -> bool {
        error <= self.surely_within
    }

    /// Judges those of these samples of a line, first and last column, that have a height, in order; `samples` is the whole
    /// row.
    #[inline]
    pub(super) fn judge_line(
        &self,
        line: &Line,
        columns: (i64, i64),
        samples: Samples<'_>,
        mut visit: impl FnMut(i64, Judged),
    ) {
        let row = line.row;
        match samples.weights {
            None => line.visit(columns, samples.heights, |column, sample, surface, error| {
                let judged = match samples.interval(column as usize) {
                    None => self.judge(column, row, sample, surface, error),
                    Some(ends) => self.judge_interval(column, row, ends, surface),
                };
                visit(column, judged);
            }),
            Some(weights) => line.visit(columns, samples.heights, |column, sample, surface, error| {
                visit(column, self.judge_weighted(column, row, sample, surface, error, weights[column as usize]));
            }),
        }
    }

    #[inline]
    fn judge(&self, column: i64, row: i64, sample: f64, surface: f64, error: f64) -> Judged {
        if error <= self.surely_within {
            return Judged { error, counted: error, surface, within: true };
        }
        if error > self.surely_above {
            return Judged { error, counted: error, surface, within: false };
        }
        self.judge_exactly(column, row, sample, surface, error)
    }

    fn judge_weighted(&self, column: i64, row: i64, sample: f64, surface: f64, error: f64, weight: f64) -> Judged {
        /// A bound of the roundings of sum and product.
        const ROUNDING: f64 = 32.0 * U;
        const SMALLEST_TOLERANCE: f64 = 1e-200;
        let counted = error * weight;
        let filtered = self.surely_above < f64::INFINITY && self.tolerance >= SMALLEST_TOLERANCE;
        if filtered && (error + self.slack) * weight <= self.tolerance * (1.0 - ROUNDING) {
            return Judged { error, counted, surface, within: true };
        }
        if filtered && (error - self.slack) * weight > self.tolerance * (1.0 + ROUNDING) {
            return Judged { error, counted, surface, within: false };
        }
        let weights = self.weights(column, row);
        let within = within_weighted(sample, self.triangle.heights, weights, weight, self.tolerance);
        let most = if within && weight > 0.0 { self.tolerance / weight } else { f64::INFINITY };
        Judged { error: error.min(most), counted: agreeing(counted, within, self.tolerance), surface, within }
    }

    /// The same of a sample that is an interval: its error is how far the surface is from it.
    fn judge_interval(&self, column: i64, row: i64, [low, high]: [f64; 2], surface: f64) -> Judged {
        let error = (surface - surface.clamp(low, high)).abs();
        let judged = |within| {
            let error = agreeing(error, within, self.tolerance);
            Judged { error, counted: error, surface, within }
        };
        if error <= self.surely_within {
            return judged(true);
        }
        if error > self.surely_above {
            return judged(false);
        }
        judged(within_interval([low, high], self.triangle.heights, self.weights(column, row), self.tolerance))
    }

    #[cold]
    fn judge_exactly(&self, column: i64, row: i64, sample: f64, surface: f64, error: f64) -> Judged {
        let within = within(sample, self.triangle.heights, self.weights(column, row), self.tolerance);
        let error = agreeing(error, within, self.tolerance);
        Judged { error, counted: error, surface, within }
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

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Small and large numbers, so that heights differ by much or by little more than their last bits.
    fn height() -> impl Strategy<Value = f64> {
        let base = prop_oneof![Just(0.0), Just(8000.0), Just(1e9), Just(-1e15)];
        (base, prop_oneof![(-50i32..50).prop_map(f64::from), -50f64..50.0, -1e-9f64..1e-9]).prop_map(|(b, h)| b + h)
    }

    fn plain(heights: &[f64]) -> Samples<'_> {
        Samples { heights, weights: None, intervals: None, flags: None }
    }

    fn judge_row(plane: &Plane, row: i64, span: &RowSpan, samples: Samples<'_>, visit: impl FnMut(i64, Judged)) {
        plane.judge_line(&plane.line(row, span), span.closed, samples, visit);
    }

    proptest! {
        /// Tolerances a few rounding errors beside the error are where a wrong bound would show.
        #[test]
        fn the_filter_never_contradicts_the_exact_answer(
            corners in proptest::array::uniform3((0i64..400, 0i64..80)), heights in [height(), height(), height()],
            lift in prop_oneof![Just(0.0), -10f64..10.0], nudge in -2f64..2.0, row in 0i64..20,
            weight in prop_oneof![Just(0.0), Just(0.3), Just(1.0), Just(2.0), 0f64..1e6],
        ) {
            let Some(triangle) = Triangle::new(0, corners, heights) else { return Ok(()) };
            let Some(span) = triangle.row_span(row, 100) else { return Ok(()) };
            let mut samples = vec![0.0; 100];
            judge_row(&Plane::new(triangle, 0.0), row, &span, plain(&[0.0; 100]), |c, j| samples[c as usize] = j.surface + lift);
            let size = heights.iter().fold(0f64, |m, z| m.max(z.abs()));
            let mut errors = Vec::new();
            judge_row(&Plane::new(triangle, 0.0), row, &span, plain(&samples), |_, j| errors.push(j.error));
            let loose = Plane::new(triangle, 1e300);
            let inside = &samples[span.closed.0 as usize..=span.closed.1 as usize];
            let found = loose.line(row, &span).errors(span.closed.0, inside);
            let (mut largest, mut squares) = (0f64, 0.0);
            judge_row(&loose, row, &span, plain(&samples), |_, j| {
                largest = largest.max(j.error);
                squares += j.error * j.error;
            });
            assert_eq!(found.largest, largest);
            assert!((found.sum_of_squares - squares).abs() <= 1e-13 * squares);
            for error in errors {
                let tolerance = (error + nudge * U * size).max(0.0);
                let plane = Plane::new(triangle, tolerance);
                judge_row(&plane, row, &span, plain(&samples), |column, judged| {
                    let exact = within(samples[column as usize], triangle.heights, plane.weights(column, row), tolerance);
                    assert_eq!(judged.within, exact);
                    assert_eq!(judged.error <= tolerance, exact);
                });
                let plane = Plane::new(triangle, tolerance * weight);
                let weighted = Samples { heights: &samples, weights: Some(&[weight; 100]), intervals: None, flags: None };
                judge_row(&plane, row, &span, weighted, |column, judged| {
                    let (sample, bary) = (samples[column as usize], plane.weights(column, row));
                    let exact = within_weighted(sample, triangle.heights, bary, weight, tolerance * weight);
                    assert_eq!(judged.within, exact);
                    assert_eq!(judged.counted <= tolerance * weight, exact);
                });
            }
        }
    }

    proptest! {
        /// Ends a few rounding errors beside the surface, with tolerances next to nothing, are where a wrong bound would show.
        #[test]
        fn intervals_are_judged_exactly(
            corners in proptest::array::uniform3((0i64..400, 0i64..80)), heights in [height(), height(), height()],
            below in prop_oneof![Just(0.0), -3.0..3.0f64], width in prop_oneof![Just(1e-12), 0.0..9.0f64],
            tolerance in prop_oneof![Just(0.0), Just(1e-13), 0.0..2.0f64], row in 0i64..20,
        ) {
            let Some(triangle) = Triangle::new(0, corners, heights) else { return Ok(()) };
            let Some(span) = triangle.row_span(row, 100) else { return Ok(()) };
            let plane = Plane::new(triangle, tolerance);
            let mut lows = [0.0; 100];
            judge_row(&plane, row, &span, plain(&[0.0; 100]), |column, judged| {
                let offset = if column % 2 == 0 { below - tolerance } else { below + tolerance - width };
                lows[column as usize] = judged.surface + offset;
            });
            let tops = lows.map(|low| low + width);
            let samples = Samples { intervals: Some((&lows, &tops)), ..plain(&lows) };
            judge_row(&plane, row, &span, samples, |column, judged| {
                let ends = [lows[column as usize], tops[column as usize]];
                let exact = within_interval(ends, triangle.heights, plane.weights(column, row), tolerance);
                assert_eq!((judged.within, judged.error <= tolerance), (exact, exact), "{ends:?} {judged:?}");
            });
        }
    }

    #[test]
    fn triangles_beyond_exact_doubles_are_judged_all_the_same() {
        let far = 1 << 30;
        let triangle = Triangle::new(0, [(0, 0), (far, 0), (0, far)], [0.0, f64::from(1 << 28), 0.0]).unwrap();
        let samples: Vec<f64> = (0..8).map(f64::from).collect();
        let span = triangle.row_span(3, 8).unwrap();
        let mut seen = 0;
        judge_row(&Plane::new(triangle, 0.0), 3, &span, plain(&samples), |column, judged| {
            assert_eq!((judged.error, judged.surface, judged.within), (0.0, column as f64, true));
            seen += 1;
        });
        assert_eq!(seen, 8);
    }
}
