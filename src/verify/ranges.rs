//! The ranges that attributes are scaled by.

use crate::base::channels::ChannelBands;
use crate::base::control::{Control, Stage};
use crate::base::{Band, SampleType};

use super::VerifyError;
use super::samples::BandReader;

/// Grey levels of 8 bits stand for heights where there are none.
const PLANAR_UNIT: f64 = 255.0;

/// What a difference counts: s for heights, sᵢ for each channel. The formula is the one of [`super::verify_with_channels`].
#[derive(Debug, Clone)]
pub(super) struct Scales {
    /// M.
    pub(super) unit: f64,
    /// Rᵢ as least and largest value.
    pub(super) ranges: Vec<(f64, f64)>,
    /// s, then the sᵢ.
    pub(super) scales: Vec<f64>,
}

impl Scales {
    pub(super) fn find(raster: &Band, options: &ChannelBands, control: &Control<'_>) -> Result<Scales, VerifyError> {
        let unit = if options.planar { PLANAR_UNIT } else { width(search(raster, control)?) };
        let ranges = options.bands.iter().map(|b| of_type(b).map_or_else(|| search(b, control), Ok));
        let ranges = ranges.collect::<Result<Vec<_>, _>>()?;
        let w = options.emphasis;
        let channel = |&r: &(f64, f64)| match width(r) {
            0.0 => 0.0,
            range => (w * (unit / options.bands.len() as f64) / range).min(f64::MAX),
        };
        let scales = std::iter::once(1.0 - w).chain(ranges.iter().map(channel)).collect();
        Ok(Scales { unit, ranges, scales })
    }
}

fn width((least, largest): (f64, f64)) -> f64 {
    largest - least
}

/// Unsigned samples of 8 and 16 bits count as fractions of what their type holds.
fn of_type(band: &Band) -> Option<(f64, f64)> {
    match band.sample_type() {
        SampleType::U8 if band.scaling().is_none() => Some((0.0, 255.0)),
        SampleType::U16 if band.scaling().is_none() => Some((0.0, 65535.0)),
        _ => None,
    }
}

/// The least and the largest sample; 0 where none has a value.
fn search(raster: &Band, control: &Control<'_>) -> Result<(f64, f64), VerifyError> {
    let mut reader = BandReader::new(raster);
    let (mut least, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
    control.progress.begin(Stage::Ranges, reader.count() as u64, raster.width() as u64 * raster.height() as u64);
    for index in 0..reader.count() {
        control.cancel.check()?;
        let samples = reader.read(index)?;
        for &sample in samples {
            // A zero has no sign here. What has no value is passed over: NaN is neither less nor larger.
            (least, largest) = (least.min(sample + 0.0), largest.max(sample + 0.0));
        }
        control.progress.step(Stage::Ranges, samples.len() as u64);
    }
    control.progress.end(Stage::Ranges);
    Ok(if least <= largest { (least, largest) } else { (0.0, 0.0) })
}
