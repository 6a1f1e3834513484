//! Gradient noise at arbitrary points, and the sums of octaves that landforms are made of.

use super::hash::{hash, key};

/// Gradient noise (Perlin 2002) on the unit lattice, scaled to a standard deviation near 0.35.
///
/// Gradients are sums of uniform numbers, almost round in distribution and of varying length: unlike a few unit
/// vectors they prefer no direction, and hills differ in height.
#[inline]
fn gradient_noise(key: u64, x: f64, y: f64) -> f64 {
    let (ix, iy) = (floor(x), floor(y));
    let (fx, fy) = (x - ix as f64, y - iy as f64);
    let corner = |i: i64, j: i64| {
        let (gx, gy) = gradient(hash(key, ix + i, iy + j));
        gx * (fx - i as f64) + gy * (fy - j as f64)
    };
    let (u, v) = (fade(fx), fade(fy));
    let (a, c) = (corner(0, 0), corner(0, 1));
    let (top, bottom) = (a + u * (corner(1, 0) - a), c + u * (corner(1, 1) - c));
    SCALE * (top + v * (bottom - top))
}

const SCALE: f64 = 2.6;

/// 6t⁵ − 15t⁴ + 10t³.
#[inline(always)]
fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
fn gradient(h: u64) -> (f64, f64) {
    let part = |shift: u32| i32::from((h >> shift) as u16 as i16);
    (f64::from(part(0) + part(16)) / 65536.0, f64::from(part(32) + part(48)) / 65536.0)
}

/// One octave: noise of a given wavelength, with no preferred direction.
///
/// Gradient noise likes to run along its lattice. So each octave is the sum of two, the second turned by 45° where
/// the first has its preferences, and each octave is turned against the last one by the angle of the 3-4-5 triangle,
/// whose multiples never come back to a right angle: lattices do not add up to a visible grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Octave {
    key: u64,
    cos: f64,
    sin: f64,
    offset: (f64, f64),
}

impl Octave {
    /// `wavelength` is the lattice's spacing in samples, `turn` how many times it is turned.
    pub(super) fn new(seed: u64, stream: u64, wavelength: f64, turn: u32) -> Octave {
        let (mut cos, mut sin) = (1.0, 0.0);
        for _ in 0..turn {
            (cos, sin) = (0.8 * cos - 0.6 * sin, 0.8 * sin + 0.6 * cos);
        }
        let key = key(seed, stream);
        let offset = (super::hash::high(key) * 1000.0, super::hash::low(key) * 1000.0);
        Octave { key, cos: cos / wavelength, sin: sin / wavelength, offset }
    }

    /// The noise at a place given in samples.
    #[inline]
    pub(super) fn value(&self, x: f64, y: f64) -> f64 {
        let (u, v) = (self.cos * x - self.sin * y, self.sin * x + self.cos * y);
        let straight = gradient_noise(self.key, u + self.offset.0, v + self.offset.1);
        let (u, v) = (HALF_ROOT * (u - v), HALF_ROOT * (u + v));
        let turned = gradient_noise(!self.key, u + self.offset.1, v + self.offset.0);
        HALF_ROOT * (straight + turned)
    }
}

/// √½: the sine of 45°, and what keeps the variance of a sum of two.
const HALF_ROOT: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Octaves whose wavelengths shrink by `ratio`, each lattice turned further.
pub(super) fn octaves(seed: u64, stream: u64, wavelength: f64, ratio: f64, count: u32) -> Vec<Octave> {
    let mut wavelengths = std::iter::successors(Some(wavelength), |w| Some(w * ratio));
    (0..count)
        .filter_map(|i| {
            let turn = 1 + i + 3 * (stream % 7) as u32;
            Some(Octave::new(seed, stream * 100 + u64::from(i), wavelengths.next()?, turn))
        })
        .collect()
}

/// Fractional Brownian motion: octave after octave, each `gain` times as strong.
#[inline]
pub(super) fn fbm(octaves: &[Octave], gain: f64, x: f64, y: f64) -> f64 {
    let (mut sum, mut amplitude) = (0.0, 1.0);
    for octave in octaves {
        sum += amplitude * octave.value(x, y);
        amplitude *= gain;
    }
    sum
}

/// The largest whole number not above `x`, for |x| < 2⁶³: a conversion, where `f64::floor` may be a call.
#[inline(always)]
pub(super) fn floor(x: f64) -> i64 {
    let truncated = x as i64;
    truncated - i64::from(truncated as f64 > x)
}

/// 0 below `from`, 1 above `to`, smooth between.
#[inline]
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
