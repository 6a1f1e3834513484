//! Fault lines: vertical steps.

use super::noise::{Octave, fbm, octaves, smoothstep};
use super::options::TerrainOptions;
use super::patch::Patch;
use crate::base::Window;

/// Fault lines: one side is lifted, the other let down, and the step between two samples is vertical.
///
/// Faults run along the zeros of one field; another says how far they throw, so that they begin and end.
#[derive(Debug)]
pub(super) struct Faults {
    line: Vec<Octave>,
    throw: Vec<Octave>,
    throw_m: f64,
}

/// Where the ground is at rest again, in units of the line field.
const REACH: f64 = 0.4;

impl Faults {
    pub(super) fn new(options: &TerrainOptions) -> Option<Faults> {
        options.cliffs.then(|| Faults {
            line: octaves(options.seed, 21, 800.0, 0.6, 4),
            throw: octaves(options.seed, 22, 600.0, 0.6, 2),
            throw_m: 0.05 * options.relief_m,
        })
    }

    pub(super) fn over(&self, window: Window) -> FaultRows {
        FaultRows {
            line: Patch::new(window, |x, y| fbm(&self.line, 0.4, x, y)),
            throw: Patch::new(window, |x, y| self.throw_m * smoothstep(-0.2, 0.5, fbm(&self.throw, 0.5, x, y))),
        }
    }
}

/// The faults of one window.
pub(super) struct FaultRows {
    line: Patch,
    throw: Patch,
}

impl FaultRows {
    pub(super) fn apply(&mut self, row: usize, heights: &mut [f64]) {
        let (line, throw) = (self.line.row(row), self.throw.row(row));
        for ((h, &f), &throw) in heights.iter_mut().zip(line).zip(throw) {
            let near = (1.0 - f.abs() / REACH).max(0.0);
            let step = throw * near * near;
            *h += if f < 0.0 { -step } else { step };
        }
    }
}
