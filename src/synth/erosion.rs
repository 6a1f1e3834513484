//! Gullies: what running water cuts into the large forms.
//!
//! Stripes that run down the slope, in octaves, each steered by the slope that the octaves before it have made, so
//! that small gullies branch off the flanks of larger ones. The idea is Clay John's and Rune Skovbo Johansen's
//! (procedural erosion filters, 2018–2024): every lattice cell holds one plane wave across the slope, and
//! neighbouring waves are blended by weights that end with the cell's neighbourhood.

use super::hash::{hash, high, key, low};
use super::noise::floor;

#[derive(Debug)]
pub(super) struct Gullies {
    octaves: Vec<Stripes>,
    /// The slope, in metres per sample, at which gullies reach half their depth.
    gentle: f64,
}

/// One octave.
#[derive(Debug, Clone, Copy)]
struct Stripes {
    key: u64,
    /// Cell edge in samples.
    cell: f64,
    cos: f64,
    sin: f64,
}

/// Waves in one cell.
const WAVES: f64 = 1.25;

impl Gullies {
    pub(super) fn new(seed: u64, relief_m: f64) -> Gullies {
        let (mut cos, mut sin) = (0.8, 0.6);
        let octaves = [72.0, 40.0, 23.0, 13.0].into_iter().enumerate().map(|(i, cell)| {
            // Turned by the angle of the 5-12-13 triangle, whose multiples avoid right angles for long.
            (cos, sin) = ((12.0 * cos - 5.0 * sin) / 13.0, (12.0 * sin + 5.0 * cos) / 13.0);
            Stripes { key: key(seed, 9000 + i as u64), cell, cos, sin }
        });
        Gullies { octaves: octaves.collect(), gentle: 0.0005 * relief_m }
    }

    /// What the gullies add to the height at a place, in metres, and how strong shorter waves would be.
    ///
    /// `slope` is the gradient of the large forms in metres per sample, `depth` the depth of the largest gullies per
    /// sample of their width, in metres, and `gain` how much deeper or shallower, in that proportion, each octave is
    /// than the one before.
    pub(super) fn at(&self, x: f64, y: f64, slope: (f64, f64), depth: f64, gain: f64) -> (f64, f64) {
        let (mut gx, mut gy) = slope;
        let (mut sum, mut strength) = (0.0, depth);
        for stripes in &self.octaves {
            let steep = (gx * gx + gy * gy).sqrt();
            let (sx, sy) = if steep > 0.0 { (-gy / steep, gx / steep) } else { (1.0, 0.0) };
            // Crests and valley floors keep their shape: without a slope water does not cut.
            let amplitude = strength * stripes.cell * self.share(steep);
            let (wave, across) = stripes.at(x, y, sx, sy);
            sum += amplitude * (wave - 0.25);
            let turn = amplitude * across * (WAVES * 4.0 / stripes.cell);
            gx += sx * turn;
            gy += sy * turn;
            strength *= gain;
        }
        let steep = (gx * gx + gy * gy).sqrt();
        (sum, strength * self.share(steep))
    }

    /// How deep water cuts at a slope. Quadratic at first: where the slope turns over, the stripes on either side do
    /// not fit together, and nothing of them may be seen.
    fn share(&self, steep: f64) -> f64 {
        steep * steep / (steep * steep + self.gentle * self.gentle)
    }
}

impl Stripes {
    /// The wave and its slope across the stripes, both in [−1, 1]; (`sx`, `sy`) is the unit vector across.
    #[inline]
    fn at(&self, x: f64, y: f64, sx: f64, sy: f64) -> (f64, f64) {
        let (px, py) = ((self.cos * x - self.sin * y) / self.cell, (self.sin * x + self.cos * y) / self.cell);
        let (ax, ay) = (WAVES * (self.cos * sx - self.sin * sy), WAVES * (self.sin * sx + self.cos * sy));
        let (ix, iy) = (floor(px), floor(py));
        let (mut even, mut odd) = (0.0, 0.0);
        for j in -1..=1 {
            for i in -1..=1 {
                let h = hash(self.key, ix + i, iy + j);
                let dx = px - ((ix + i) as f64 + 0.5 + 0.25 * high(h));
                let dy = py - ((iy + j) as f64 + 0.5 + 0.25 * low(h));
                // Beyond a distance of 1.25 lies the next ring of cells, which is not looked at.
                let w = (1.0 - (dx * dx + dy * dy) / 1.5625).max(0.0);
                let w = w * w;
                let phase = dx * ax + dy * ay;
                even += w * wave(phase + 0.25);
                odd += w * wave(phase);
            }
        }
        // Where neighbours cancel out the stripes end; elsewhere they are brought to nearly full height.
        let norm = (even * even + odd * odd + 0.02).sqrt();
        (even / norm, -odd / norm)
    }
}

/// A sine of period 1, out of parabolas.
#[inline(always)]
fn wave(t: f64) -> f64 {
    let t = t - floor(t + 0.5) as f64;
    t * (8.0 - 16.0 * t.abs())
}
