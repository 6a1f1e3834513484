//! The question whether a sample is within the tolerance, answered without rounding.

use num_bigint::BigInt;
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
    let double_area: i128 = weights.iter().sum();
    let room = double_area.leading_zeros() as i32 - 3;
    let parts = [sample, heights[0], heights[1], heights[2], tolerance].map(split);
    let unit = parts.iter().filter(|(m, _)| *m != 0).map(|(_, e)| *e).min().unwrap_or(0);
    let mut whole = [0i128; 5];
    for (out, (mantissa, exponent)) in whole.iter_mut().zip(parts).filter(|(_, (m, _))| *m != 0) {
        let bits = (64 - mantissa.unsigned_abs().leading_zeros()) as i32;
        if bits + exponent - unit > room {
            return None;
        }
        *out = i128::from(mantissa) << (exponent - unit);
    }
    // Each product is below 2¹²⁵, and so is the weighted sum, because the weights add up to D.
    let [h, za, zb, zc, e] = whole;
    let surface = weights[0] * za + weights[1] * zb + weights[2] * zc;
    Some((h * double_area - surface).abs() <= e * double_area)
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
    let rational = |v: f64| BigRational::from_float(v).expect("finite heights and tolerance");
    let weight = |w: i128| BigRational::from_integer(BigInt::from(w));
    let double_area = weight(weights.iter().sum());
    let terms = weights.iter().zip(heights).map(|(&w, z)| weight(w) * rational(z));
    let surface = terms.sum::<BigRational>() / double_area;
    let error = rational(sample) - surface;
    let tolerance = rational(tolerance);
    -&tolerance <= error && error <= tolerance
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
    fn numbers_far_apart_go_the_long_way() {
        let (heights, weights) = ([1e300, -1e-300, 0.0], [0, 1, 1]);
        assert_eq!(in_128_bits(0.0, heights, weights, 1e-300), None);
        assert!(within(0.0, heights, weights, 1e-300));
        assert!(!within(0.0, heights, weights, 1e-301));
    }
}
