//! `simplify --local`, `--z-scale` and `--precision`: how coordinates are written; and what they mean.

use clap::ValueEnum;
use serde::Serialize;

use super::combinations::Asked;
use super::goal::GoalArgs;
use super::{Failure, values};
use crate::base::control::Control;
use crate::base::{Reference, Tolerance};
use crate::field::height_range;
use crate::formats::ply::read::Frame;
use crate::job::features::Feature;
use crate::job::{Error, Goal, VertexHeights};
use crate::raster::Raster;

/// How coordinates are written.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Coordinates")]
pub(super) struct MapArgs {
    /// Write x and y less an origin near the middle of the raster, which the header names
    #[arg(long)]
    local: bool,
    /// Multiply heights by this in the output, as the header says; --max-error is about the heights of the raster
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = values::factor, allow_hyphen_values = true)]
    z_scale: f64,
    /// Number type of coordinates; float implies --local, and what heights lose in it is taken from --max-error
    #[arg(long, value_enum, default_value_t = PrecisionArg::Double)]
    precision: PrecisionArg,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PrecisionArg {
    Double,
    Float,
}

/// How a run writes coordinates, and what that leaves for the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Written {
    pub(super) frame: Frame,
    /// How far a height may be from the one that is read again.
    pub(super) loss: f64,
    /// The tolerance, less what is lost in writing.
    pub(super) tolerance: Tolerance,
    /// What ends the refinement beside the tolerance, likewise.
    pub(super) goal: Goal,
}

impl MapArgs {
    /// Whether coordinates are written as they are.
    pub(super) fn is_plain(&self) -> bool {
        !self.local && self.z_scale == 1.0 && self.precision == PrecisionArg::Double
    }

    /// What of this asks for features, as far as options alone say: `fitted` heights need all their digits.
    pub(super) fn ask(&self, fitted: bool, asked: &mut Asked) {
        if !is_power_of_two(self.z_scale) {
            asked.add_by(Feature::InexactScale, format!("--z-scale {}", self.z_scale));
        }
        if fitted && self.precision == PrecisionArg::Float {
            asked.add_by(Feature::RoundedToSingle, PRECISION_FLOAT);
        }
    }

    /// What of this asks for features once the raster is open.
    pub(super) fn ask_of(&self, raster: &Raster, asked: &mut Asked) {
        if self.precision == PrecisionArg::Float && !fits_single(raster) {
            asked.add_by(Feature::RoundedToSingle, PRECISION_FLOAT);
        }
    }

    /// The frame of the output, and what of the tolerance and the goal is left for the mesh: what rounding loses of heights
    /// is found out, which may read the whole raster, and taken from them. `heights` are those of vertices. Errors count as
    /// vertical distances wherever anything is lost.
    pub(super) fn written(
        &self,
        raster: &Raster,
        flat: bool,
        asked: &GoalArgs,
        heights: VertexHeights,
        control: &Control<'_>,
    ) -> Result<Written, Failure> {
        let frame = self.frame(raster)?;
        let (tolerance, goal) = (Tolerance::new(asked.tolerance()), asked.goal());
        let fits = heights == VertexHeights::Sampled && fits_single(raster);
        if flat || (is_power_of_two(frame.z_scale) && (fits || !frame.single)) {
            return Ok(Written { frame, loss: 0.0, tolerance, goal });
        }
        let range = height_range(&raster.to_band()?, control).map_err(Error::from)?;
        if range.min > range.max {
            // Not one sample has a height.
            return Err(Error::NoGround { path: raster.path().to_path_buf() }.into());
        }
        let room = if tolerance.is_open() { range.width() } else { 2.0 * tolerance.asked() };
        // Fitted heights may be beyond those of samples.
        let largest = range.min.abs().max(range.max.abs()) + room;
        let loss = largest * if frame.single { f64::from(f32::EPSILON) / 2.0 } else { 0.0 };
        // Two roundings of doubles; and below the least of its numbers single precision has steps.
        let loss = loss + largest * f64::EPSILON * 2.0 + f64::from(f32::from_bits(1)) / frame.z_scale;
        let name = raster.path().display();
        let way_out = if frame.single { "--precision double loses less" } else { "--z-scale 1 loses nothing" };
        let less = |what: &str, limit: f64| {
            if loss > limit / 2.0 {
                let expected =
                    format!("{name}: expected to lose at most half of the {what} {limit} in writing heights");
                let found = format!("found a loss of up to {loss:e} with heights up to {largest}");
                return Err(Failure::new(format!("{expected}, {found}")).hint(way_out));
            }
            Ok(Tolerance::new(limit).less(loss))
        };
        let kept = if tolerance.is_open() { tolerance } else { less("tolerance", tolerance.asked())? };
        // What moves no height by more than this moves the root of the mean square by no more.
        let max_rms = goal.max_rms.map(|rms| less("--max-rms", rms)).transpose()?;
        let goal = Goal { max_rms: max_rms.map(|rms| rms.kept()), ..goal };
        Ok(Written { frame, loss, tolerance: kept, goal })
    }

    fn frame(&self, raster: &Raster) -> Result<Frame, Failure> {
        let single = self.precision == PrecisionArg::Float;
        let origin = if self.local || single { origin(raster.extent()) } else { Frame::PLAIN.origin };
        let frame = Frame { origin, z_scale: self.z_scale, single };
        // In doubles it was made sure of when the raster was opened.
        if single && !frame.tells_apart(&raster.geo_transform(), raster.width(), raster.height()) {
            let (name, width, height) = (raster.path().display(), raster.width(), raster.height());
            let expected = format!("{name}: expected quarters of cells that single precision tells apart");
            let found = format!("found {width} × {height} samples, too many for it");
            return Err(Failure::new(format!("{expected}, {found}")).hint("choose --precision double"));
        }
        Ok(frame)
    }
}

/// What asks for single precision.
const PRECISION_FLOAT: &str = "--precision float";

/// Whether numbers multiplied by this stay what they are.
fn is_power_of_two(factor: f64) -> bool {
    factor.log2().fract() == 0.0
}

/// Whether the heights of samples are numbers of single precision.
fn fits_single(raster: &Raster) -> bool {
    raster.sample_type().fits_f32() && raster.scaling().is_none()
}

/// A round number near the middle of the raster: nothing is left of large coordinates but what the raster spans.
fn origin([left, bottom, right, top]: [f64; 4]) -> (f64, f64) {
    let step = 10f64.powf((right - left).max(top - bottom).log10().floor());
    let round = |low: f64, high: f64| {
        let rounded = ((low + high) / 2.0 / step).round() * step;
        // A negative zero is zero.
        if rounded.is_finite() { rounded + 0.0 } else { 0.0 }
    };
    (round(left, right), round(bottom, top))
}

/// What the report says of coordinates.
#[derive(Debug, Clone, Serialize)]
pub(super) struct MapReport {
    #[serde(flatten)]
    reference: Reference,
    /// What is taken from x and y in the output.
    offset: (f64, f64),
    /// What heights are multiplied by in the output.
    z_scale: f64,
    /// "double" or "float".
    precision: &'static str,
    /// What of the tolerance is kept for what writing loses of heights.
    kept_for_rounding: f64,
}

impl MapReport {
    pub(super) fn new(raster: &Raster, written: &Written) -> MapReport {
        let Written { frame, loss, .. } = *written;
        MapReport {
            reference: raster.reference(),
            offset: frame.origin,
            z_scale: frame.z_scale,
            precision: if frame.single { "float" } else { "double" },
            kept_for_rounding: loss,
        }
    }

    pub(super) fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = vec![("map", place(&self.reference)), ("heights", heights(&self.reference))];
        lines.retain(|(_, value)| !value.is_empty());
        let mut written = Vec::new();
        if self.offset != (0.0, 0.0) {
            written.push(format!("x less {}, y less {}", self.offset.0, self.offset.1));
        }
        if self.z_scale != 1.0 {
            written.push(format!("z is height × {}", self.z_scale));
        }
        if self.precision == "float" {
            written.push("single precision".to_string());
        }
        if self.kept_for_rounding > 0.0 {
            written.push(format!("{:.1e} of the tolerance is kept for rounding heights", self.kept_for_rounding));
        }
        if !written.is_empty() {
            lines.push(("written", written.join("; ")));
        }
        lines
    }
}

/// Where on the map, in words.
pub(super) fn place(reference: &Reference) -> String {
    let Reference { crs, georeferenced, geographic, longitudes_beyond_180, unit, .. } = reference;
    match (georeferenced, crs.as_str()) {
        (false, "none") => "no georeferencing: plain pixel coordinates, x = column + ½, y = −(row + ½)".to_string(),
        (false, crs) => format!("{crs}, but no geotransform: plain pixel coordinates, x = column + ½, y = −(row + ½)"),
        (true, "none") => "no CRS: coordinates as the geotransform has them".to_string(),
        (true, crs) if *geographic => {
            let beyond = if *longitudes_beyond_180 { ", longitudes beyond 180 kept as they are" } else { "" };
            let hint = "gdalwarp -t_srs to a projected CRS makes them alike, or --z-scale";
            format!("{crs}: {unit}s across{beyond}, heights in another unit; where shapes matter, {hint}")
        }
        (true, crs) => format!("{crs}, unit {}", if unit.is_empty() { "not said" } else { unit }),
    }
}

/// What heights are in, in words; empty where nothing is said.
pub(super) fn heights(reference: &Reference) -> String {
    match (reference.vertical_crs.as_str(), reference.height_unit.as_str()) {
        ("", "") => String::new(),
        ("", unit) => format!("unit {unit}"),
        (crs, "") => format!("{crs}, unit not said"),
        (crs, unit) => format!("{crs}, unit {unit}"),
    }
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
