//! `--breaklines` and what belongs to it: the options that `simplify`, `plan` and `verify` share.

use std::path::PathBuf;

use super::combinations::Asked;
use super::values;
use crate::base::Polylines;
use crate::base::features::Feature;
use crate::raster::LineSource;
use crate::run::{LineInput, Lines};

/// Lines that edges of the mesh follow.
#[derive(Debug, clap::Args)]
pub(crate) struct BreaklineArgs {
    /// A layer of lines, in any format OGR reads: edges of the mesh follow them, within the tolerance of the raster's surface.
    /// `verify` needs the same option
    #[arg(long, help_heading = "Mesh", value_name = "FILE")]
    pub(super) breaklines: Option<PathBuf>,
    /// The layer of --breaklines [default: the first]
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "NAME", requires = "breaklines")]
    breaklines_layer: Option<String>,
    /// How far edges may be from the lines of --breaklines, seen from above, so that fewer are needed; from 0 to 16
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "CELLS", requires = "breaklines", value_parser = values::shift,
        default_value_t = Polylines::USUAL_SHIFT, allow_hyphen_values = true)]
    breakline_shift: f64,
}

impl BreaklineArgs {
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Breaklines, self.breaklines.is_some());
    }

    /// The lines, if there are any.
    pub(super) fn input(&self) -> Option<LineInput> {
        let source = LineSource { path: self.breaklines.clone()?, layer: self.breaklines_layer.clone() };
        Some(LineInput { from: Lines::Layer(source), shift: self.breakline_shift })
    }
}
