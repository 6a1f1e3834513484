//! Heights of their own: which ones there are.

use crate::base::exact::MAX_HEIGHT;

/// Heights are multiples of a power of two that is this share of the tolerance or down to half of it: finer ones save nothing, and
/// short numbers keep exact tests quick and files small.
const FINENESS: f64 = 1.0 / 1024.0;
/// At smaller tolerances there are no heights but those of samples.
const LEAST_TOLERANCE: f64 = 1e-30;

/// What heights of their own are multiples of.
#[derive(Debug, Clone, Copy)]
pub(in crate::kernel) struct Quantum(f64);

impl Quantum {
    /// For a tolerance that is a normal number.
    pub(in crate::kernel) fn new(tolerance: f64) -> Quantum {
        // The exponent alone: the largest power of two up to the tolerance.
        let power = f64::from_bits(tolerance.to_bits() & (0x7ff << 52));
        Quantum(power * FINENESS)
    }

    /// For any tolerance: none where heights of their own are of no use.
    pub(in crate::kernel) fn of(tolerance: f64) -> Option<Quantum> {
        (tolerance >= LEAST_TOLERANCE && tolerance.is_finite()).then(|| Quantum::new(tolerance))
    }

    /// The multiple next to a height; none beyond the heights that a surface may have.
    #[inline]
    pub(in crate::kernel) fn round(self, height: f64) -> Option<f64> {
        // What is added makes a zero of either sign the positive one.
        let rounded = (height / self.0).round() * self.0 + 0.0;
        (rounded.abs() <= MAX_HEIGHT).then_some(rounded)
    }
}
