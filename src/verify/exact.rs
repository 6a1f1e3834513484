//! The question whether a sample is within the tolerance, answered without rounding.

use std::cmp::Ordering;

use num_bigint::{BigInt, BigUint};
use num_rational::BigRational;

/// |h − (wa·za + wb·zb + wc·zc)/D| ≤ tolerance, for finite numbers and a positive D = wa + wb + wc of weights that are
/// not negative.
///
/// Doubles are whole multiples of powers of two: multiplied by the common one and by D, all terms are whole numbers.
/// They nearly always fit 128 bits; where they do not, rationals of any size decide.
pub(super) fn within(sample: f64, heights: [f64; 3], weights: [i128; 3], tolerance: f64) -> bool {
    in_128_bits(sample, heights, weights, tolerance)
        .unwrap_or_else(|| in_rationals(sample, heights, weights, tolerance))
}

/// The answer in 128 bits, where the numbers fit.
fn in_128_bits(sample: f64, heights: [f64; 3], weights: [i128; 3], tolerance: f64) -> Option<bool> {
    let [za, zb, zc] = heights;
    let (double_area, [h, za, zb, zc, e], _) = whole_numbers(weights, [sample, za, zb, zc, tolerance])?;
    Some(distance(double_area, h, weights, [za, zb, zc]) <= e.unsigned_abs() * double_area.unsigned_abs())
}

/// D, and numbers as whole multiples of a power of two that they have in common, whose exponent comes last. `None` where the
/// product of one with D may be 2¹²⁵ or more.
fn whole_numbers<const K: usize>(weights: [i128; 3], numbers: [f64; K]) -> Option<(i128, [i128; K], i32)> {
    let double_area: i128 = weights.iter().sum();
    let room = double_area.leading_zeros() as i32 - 3;
    let parts = numbers.map(split);
    let unit = parts.iter().filter(|(m, _)| *m != 0).map(|(_, e)| *e).min().unwrap_or(0);
    let mut whole = [0i128; K];
    for (out, (mantissa, exponent)) in whole.iter_mut().zip(parts).filter(|(_, (m, _))| *m != 0) {
        let bits = (64 - mantissa.unsigned_abs().leading_zeros()) as i32;
        if bits + exponent - unit > room {
            return None;
        }
        *out = i128::from(mantissa) << (exponent - unit);
    }
    Some((double_area, whole, unit))
}

/// |h·D − Σ w·z| of whole numbers. Each product is below 2¹²⁵, and so is the weighted sum, because the weights add up to D.
fn distance(double_area: i128, h: i128, weights: [i128; 3], heights: [i128; 3]) -> u128 {
    let [za, zb, zc] = heights;
    (h * double_area - (weights[0] * za + weights[1] * zb + weights[2] * zc)).unsigned_abs()
}

/// |h − (wa·za + wb·zb + wc·zc)/D| · importance ≤ tolerance: the same question where errors are weighted. The importance
/// is finite and not negative.
pub(super) fn within_weighted(
    sample: f64,
    heights: [f64; 3],
    weights: [i128; 3],
    importance: f64,
    tolerance: f64,
) -> bool {
    weighted_in_128_bits(sample, heights, weights, importance, tolerance)
        .unwrap_or_else(|| weighted_in_rationals(sample, heights, weights, importance, tolerance))
}

/// The answer in 128 bits, where the numbers fit: |h·D − Σ w·z| · importance against tolerance · D, each as a whole number
/// and a power of two.
fn weighted_in_128_bits(
    sample: f64,
    heights: [f64; 3],
    weights: [i128; 3],
    importance: f64,
    tolerance: f64,
) -> Option<bool> {
    let [za, zb, zc] = heights;
    let (double_area, [h, za, zb, zc], unit) = whole_numbers(weights, [sample, za, zb, zc])?;
    let error = distance(double_area, h, weights, [za, zb, zc]);
    let ((importance, importance_exponent), (tolerance, tolerance_exponent)) = (split(importance), split(tolerance));
    let left = error.checked_mul(u128::from(importance.unsigned_abs()))?;
    let right = double_area.unsigned_abs().checked_mul(u128::from(tolerance.unsigned_abs()))?;
    if left == 0 || right == 0 {
        return Some(left == 0);
    }
    let shift = unit + importance_exponent - tolerance_exponent;
    let shifted = |number: u128, by: i32| (by <= number.leading_zeros() as i32).then(|| number << by);
    match shift {
        0.. => Some(shifted(left, shift)? <= right),
        _ => Some(left <= shifted(right, -shift)?),
    }
}

/// How h compares with (wa·za + wb·zb + wc·zc)/D.
pub(super) fn compare(sample: f64, heights: [f64; 3], weights: [i128; 3]) -> Ordering {
    let [za, zb, zc] = heights;
    match whole_numbers(weights, [sample, za, zb, zc]) {
        Some((double_area, [h, za, zb, zc], _)) => {
            (h * double_area).cmp(&(weights[0] * za + weights[1] * zb + weights[2] * zc))
        }
        None => error(sample, heights, weights).cmp(&rational(0.0)),
    }
}

/// A rounded number that is held against a limit, where rounding (or overflow) must not contradict the exact answer.
pub(super) fn agreeing(counted: f64, within: bool, limit: f64) -> f64 {
    match within {
        true => counted.min(limit),
        false if counted > limit => counted,
        false => limit.next_up(),
    }
}

/// |h − (wa·za + wb·zb + wc·zc)/D|, rounded to the nearest double, of two the even one. Errors below 2⁻¹⁰²² may be off by a
/// bit.
pub(super) fn rounded_error(sample: f64, heights: [f64; 3], weights: [i128; 3]) -> f64 {
    rounded_in_128_bits(sample, heights, weights).unwrap_or_else(|| rounded_in_rationals(sample, heights, weights))
}

/// The same in 128 bits, where the numbers fit.
fn rounded_in_128_bits(sample: f64, heights: [f64; 3], weights: [i128; 3]) -> Option<f64> {
    let [za, zb, zc] = heights;
    let (double_area, [h, za, zb, zc], unit) = whole_numbers(weights, [sample, za, zb, zc])?;
    let (numerator, denominator) = (distance(double_area, h, weights, [za, zb, zc]), double_area.unsigned_abs());
    let bits = |number: u128| (128 - number.leading_zeros()) as i32;
    let shift = QUOTIENT_BITS + bits(denominator) - bits(numerator);
    let (numerator, denominator) = match shift {
        // Beyond 128 bits nothing is told.
        0.. if QUOTIENT_BITS + bits(denominator) > 128 => return None,
        0.. if numerator == 0 => return Some(0.0),
        0.. => (numerator << shift, denominator),
        _ => (numerator, denominator << -shift),
    };
    let quotient = (numerator / denominator) as u64;
    Some(rounded(quotient, numerator % denominator != 0, i64::from(unit - shift)))
}

/// A quotient of this number of bits or one more, and a last bit that tells whether something is left, are rounded in one step.
const QUOTIENT_BITS: i32 = 56;

/// (quotient + a rest below 1, if there is one) · 2^exponent.
fn rounded(quotient: u64, has_rest: bool, exponent: i64) -> f64 {
    let scaled = ((quotient << 1) | u64::from(has_rest)) as f64;
    // In two steps, each of them a double.
    let exponent = exponent - 1;
    let half = exponent / 2;
    scaled * 2f64.powi(half as i32) * 2f64.powi((exponent - half) as i32)
}

fn rounded_in_rationals(sample: f64, heights: [f64; 3], weights: [i128; 3]) -> f64 {
    let error = error(sample, heights, weights);
    let (numerator, denominator) = (error.numer().magnitude(), error.denom().magnitude());
    let shift = i64::from(QUOTIENT_BITS) + denominator.bits() as i64 - numerator.bits() as i64;
    let (numerator, denominator) = match shift {
        0.. => (numerator << shift, denominator.clone()),
        _ => (numerator.clone(), denominator << -shift),
    };
    let quotient = u64::try_from(&numerator / &denominator).expect("57 bits");
    rounded(quotient, (numerator % denominator) != BigUint::ZERO, -shift)
}

/// The definition, word by word.
fn weighted_in_rationals(sample: f64, heights: [f64; 3], weights: [i128; 3], importance: f64, tolerance: f64) -> bool {
    let weighted = error(sample, heights, weights) * rational(importance);
    let tolerance = rational(tolerance);
    -&tolerance <= weighted && weighted <= tolerance
}

/// mantissa · 2^exponent, the mantissa odd or 0.
fn split(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let (mantissa, exponent) = if field == 0 { (fraction, -1074) } else { (fraction | 1 << 52, field - 1075) };
    if mantissa == 0 {
        return (0, 0);
    }
    let zeros = mantissa.trailing_zeros();
    let sign = if value < 0.0 { -1 } else { 1 };
    (sign * (mantissa >> zeros), exponent + zeros as i32)
}

/// The definition, word by word.
fn in_rationals(sample: f64, heights: [f64; 3], weights: [i128; 3], tolerance: f64) -> bool {
    let error = error(sample, heights, weights);
    let tolerance = rational(tolerance);
    -&tolerance <= error && error <= tolerance
}

/// low − tolerance ≤ (wa·za + wb·zb + wc·zc)/D ≤ high + tolerance.
pub(super) fn within_interval([low, high]: [f64; 2], heights: [f64; 3], weights: [i128; 3], tolerance: f64) -> bool {
    let [below, above] = [low, high].map(|end| error(end, heights, weights));
    let tolerance = rational(tolerance);
    below <= tolerance && -tolerance <= above
}

/// The number that a finite double is.
pub(super) fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).expect("finite heights, importance and tolerance")
}

/// Sample less surface.
fn error(sample: f64, heights: [f64; 3], weights: [i128; 3]) -> BigRational {
    let weight = |w: i128| BigRational::from_integer(BigInt::from(w));
    let double_area = weight(weights.iter().sum());
    let terms = weights.iter().zip(heights).map(|(&w, z)| weight(w) * rational(z));
    rational(sample) - terms.sum::<BigRational>() / double_area
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Heights as terrains have them, and heights as nobody has them.
    fn height() -> impl Strategy<Value = f64> {
        prop_oneof![
            (-9000i32..9000).prop_map(f64::from),
            (-9000f32..9000.0).prop_map(f64::from),
            -9000f64..9000.0,
            any::<f64>().prop_filter("finite", |v| v.is_finite()),
        ]
    }

    proptest! {
        #[test]
        fn both_ways_agree(
            heights in [height(), height(), height()], weights in any::<[u16; 3]>(), sample in height(), nudge in -2i64..3,
            tie in any::<bool>(),
        ) {
            prop_assume!(weights.iter().any(|&w| w > 0));
            let weights = weights.map(i128::from);
            let total: i128 = weights.iter().sum();
            let surface: f64 = heights.iter().zip(weights).map(|(z, w)| z * (w as f64 / total as f64)).sum();
            let error = (sample - surface).abs();
            prop_assume!(error.is_finite());
            // A tolerance next to the error, or the error of a sample that lies on the surface.
            let tolerance = if tie { 0.0 } else { f64::from_bits(error.to_bits().saturating_add_signed(nudge)) };
            prop_assume!(tolerance.is_finite());
            let sample = if tie { heights[0] } else { sample };
            let heights = if tie { [heights[0]; 3] } else { heights };
            let slow = in_rationals(sample, heights, weights, tolerance);
            prop_assert!(in_128_bits(sample, heights, weights, tolerance).is_none_or(|fast| fast == slow));
            prop_assert!(!tie || slow);
            prop_assert_eq!(compare(sample, heights, weights), super::error(sample, heights, weights).cmp(&rational(0.0)));
            let exact = rounded_in_rationals(sample, heights, weights);
            let is_tiny = exact < f64::MIN_POSITIVE;
            prop_assert!(rounded_in_128_bits(sample, heights, weights).is_none_or(|fast| fast == exact || is_tiny));
            prop_assert_eq!(slow, within_weighted(sample, heights, weights, 1.0, tolerance));
        }

        #[test]
        fn both_ways_agree_with_weights(
            heights in [height(), height(), height()], weights in any::<[u16; 3]>(), sample in height(), nudge in -2i64..3,
            importance in prop_oneof![
                Just(0.0), Just(0.3), Just(2.0), Just(1e6), 0f64..10.0, (0..f64::MAX.to_bits()).prop_map(f64::from_bits),
            ],
        ) {
            prop_assume!(weights.iter().any(|&w| w > 0));
            let weights = weights.map(i128::from);
            let total: i128 = weights.iter().sum();
            let surface: f64 = heights.iter().zip(weights).map(|(z, w)| z * (w as f64 / total as f64)).sum();
            let weighted = (sample - surface).abs() * importance;
            prop_assume!(weighted.is_finite());
            let tolerance = f64::from_bits(weighted.to_bits().saturating_add_signed(nudge));
            prop_assume!(tolerance.is_finite() && tolerance >= 0.0);
            let slow = weighted_in_rationals(sample, heights, weights, importance, tolerance);
            let fast = weighted_in_128_bits(sample, heights, weights, importance, tolerance);
            prop_assert!(fast.is_none_or(|fast| fast == slow));
        }
    }

    #[test]
    fn ties_are_within_and_one_ulp_more_is_not() {
        // The surface at the middle of 0 and 3 is 1.5.
        assert!(within(2.5, [0.0, 3.0, 7.0], [1, 1, 0], 1.0));
        assert!(!within(2.5f64.next_up(), [0.0, 3.0, 7.0], [1, 1, 0], 1.0));
        assert!(!within(2.5, [0.0, 3.0, 7.0], [1, 1, 0], 1f64.next_down()));
        // One third of 1 is no double, so no sample is exactly on this surface.
        assert!(!within(1.0 / 3.0, [1.0, 0.0, 0.0], [1, 1, 1], 0.0));
        assert!(within(1.0, [3.0, 0.0, 0.0], [1, 1, 1], 0.0));
    }

    #[test]
    fn weighted_ties_are_within_and_one_ulp_more_is_not() {
        // An error of 1 at the middle of 0 and 3.
        let judge = |importance, tolerance| {
            let found = within_weighted(2.5, [0.0, 3.0, 7.0], [1, 1, 0], importance, tolerance);
            assert_eq!(found, weighted_in_128_bits(2.5, [0.0, 3.0, 7.0], [1, 1, 0], importance, tolerance).unwrap());
            found
        };
        assert!(judge(0.3, 0.3) && judge(4.0, 4.0) && judge(0.0, 0.0));
        assert!(!judge(0.3f64.next_up(), 0.3) && !judge(4.0, 4f64.next_down()) && !judge(1e-9, 0.0));
    }

    #[test]
    fn numbers_far_apart_go_the_long_way() {
        let (heights, weights) = ([1e300, -1e-300, 0.0], [0, 1, 1]);
        assert_eq!(in_128_bits(0.0, heights, weights, 1e-300), None);
        assert!(within(0.0, heights, weights, 1e-300));
        assert!(!within(0.0, heights, weights, 1e-301));
    }
}
