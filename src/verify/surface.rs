//! The surfaces of attributes over a face.

use num_bigint::BigInt;
use num_rational::BigRational;

use super::grid::STEPS;
use super::triangle::{RowSpan, Triangle};

/// Half the distance from 1 to the next double: the relative error of one rounded operation.
const U: f64 = f64::EPSILON / 2.0;

/// Heights and channels over one triangle, ready to be held against samples.
///
/// Each value is evaluated as in `Plane`, off by at most 4u·M + u·Z, M its largest rise and Z its largest magnitude, and
/// one rounding of the difference. Scaled and summed, k + 1 terms are off by k + 3 more roundings of E. Twice all of
/// that is allowed for; what lies within it of the tolerance is decided in rationals.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) triangle: Triangle,
    /// Of the corners: heights, then channel by channel.
    values: Vec<[f64; 3]>,
    slopes: Vec<(f64, f64)>,
    double_area: i128,
    surely_within: f64,
    surely_above: f64,
}

/// What the surfaces are held to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Measure<'a> {
    /// Of heights, then of each channel.
    pub(super) scales: &'a [f64],
    pub(super) tolerance: f64,
}

impl Surface {
    /// `values` are those at the triangle's corners in its own order.
    pub(super) fn new(triangle: Triangle, values: Vec<[f64; 3]>, measure: Measure<'_>) -> Surface {
        let double_area = triangle.double_area();
        let area = double_area as f64;
        let tolerance = measure.tolerance;
        let magnitude = |v: &[f64; 3]| v.iter().fold(0.0f64, |m, z| m.max(z.abs()));
        let rise = |v: &[f64; 3]| (v[1] - v[0]).abs().max((v[2] - v[0]).abs());
        let terms = measure.scales.iter().zip(&values);
        let slack: f64 = terms.map(|(s, v)| s * (8.0 * U * (rise(v) + magnitude(v)) + 4.0 * f64::MIN_POSITIVE)).sum();
        let share = 2.0 * U * (values.len() + 4) as f64;
        let filtered = double_area < 1 << 53 && slack.is_finite();
        let (surely_within, surely_above) = match filtered {
            true => ((tolerance - slack) * (1.0 - share), (tolerance + slack) * (1.0 + share)),
            false => (f64::NEG_INFINITY, f64::INFINITY),
        };
        let slopes = values.iter().map(|[a, b, c]| ((b - a) / area, (c - a) / area)).collect();
        Surface { triangle, values, slopes, double_area, surely_within, surely_above }
    }

    /// Whether every value at every corner is a number.
    pub(super) fn is_finite(&self) -> bool {
        self.values.iter().flatten().all(|v| v.is_finite())
    }

    /// Weighted errors at the samples of a span that have a height: column, error, and whether the error is exactly at most the tolerance.
    /// `samples` are the whole row of heights and of each channel.
    pub(super) fn judge_row(
        &self,
        row: i64,
        span: &RowSpan,
        samples: &[&[f64]],
        measure: Measure<'_>,
        mut visit: impl FnMut(i64, f64, bool),
    ) {
        let [a, b, c] = self.triangle.corners;
        let (first, last) = span.closed;
        let [_, wb, wc] = self.weights(first, row);
        let (wb, wc) = (wb as f64, wc as f64);
        let (step_b, step_c) = ((STEPS * (c.1 - a.1)) as f64, (STEPS * (a.1 - b.1)) as f64);
        for column in first..=last {
            if samples[0][column as usize].is_nan() {
                continue;
            }
            let steps = (column - first) as f64;
            let (wb, wc) = (wb + steps * step_b, wc + steps * step_c);
            let mut error = 0.0;
            for (((scale, values), (pb, pc)), samples) in
                measure.scales.iter().zip(&self.values).zip(&self.slopes).zip(samples)
            {
                let surface = values[0] + (wb * pb + wc * pc);
                error += scale * (samples[column as usize] - surface).abs();
            }
            if error <= self.surely_within {
                visit(column, error, true);
            } else if error > self.surely_above {
                visit(column, error, false);
            } else {
                let samples = samples.iter().map(|s| s[column as usize]);
                let within = self.exactly_within(column, row, samples, measure);
                // Rounding must not contradict the exact answer.
                let tolerance = measure.tolerance;
                let error = if within { error.min(tolerance) } else { error.max(tolerance.next_up()) };
                visit(column, error, within);
            }
        }
    }

    /// The definition, word by word.
    #[cold]
    fn exactly_within(&self, column: i64, row: i64, samples: impl Iterator<Item = f64>, measure: Measure<'_>) -> bool {
        let rational = |v: f64| BigRational::from_float(v).expect("finite values, scales and tolerance");
        let whole = |w: i128| BigRational::from_integer(BigInt::from(w));
        let weights = self.weights(column, row);
        let mut error = whole(0);
        for ((scale, values), sample) in measure.scales.iter().zip(&self.values).zip(samples) {
            let surface: BigRational = weights.iter().zip(values).map(|(&w, &v)| whole(w) * rational(v)).sum();
            let off = rational(sample) - surface / whole(self.double_area);
            let off = if off < whole(0) { -off } else { off };
            error += rational(*scale) * off;
        }
        error <= rational(measure.tolerance)
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
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Tolerances beside the error by a few of its last bits are where a wrong bound would show.
        #[test]
        fn the_filter_never_contradicts_the_definition(
            corners in proptest::array::uniform3((0i64..200, 0i64..80)), row in 0i64..20,
            values in proptest::array::uniform3(proptest::array::uniform3(-300.0f64..300.0)),
            scales in proptest::array::uniform3(prop_oneof![Just(0.0), 0.0f64..2.0]), nudge in -4i64..5,
        ) {
            let Some(triangle) = Triangle::new(0, corners, [0.0; 3]) else { return Ok(()) };
            let Some(span) = triangle.row_span(row, 50) else { return Ok(()) };
            let flat = [7.0; 50];
            let samples = [&flat[..]; 3];
            let surface = |measure| Surface::new(triangle, values.to_vec(), measure);
            let loose = Measure { scales: &scales, tolerance: 0.0 };
            let mut errors = Vec::new();
            surface(loose).judge_row(row, &span, &samples, loose, |column, error, _| errors.push((column, error)));
            for (at, error) in errors {
                let tolerance = f64::from_bits(error.to_bits().saturating_add_signed(nudge));
                let measure = Measure { scales: &scales, tolerance };
                let surface = surface(measure);
                surface.judge_row(row, &span, &samples, measure, |column, error, within| {
                    if column == at {
                        let exact = surface.exactly_within(column, row, [7.0; 3].into_iter(), measure);
                        assert_eq!((within, error <= tolerance), (exact, exact));
                    }
                });
            }
        }
    }
}
