//! What threads know together: the largest of what each has found, so that nobody looks closely at what cannot be larger. As it is the largest of
//! all in the end, it does not depend on who came first.

use std::sync::atomic::{AtomicU64, Ordering};

/// The largest of some numbers that are not negative.
#[derive(Debug, Default)]
pub(super) struct Known(AtomicU64);

impl Known {
    /// One as large was found.
    pub(super) fn so_far(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    /// Notes another one: bits of such numbers are ordered as they are.
    pub(super) fn raise(&self, found: f64) {
        self.0.fetch_max(found.max(0.0).to_bits(), Ordering::Relaxed);
    }
}
