//! Samples without a height.

use super::noise::{Octave, fbm, octaves};
use super::patch::{Patch, quantile};
use crate::base::Window;

/// Smooth-edged blobs without heights.
#[derive(Debug)]
pub(super) struct Gaps {
    waves: Vec<Octave>,
    level: f64,
}

impl Gaps {
    /// Gaps on `share` of the area; `None` where there are none.
    pub(super) fn new(seed: u64, share: f64) -> Option<Gaps> {
        if share == 0.0 {
            return None;
        }
        let waves = octaves(seed, 20, 300.0, 0.66, 4);
        let level = quantile(seed, share, |x, y| fbm(&waves, 0.5, x, y));
        Some(Gaps { waves, level })
    }

    pub(super) fn over(&self, window: Window) -> GapRows {
        GapRows { level: self.level, field: Patch::new(window, |x, y| fbm(&self.waves, 0.5, x, y)) }
    }
}

/// The gaps of one window.
pub(super) struct GapRows {
    level: f64,
    field: Patch,
}

impl GapRows {
    pub(super) fn apply(&mut self, row: usize, heights: &mut [f64]) {
        for (h, &f) in heights.iter_mut().zip(self.field.row(row)) {
            if f < self.level {
                *h = f64::NAN;
            }
        }
    }
}
