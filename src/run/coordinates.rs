//! How a run writes coordinates, and what that leaves of the tolerance.

use super::{Coordinates, Request, RunError};
use crate::base::control::Control;
use crate::base::{Band, CoordinateFrame, Tolerance};
use crate::field::{height_range, searched_range};
use crate::formats::{Format, Precision, Unit};
use crate::job::{Error, Goal, Params};

/// How coordinates are written, and what that leaves for the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Written {
    pub(super) frame: CoordinateFrame,
    /// How far a height may be from the one that is read again.
    pub(super) loss: f64,
    /// The tolerance, less what is lost in writing.
    pub(super) tolerance: Tolerance,
    /// What ends the refinement beside the tolerance, likewise.
    pub(super) goal: Goal,
}

/// Whether the heights of samples are numbers of single precision.
pub(super) fn fits_single(band: &Band) -> bool {
    band.sample_type().fits_f32() && band.scaling().is_none()
}

impl Written {
    /// The frame of the output, and what of the tolerance and the goal is left for the mesh: what rounding loses of heights
    /// is found out, which may read the whole raster, and taken from them. `lines` is the range of heights that lines have. Where errors have weights, the largest weight is
    /// found out likewise: the loss may count that many times.
    pub(super) fn find(
        request: &Request<'_>,
        format: &Format,
        (band, importance, lines): (&Band, Option<&Band>, Option<[f64; 2]>),
        is_flat: bool,
        control: &Control<'_>,
    ) -> Result<Written, RunError> {
        let frame = frame(request.coordinates, format, band)?;
        let Params { tolerance, goal, .. } = request.params;
        let fits = !request.has_fitted_heights() && fits_single(band);
        if is_flat || (frame.scales_exactly() && (fits || !frame.single)) {
            return Ok(Written { frame, loss: 0.0, tolerance, goal });
        }
        let range = height_range(band, control)?;
        if range.min > range.max {
            // Not one sample has a height.
            return Err(Error::NoGround { path: band.path().to_path_buf() }.into());
        }
        // A search for a tolerance goes a little beyond the range.
        let room = if tolerance.is_open() { 8.0 * range.width() } else { 2.0 * tolerance.asked() };
        // Fitted heights may be beyond those of samples.
        let largest = range.min.abs().max(range.max.abs()) + room;
        // Lines have heights of their own.
        let largest = lines.into_iter().flatten().fold(largest, |largest, height| largest.max(height.abs()));
        let loss = largest * if frame.single { f64::from(f32::EPSILON) / 2.0 } else { 0.0 };
        // Two roundings of doubles; and below the least of its numbers single precision has steps.
        let loss = loss + largest * f64::EPSILON * 2.0 + f64::from(f32::from_bits(1)) / frame.z_scale;
        let weight = match importance {
            // Rounded up, as the product is.
            Some(importance) => searched_range(importance, control)?.max.max(1.0) * (1.0 + f64::EPSILON),
            None => 1.0,
        };
        let less = |what: &'static str, limit: f64, weight: f64| {
            let counted = loss * weight;
            if counted > limit / 2.0 {
                let path = band.path().to_path_buf();
                return Err(RunError::Loss { path, what, limit, loss: counted, largest, single: frame.single });
            }
            Ok(Tolerance::new(limit).less(counted))
        };
        let kept = match tolerance.is_open() {
            true => tolerance.less(loss * weight),
            false => less("tolerance", tolerance.asked(), weight)?,
        };
        // What moves no height by more than this moves the root of the mean square by no more.
        let max_rms = goal.max_rms.map(|rms| less("root mean square", rms, 1.0)).transpose()?;
        let goal = Goal { max_rms: max_rms.map(|rms| rms.kept()), ..goal };
        Ok(Written { frame, loss, tolerance: kept, goal })
    }
}

/// Whether a run writes single precision: it is asked to, or the format has no other.
pub(super) fn is_single(coordinates: Coordinates, format: &Format) -> bool {
    coordinates.single || !format.precisions.contains(&Precision::Double)
}

fn frame(coordinates: Coordinates, format: &Format, band: &Band) -> Result<CoordinateFrame, RunError> {
    let Coordinates { local, z_scale, .. } = coordinates;
    let single = is_single(coordinates, format);
    let origin = if local || single { origin(band.extent()) } else { CoordinateFrame::PLAIN.origin };
    let (xy_scale, metres) = match format.unit {
        Unit::OfCrs => (CoordinateFrame::PLAIN.xy_scale, 1.0),
        Unit::Metre => band.in_metres(),
    };
    let frame = CoordinateFrame { origin, xy_scale, z_scale: z_scale * metres, single };
    // In doubles it was made sure of when the raster was opened.
    if single && !frame.tells_apart(&band.geo_transform(), band.width(), band.height()) {
        let (path, width, height) = (band.path().to_path_buf(), band.width(), band.height());
        return Err(RunError::Indistinct { path, width, height });
    }
    Ok(frame)
}

/// A round number near the middle of the raster: nothing is left of large coordinates but what the raster spans.
pub(super) fn origin([left, bottom, right, top]: [f64; 4]) -> (f64, f64) {
    let step = 10f64.powf((right - left).max(top - bottom).log10().floor());
    let round = |low: f64, high: f64| {
        let rounded = ((low + high) / 2.0 / step).round() * step;
        // A negative zero is zero.
        if rounded.is_finite() { rounded + 0.0 } else { 0.0 }
    };
    (round(left, right), round(bottom, top))
}

#[cfg(test)]
mod tests {
    use super::origin;

    #[test]
    fn origins_are_round() {
        assert_eq!(origin([500_005.0, 5_199_305.0, 500_895.0, 5_199_995.0]), (500_500.0, 5_199_700.0));
        assert_eq!(origin([0.5, -99.5, 99.5, -0.5]), (50.0, -50.0));
        assert_eq!(origin([-1.0, -1.0, 1.0, 1.0]), (0.0, 0.0));
    }
}
