//! How a converted mesh has coordinates, and the step from those of the input.

use crate::base::{CoordinateFrame, Metres, metres_in};
use crate::formats::{Bounds, Format, Header, Unit};
use crate::run::Coordinates;
use crate::run::coordinates::origin;

/// How the output has coordinates. A step that the input has made already stays as it is: what was rounded cannot be placed
/// anew. Where that is asked for, the error says what the input has.
pub(super) fn frame(
    given: &Header,
    target: &Format,
    asked: Coordinates,
    read: Bounds,
) -> Result<CoordinateFrame, &'static str> {
    let source = given.frame;
    let Coordinates { local, z_scale, single } = asked;
    if z_scale != 1.0 && source.z_scale != CoordinateFrame::PLAIN.z_scale {
        return Err("heights that were multiplied already");
    }
    if (z_scale != 1.0 || local && !source.is_local()) && source.single {
        return Err("coordinates rounded to single precision");
    }
    let is_moved = local && !source.is_local() || z_scale != 1.0;
    let is_as_asked = !is_moved && source.single == single && target.unit == Unit::OfCrs;
    if source.single || is_as_asked {
        return Ok(source);
    }
    let is_plain = !source.is_local();
    let [(left, right), (bottom, top)] = [(read.min[0], read.max[0]), (read.min[1], read.max[1])];
    let origin = match is_plain && (single || local) && left <= right {
        true => origin([left, bottom, right, top]),
        false => source.origin,
    };
    let in_metres = target.unit == Unit::Metre;
    let xy_scale = match in_metres && source.xy_scale == CoordinateFrame::PLAIN.xy_scale {
        true => Metres::between(metres(given), bottom + source.origin.1, top + source.origin.1),
        false => source.xy_scale,
    };
    let metres = match in_metres && source.z_scale == CoordinateFrame::PLAIN.z_scale {
        true => given.heights.unit.as_deref().and_then(metres_in).unwrap_or(1.0),
        false => 1.0,
    };
    Ok(CoordinateFrame { origin, xy_scale, z_scale: source.z_scale * z_scale * metres, single })
}

#[cfg(feature = "gdal")]
fn metres(header: &Header) -> Option<Metres> {
    header.crs.metres.or_else(|| crate::raster::metres_of(header.crs.definition.as_deref()?))
}

#[cfg(not(feature = "gdal"))]
fn metres(header: &Header) -> Option<Metres> {
    header.crs.metres
}

/// From the numbers of one frame to those of another that goes on where it ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) from: CoordinateFrame,
    pub(super) to: CoordinateFrame,
}

impl Step {
    /// What the second frame writes of a vertex, operation by operation ([`CoordinateFrame::written_place`]).
    pub(super) fn take(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let Step { from, to } = self;
        let rounded = |value: f64| if to.single { f64::from(value as f32) } else { value };
        let across = |value: f64, from: (f64, f64), to: (f64, f64)| {
            let moved = if from.0 == to.0 { value } else { value - to.0 };
            rounded(if from.1 == to.1 { moved } else { moved * to.1 })
        };
        let height = if from.z_scale == to.z_scale { z } else { z * to.z_scale };
        [
            across(x, (from.origin.0, from.xy_scale.0), (to.origin.0, to.xy_scale.0)),
            across(y, (from.origin.1, from.xy_scale.1), (to.origin.1, to.xy_scale.1)),
            rounded(height),
        ]
    }

    /// What the second frame makes of the normal of a vertex: longer axes turn it away from them. `None` where it stays as it is.
    pub(super) fn turn(&self) -> Option<impl Fn([f64; 3]) -> [f64; 3] + use<>> {
        let scales = |frame: &CoordinateFrame| [frame.xy_scale.0, frame.xy_scale.1, frame.z_scale];
        let (from, to) = (scales(&self.from), scales(&self.to));
        let turn = move |normal: [f64; 3]| {
            let turned: [f64; 3] = std::array::from_fn(|i| normal[i] * from[i] / to[i]);
            let length = turned.iter().map(|n| n * n).sum::<f64>().sqrt();
            turned.map(|n| f64::from((n / length) as f32))
        };
        (from != to).then_some(turn)
    }
}
