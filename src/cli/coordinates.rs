//! `simplify --local`, `--z-scale` and `--precision`: how coordinates are written.

use clap::ValueEnum;

use super::combinations::{Asked, BY_FORMAT};
use super::{Failure, values};
use crate::base::features::Feature;
use crate::formats::{Format, Precision};
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
    /// Number type of coordinates; float implies --local, and what heights lose in it is taken from --max-error [default: double
    /// where the format has it]
    #[arg(long, hide_short_help = true, value_enum)]
    precision: Option<PrecisionArg>,
}

/// How coordinates of a converted mesh are written.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Coordinates")]
pub(super) struct ConvertedArgs {
    /// Write x and y less an origin near the middle of the mesh, which the header names
    #[arg(long)]
    local: bool,
    /// Multiply heights by this, as the header says
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = values::factor, allow_hyphen_values = true)]
    z_scale: f64,
    /// Number type of coordinates, where the format has both; those that are float already stay so
    #[arg(long, value_enum)]
    precision: Option<PrecisionArg>,
}

impl ConvertedArgs {
    /// What is asked for. Doubles are refused for a format that has none.
    pub(super) fn coordinates(&self, format: Option<&Format>) -> Result<Coordinates, Failure> {
        format.map_or(Ok(()), |format| check_precision(self.precision, format))?;
        let single = self.precision == Some(PrecisionArg::Float);
        Ok(Coordinates { local: self.local, z_scale: self.z_scale, single })
    }
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
        let by = match (self.precision, single) {
            (Some(PrecisionArg::Float), _) => Some("--precision float".to_string()),
            (_, Some(format)) => Some(format!("{BY_FORMAT}{format}, whose numbers are single")),
            _ => None,
        };
        match by {
            Some(option) if fitted => asked.add_by(Feature::RoundedToSingle, option),
            // The raster's heights may need them, too.
            Some(_) => asked.foresee(Feature::RoundedToSingle),
            None => {}
        }
    }

    /// Refuses doubles for a format that has none.
    pub(super) fn check(&self, format: &Format) -> Result<(), Failure> {
        check_precision(self.precision, format)
    }

    /// What is asked for.
    pub(super) fn coordinates(&self) -> Coordinates {
        Coordinates { local: self.local, z_scale: self.z_scale, single: self.precision == Some(PrecisionArg::Float) }
    }
}

/// Refuses doubles for a format that has none.
pub(super) fn check_precision(asked: Option<PrecisionArg>, format: &Format) -> Result<(), Failure> {
    if asked != Some(PrecisionArg::Double) || format.precisions.contains(&Precision::Double) {
        return Ok(());
    }
    let message = format!("expected a format that has doubles, found {} with --precision double", format.title);
    Err(Failure::usage(message).hint("remove the option, or choose PLY, OBJ, VTP or UGRID"))
}
