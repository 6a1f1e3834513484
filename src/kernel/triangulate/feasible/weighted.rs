//! The rows of a triangle where every sample has a weight, and so a limit of its own.
//!
//! The limit of a sample is the largest double t with t · weight ≤ ε ([`exact::limit`]). The fast path does without it,
//! and without a division: the error found, plus a bound of its rounding, times the weight, is held against a tolerance
//! that is a little smaller. What that leaves open is compared with the limit, exactly.

use super::tester::{LANES, Real, Rows, Scan, coarse};
use crate::base::exact;
use crate::base::lattice::{Point, STEPS};

/// What |error| × weight is compared with.
#[derive(Clone, Copy)]
struct Limits {
    reference: f64,
    step: f64,
    /// A bound of an error's rounding, but for what grows with the error itself.
    slack: f64,
    /// (error + slack) × weight up to this is within the tolerance beyond doubt.
    ///
    /// With d = [`Real::DOUBT`]: the true error is at most (error + slack)(1 + d/2); the sum, the product and this limit
    /// are rounded, and the sample's limit is less than the quotient by a share of 2⁻⁵² = d/16 at the most. 2d is more
    /// than all of that.
    sure: f64,
    /// An error up to this is none, whatever the weight: 0 with a flat plane, whose comparison does not round; else
    /// nothing is.
    none: f64,
}

/// Tolerances smaller than this, 0 among them, have no fast path but for errors of 0: products of tiny numbers would
/// underflow, and limits be no normal numbers. (Weights are at most 10³⁰.)
const SMALLEST_TOLERANCE: f64 = 1e-200;

/// The rows of a triangle, every sample held to its limit.
pub(super) struct WeightedRows<'a> {
    scan: &'a Scan,
    heights: &'a [f64],
    weights: &'a [f64],
    limits: Limits,
}

impl<'a> WeightedRows<'a> {
    #[inline(always)]
    pub(super) fn new(scan: &'a Scan, heights: &'a [f64], weights: &'a [f64], height_of_a: f64) -> Self {
        let reach = scan.plane.reach(height_of_a);
        let fast = scan.tolerance >= SMALLEST_TOLERANCE;
        let limits = Limits {
            reference: height_of_a,
            step: scan.plane.step(),
            slack: f64::DOUBT * reach + coarse::<f64>(reach),
            sure: if fast { scan.tolerance * (1.0 - 2.0 * f64::DOUBT) } else { -1.0 },
            none: if reach > 0.0 { -1.0 } else { 0.0 },
        };
        WeightedRows { scan, heights, weights, limits }
    }
}

impl Rows for WeightedRows<'_> {
    #[inline(always)]
    fn scan(&self) -> &Scan {
        self.scan
    }

    #[inline(always)]
    fn within(&self, row: i32) -> bool {
        let Some((at, index, count)) = self.scan.samples(row) else { return true };
        let start = self.scan.plane.above_a(at);
        let (heights, weights) = (&self.heights[index..], &self.weights[index..]);
        surely_within(heights, weights, count, start, self.limits)
            || self.scan.weighted_row_in_doubt(&heights[..count], &weights[..count], at, start, self.limits)
    }
}

impl Scan {
    /// Sample by sample, exactly where rounding leaves it open.
    #[cold]
    #[inline(never)]
    fn weighted_row_in_doubt(
        &self,
        heights: &[f64],
        weights: &[f64],
        first: Point,
        start: f64,
        limits: Limits,
    ) -> bool {
        let mut at = first;
        let mut index = 0.0;
        for (&height, &weight) in heights.iter().zip(weights) {
            let error = ((height - limits.reference) - (start + limits.step * index)).abs();
            let limit = exact::limit(weight, self.tolerance);
            let doubt = f64::DOUBT * limit + limits.slack;
            // An error that is no number is no doubt either: it is never within.
            let within = error <= limit - doubt || error <= limit + doubt && self.plane.within(at, height, limit);
            if !within {
                self.violation.set(Some(at));
                return false;
            }
            at.x += STEPS;
            index += 1.0;
        }
        true
    }
}

/// The fast path: whether the first `count` samples are within their limits beyond doubt. As for rows without weights,
/// lanes are always whole, and those past the end do not count.
#[inline(always)]
fn surely_within(heights: &[f64], weights: &[f64], count: usize, start: f64, limits: Limits) -> bool {
    let end = f64::from(count as i32);
    let mut base = 0.0;
    let mut first = 0;
    while first < count {
        let lane = heights[first..first + LANES].iter().zip(&weights[first..first + LANES]);
        let mut within = true;
        for ((&height, &weight), i) in lane.zip(f64::INDEX) {
            let index = base + i;
            let error = ((height - limits.reference) - (start + limits.step * index)).abs();
            let weighted = (error + limits.slack) * weight;
            within &= (weighted <= limits.sure) | (error <= limits.none) | (index >= end);
        }
        if !within {
            return false;
        }
        base += LANES as f64;
        first += LANES;
    }
    true
}
