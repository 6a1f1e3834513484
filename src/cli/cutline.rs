//! `--cutline` and `--cutline-layer`: the options that `simplify`, `verify` and `preview` share.

use std::path::PathBuf;

use crate::raster::CutlineSource;

/// Polygons outside of which there is no ground.
#[derive(Debug, clap::Args)]
pub(crate) struct CutlineArgs {
    /// A layer of polygons, in any format OGR reads: samples outside of them count as samples without a height
    #[arg(long, help_heading = "Input", value_name = "FILE")]
    pub(super) cutline: Option<PathBuf>,
    /// The layer of --cutline [default: the first]
    #[arg(long, help_heading = "Input", hide_short_help = true, value_name = "NAME", requires = "cutline")]
    cutline_layer: Option<String>,
}

impl CutlineArgs {
    /// Where the polygons come from, if there are any.
    pub(super) fn source(&self) -> Option<CutlineSource> {
        let path = self.cutline.clone()?;
        Some(CutlineSource { path, layer: self.cutline_layer.clone() })
    }
}
