//! Channels: further values at every sample beside the height, such as colours, and what a surface's error in them
//! counts (Garland & Heckbert 1995, section 4.6, extended height fields).
//!
//! With heights z, channels cᵢ (k of them), an emphasis w from 0 to 1, the range M of the heights over the raster and
//! the range Rᵢ of each channel, the weighted error at a sample is
//!
//! > E = (1 − w)·|Δz| + w·(M/k)·Σᵢ |Δcᵢ|/Rᵢ
//!
//! where Δ is the difference between the sample and the triangle over it, linear in each value. So E is in the units of
//! the heights. As numbers: E = s·|Δz| + Σᵢ sᵢ·|Δcᵢ| with the doubles s = 1 − w and sᵢ = w·(M/k)/Rᵢ, each operation
//! rounded in this order; sᵢ is 0 where Rᵢ is, and at most the largest double. That sum is what meshes are held to.

use std::borrow::Cow;

use super::Band;

/// Bands that are channels, and what they count.
#[derive(Debug, Clone)]
pub struct ChannelBands {
    /// The bands, in the order in which they are written.
    pub bands: Vec<Band>,
    /// From 0 (only the heights count) to 1 (only the channels).
    pub emphasis: f64,
    /// The raster is an image without heights: they are 0 everywhere.
    pub planar: bool,
}

/// A channel as files name it.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Channel {
    /// Letters, digits and underscores, other than `x`, `y` and `z`; different from every other channel's.
    pub name: String,
    /// The narrowest type that holds all values of its type of samples.
    pub number: Number,
}

/// The number type a channel is written in. Samples are written without loss.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum Number {
    U8,
    F32,
    F64,
}

/// The least and the largest of some values.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Range {
    /// The least.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Range {
    /// Of no value.
    pub const EMPTY: Range = Range { min: f64::INFINITY, max: f64::NEG_INFINITY };

    /// Of these values and those.
    pub fn and(self, other: Range) -> Range {
        Range { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// max − min, rounded once.
    pub fn width(self) -> f64 {
        self.max - self.min
    }

    fn magnitude(self) -> f64 {
        self.min.abs().max(self.max.abs())
    }
}

/// The ranges a weighted error is scaled by.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Ranges {
    /// Of the heights.
    pub heights: Range,
    /// Of each channel.
    pub channels: Vec<Range>,
    /// M: the range of the heights; of a planar image [`PLANAR_UNIT`].
    pub unit: f64,
}

/// What stands for the range of the heights where there are none: E is in the grey levels of 8-bit samples then.
pub const PLANAR_UNIT: f64 = 255.0;

/// How the differences of height and channels at a sample make one error.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelError {
    emphasis: f64,
    scale_z: f64,
    scales: Vec<f64>,
    noise: f64,
}

impl ChannelError {
    /// The error of an emphasis from 0 (only the heights count) to 1 (only the channels) over values of these ranges.
    ///
    /// # Panics
    /// If the emphasis is not within 0 and 1, or there is no channel.
    pub fn new(emphasis: f64, ranges: &Ranges) -> ChannelError {
        assert!((0.0..=1.0).contains(&emphasis), "an emphasis of {emphasis}");
        assert!(!ranges.channels.is_empty(), "a weighted error without channels");
        let share = ranges.unit / ranges.channels.len() as f64;
        let scale = |r: &Range| if r.width() > 0.0 { (emphasis * share / r.width()).min(f64::MAX) } else { 0.0 };
        let (scale_z, scales) = (1.0 - emphasis, ranges.channels.iter().map(scale).collect::<Vec<_>>());
        let magnitudes = scales.iter().zip(&ranges.channels).map(|(s, r)| s * r.magnitude());
        let noise = scale_z * ranges.heights.magnitude() + magnitudes.sum::<f64>();
        ChannelError { emphasis, scale_z, scales, noise }
    }

    /// w.
    pub fn emphasis(&self) -> f64 {
        self.emphasis
    }

    /// s: what a difference in height counts.
    pub fn scale_z(&self) -> f64 {
        self.scale_z
    }

    /// sᵢ: what a difference in each channel counts.
    pub fn scales(&self) -> &[f64] {
        &self.scales
    }

    /// E, from the difference in height and those in each channel, in doubles and in the channels' order.
    #[inline(always)]
    pub fn weighted(&self, dz: f64, dc: impl IntoIterator<Item = f64>) -> f64 {
        let channels = self.scales.iter().zip(dc);
        channels.fold(self.scale_z * dz.abs(), |sum, (scale, difference)| sum + scale * difference.abs())
    }

    /// What E, computed in doubles, must not exceed so that the exact E is within the tolerance, and so that whoever
    /// computes it again in doubles finds it there.
    ///
    /// That is tolerance·(1 − 2⁻⁴⁰) − 2⁻⁴³·S, where S = s·max|z| + Σ sᵢ·max|cᵢ|: interpolating in a triangle and summing
    /// up as [`ChannelError::weighted`] does is off by less than 2⁻⁴⁴·(S + E), some hundred roundings. It is negative
    /// where the tolerance is less than that noise: then only vertices are within, and every sample becomes one. (At a
    /// vertex E is 0 by definition, whatever interpolating makes of it.)
    pub fn limit(&self, tolerance: f64) -> f64 {
        const E40: f64 = 1.0 / (1u64 << 40) as f64;
        const E43: f64 = 1.0 / (1u64 << 43) as f64;
        tolerance - tolerance * E40 - self.noise * E43
    }
}

/// A name that files take: what is no letter, digit or underscore becomes an underscore. `None` if nothing is left of
/// it, or it would be taken for a coordinate or a number.
pub fn sanitised(name: &str) -> Option<String> {
    let name = name.trim();
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let clean: Cow<'_, str> = name.chars().map(letter).collect();
    let usable = clean.chars().any(|c| c.is_ascii_alphanumeric())
        && !clean.starts_with(|c: char| c.is_ascii_digit())
        && !["x", "y", "z", "nx", "ny", "nz"].contains(&clean.to_ascii_lowercase().as_str())
        && clean.len() <= 64;
    usable.then(|| clean.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ranges() -> Ranges {
        let range = |min, max| Range { min, max };
        Ranges { heights: range(100.0, 300.0), channels: vec![range(0.0, 255.0), range(7.0, 7.0)], unit: 200.0 }
    }

    #[test]
    fn is_the_papers_formula() {
        let error = ChannelError::new(0.25, &ranges());
        // A channel without a range counts nothing, but is one of the two.
        let expected = 0.75 * 4.0 + 0.25 * 100.0 * 51.0 / 255.0;
        assert!((error.weighted(-4.0, [51.0, 1e9]) - expected).abs() < 1e-12);
        assert_eq!(ChannelError::new(0.0, &ranges()).weighted(-4.0, [51.0, 0.0]), 4.0);
    }

    #[test]
    fn the_limit_leaves_room_for_rounding_and_vanishes_below_it() {
        let error = ChannelError::new(0.5, &ranges());
        assert!(error.limit(1.0) < 1.0 && error.limit(1.0) > 1.0 - 1e-9);
        assert!(error.limit(0.0) < 0.0);
    }

    #[test]
    fn names_are_words() {
        assert_eq!(sanitised(" near-infrared (8) ").as_deref(), Some("near_infrared__8_"));
        for none in ["", "°", "12", "X", "__"] {
            assert_eq!(sanitised(none), None, "{none}");
        }
    }
}
