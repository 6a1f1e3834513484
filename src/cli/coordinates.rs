//! `simplify --local`, `--z-scale` and `--precision`: how coordinates are written.

use clap::ValueEnum;

use super::combinations::Asked;
use super::values;
use crate::base::features::Feature;
use crate::run::Coordinates;

/// How coordinates are written.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Coordinates")]
pub(super) struct CoordinateArgs {
    /// Write x and y less an origin near the middle of the raster, which the header names
    #[arg(long, hide_short_help = true)]
    local: bool,
    /// Multiply heights by this in the output, as the header says; --max-error is about the heights of the raster
    #[arg(long, hide_short_help = true, value_name = "F", default_value_t = 1.0, value_parser = values::factor, allow_hyphen_values = true)]
    z_scale: f64,
    /// Number type of coordinates; float implies --local, and what heights lose in it is taken from --max-error
    #[arg(long, hide_short_help = true, value_enum, default_value_t = PrecisionArg::Double)]
    precision: PrecisionArg,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum PrecisionArg {
    Double,
    Float,
}

impl CoordinateArgs {
    /// What of this asks for features, as far as options alone say: `fitted` heights need all their digits, and `single` is a
    /// format that has no other precision.
    pub(super) fn ask(&self, fitted: bool, single: Option<&str>, asked: &mut Asked) {
        if !self.coordinates().scales_exactly() {
            asked.add_by(Feature::InexactScale, format!("--z-scale {}", self.z_scale));
        }
        if fitted && self.precision == PrecisionArg::Float {
            asked.add_by(Feature::RoundedToSingle, "--precision float");
        } else if let Some(format) = single.filter(|_| fitted) {
            asked.add_by(Feature::RoundedToSingle, format!("the format {format}, whose numbers are single"));
        }
    }

    /// What is asked for.
    pub(super) fn coordinates(&self) -> Coordinates {
        Coordinates { local: self.local, z_scale: self.z_scale, single: self.precision == PrecisionArg::Float }
    }
}
