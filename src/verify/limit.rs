//! How far a surface may stray beyond the heights of the samples around it.

use std::cmp::Ordering;

use super::VerifyError;
use super::exact::{self, agreeing};

/// A limit on straying: distance beyond the range × weight is to be at most a multiple of the tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StrayLimit {
    /// The multiple, 1 or more.
    pub(super) factor: f64,
    /// What it is a multiple of.
    pub(super) tolerance: f64,
    /// The smallest double that is their product or more; infinite where none is.
    pub(super) most: f64,
}

/// A height of the surface between samples, exactly: the mean of heights by whole weights, none of them negative. Where it is
/// of one height or two, the rest weigh 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mean {
    pub(super) heights: [f64; 3],
    pub(super) weights: [i128; 3],
}

/// How far the surface is beyond a range of heights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beyond {
    /// The distance, rounded correctly; but where errors are not weighted, at most the limit if and only if `within`.
    pub(super) by: f64,
    /// Distance × weight, rounded, but at most the limit if and only if `within`.
    pub(super) counted: f64,
    /// Whether distance × weight is exactly at most the limit.
    pub(super) within: bool,
}

impl StrayLimit {
    /// Of a multiple that is asked for; `None` where none is.
    pub(super) fn new(factor: Option<f64>, tolerance: f64) -> Result<Option<StrayLimit>, VerifyError> {
        match factor {
            Some(factor) if !(factor.is_finite() && factor >= 1.0) => Err(VerifyError::Stray { found: factor }),
            _ => Ok(factor.map(|factor| StrayLimit { factor, tolerance, most: product_up(factor, tolerance) })),
        }
    }

    /// How far a height is beyond the range from the first of two heights to the second, exactly; `None` where it is within.
    pub(super) fn judge(&self, surface: &Mean, range: [f64; 2], weight: Option<f64>) -> Option<Beyond> {
        let Mean { heights, weights } = *surface;
        let [low, high] = range;
        let end = if exact::compare(high, heights, weights) == Ordering::Less {
            high
        } else if exact::compare(low, heights, weights) == Ordering::Greater {
            low
        } else {
            return None;
        };
        let distance = exact::rounded_error(end, heights, weights);
        let within = match weight {
            _ if self.most == f64::INFINITY => true,
            // A rounded distance is on the limit's side that the distance is on, or at the limit.
            None if distance != self.most => distance < self.most,
            None => exact::within(end, heights, weights, self.most),
            Some(weight) => exact::within_weighted(end, heights, weights, weight, self.most),
        };
        let counted = agreeing(distance * weight.unwrap_or(1.0), within, self.most);
        let by = if weight.is_none() { counted } else { distance };
        Some(Beyond { by, counted, within })
    }
}

/// The smallest double that is at least the product of two finite numbers, none of them negative; infinite where none is.
fn product_up(a: f64, b: f64) -> f64 {
    let product = a * b;
    let is_below = product.is_finite() && exact::rational(product) < exact::rational(a) * exact::rational(b);
    if is_below { product.next_up() } else { product }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn limit(factor: f64, tolerance: f64) -> StrayLimit {
        StrayLimit::new(Some(factor), tolerance).unwrap().unwrap()
    }

    #[test]
    fn products_are_rounded_up() {
        let least = f64::from_bits(1);
        assert_eq!(product_up(1.5, 20.0), 30.0);
        // 3 × 0.1 as doubles is above 0.30000000000000004 less a bit.
        assert!(product_up(3.0, 0.1) >= 3.0 * 0.1);
        assert_eq!(product_up(1.0 + f64::EPSILON, least), 2.0 * least);
        assert_eq!(product_up(1.0, 0.0), 0.0);
        assert_eq!(product_up(2.0, f64::MAX), f64::INFINITY);
        assert_eq!(product_up(1.0, f64::MAX), f64::MAX);
    }

    proptest! {
        #[test]
        fn a_product_is_the_least_double_that_is_enough(a in 1f64..50.0, b in prop_oneof![0f64..100.0, 0f64..1e-300, 0f64..1e-310]) {
            let exactly = exact::rational(a) * exact::rational(b);
            let up = product_up(a, b);
            prop_assert!(exact::rational(up) >= exactly);
            prop_assert!(up == 0.0 || exact::rational(up.next_down()) < exactly);
        }
    }

    #[test]
    fn factors_below_one_are_refused() {
        for factor in [0.0, -1.0, 1f64.next_down(), f64::NAN, f64::INFINITY] {
            assert!(matches!(StrayLimit::new(Some(factor), 1.0), Err(VerifyError::Stray { .. })), "{factor}");
        }
        assert_eq!(StrayLimit::new(None, 1.0).unwrap(), None);
    }

    #[test]
    fn ties_are_within_and_one_ulp_more_is_not() {
        // The surface at a third of the way from 3 to 9 is 5.
        let surface = Mean { heights: [3.0, 9.0, 0.0], weights: [2, 1, 0] };
        let judge = |range, limit: StrayLimit, weight| limit.judge(&surface, range, weight);
        assert_eq!(judge([5.0, 6.0], limit(1.0, 0.0), None), None);
        assert_eq!(judge([4.0, 5.0], limit(1.0, 0.0), None), None);
        let beyond = |by, counted, within| Some(Beyond { by, counted, within });
        assert_eq!(judge([0.0, 3.5], limit(1.5, 1.0), None), beyond(1.5, 1.5, true));
        assert_eq!(judge([6.5, 7.0], limit(1.5, 1.0), None), beyond(1.5, 1.5, true));
        let less = judge([0.0, 3.5f64.next_down()], limit(1.5, 1.0), None).unwrap();
        assert!(!less.within && less.by > 1.5);
        assert_eq!(judge([0.0, 3.5], limit(1.0, 0.3), Some(0.2)), beyond(1.5, 0.2 * 1.5, 0.2 * 1.5 <= 0.3));
        assert_eq!(judge([0.0, 3.5], limit(1.0, 0.0), Some(0.0)), beyond(1.5, 0.0, true));
        assert_eq!(judge([0.0, 3.5], limit(4.0, f64::MAX), None), beyond(1.5, 1.5, true));
        // 10/3 is no double: it is beyond both of its neighbours.
        let third = Mean { heights: [0.0, 10.0, 0.0], weights: [2, 1, 0] };
        let near = 10.0 / 3.0;
        let judged = limit(1.0, 0.0).judge(&third, [near, near], None).unwrap();
        assert!(!judged.within && judged.by > 0.0 && judged.by < 1e-15);
    }
}
