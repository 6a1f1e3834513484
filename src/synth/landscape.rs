//! The large landforms: plains, hills and massifs, bent by domain warping.
//!
//! After Musgrave's ridged multifractal and Quílez's domain warping. Wavelengths run from about a thousand samples
//! down; nothing is longer, so a raster of 4096 samples a side sees the same mixture of landforms as one of 100,000.
//! What water does to them, and everything shorter than [`SHORTEST`] samples, is in [`super::erosion`].

use super::noise::{Octave, fbm, octaves, smoothstep};
use super::options::TerrainOptions;

/// The shortest wavelength here, in samples.
const SHORTEST: f64 = 60.0;

/// The large forms at a place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Form {
    /// Height as a share of the relief.
    pub(super) height: f64,
    /// 0 in the plains, 1 in the mountains.
    pub(super) mountain: f64,
}

#[derive(Debug)]
pub(super) struct Landscape {
    warp: [Vec<Octave>; 2],
    mask: Vec<Octave>,
    ridges: Vec<Octave>,
    hills: Vec<Octave>,
    plains: Vec<Octave>,
}

impl Landscape {
    pub(super) fn new(options: &TerrainOptions) -> Landscape {
        let octaves = |stream, wavelength, count| octaves(options.seed, stream, wavelength, 0.66, count);
        Landscape {
            warp: [octaves(1, 520.0, 6), octaves(2, 520.0, 6)],
            mask: octaves(3, 1400.0, 7),
            ridges: octaves(4, 620.0, 6),
            hills: octaves(5, 320.0, 5),
            plains: octaves(6, 900.0, 7),
        }
    }

    /// The forms at a place given in samples.
    pub(super) fn at(&self, x: f64, y: f64) -> Form {
        let wx = 95.0 * fbm(&self.warp[0], 0.62, x, y);
        let wy = 95.0 * fbm(&self.warp[1], 0.62, x, y);
        let (px, py) = (x + wx, y + wy);
        let mask = fbm(&self.mask, 0.62, x + 0.6 * wx, y + 0.6 * wy);
        let mountain = smoothstep(-0.6, 0.9, mask);
        let ridge = self.ridge(px, py);
        let hill = fbm(&self.hills, 0.6, px, py);
        let plain = fbm(&self.plains, 0.6, px, py);
        let height = 0.16
            + 0.045 * plain
            + (0.016 + 0.05 * mountain) * hill
            + mountain * (0.12 + 0.08 * plain + (0.10 + 0.55 * mountain) * ridge);
        Form { height, mountain }
    }

    /// Ridged multifractal: creases of the noise become crests, and each octave is strong where the last one was high.
    fn ridge(&self, x: f64, y: f64) -> f64 {
        let (mut sum, mut amplitude, mut weight, mut total) = (0.0, 1.0, 1.0, 0.0);
        for octave in &self.ridges {
            let n = octave.value(x, y);
            // Crests are rounded over a little: a mathematical edge would be nothing but aliasing.
            let crease = (1.0 - 1.1 * ((n * n + 0.0004).sqrt() - 0.02)).max(0.0);
            let crest = crease * crease * weight;
            sum += amplitude * crest;
            total += amplitude;
            weight = (1.6 * crest).clamp(0.0, 1.0);
            amplitude *= 0.58;
        }
        sum / total
    }
}

const _: () = assert!(SHORTEST > 3.0 * super::terrain::FORMS as f64, "forms must be resolved by their nodes");
