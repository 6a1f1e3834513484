//! `--cutline` and `--cutline-layer`: the options that `simplify`, `verify` and `preview` share.

use std::path::{Path, PathBuf};

use crate::formats::{OptionName, RunOption};
use crate::raster::CutlineSource;

/// Polygons outside of which there is no ground.
#[derive(Debug, clap::Args)]
pub(crate) struct CutlineArgs {
    /// A layer of polygons, in any format OGR reads: samples outside of them count as samples without a height
    #[arg(long, value_name = "FILE")]
    pub(super) cutline: Option<PathBuf>,
    /// The layer of --cutline [default: the first]
    #[arg(long, value_name = "NAME", requires = "cutline")]
    cutline_layer: Option<String>,
}

impl CutlineArgs {
    /// Where the polygons come from, if there are any.
    pub(super) fn source(&self) -> Option<CutlineSource> {
        let path = self.cutline.clone()?;
        Some(CutlineSource { path, layer: self.cutline_layer.clone() })
    }

    /// What of this stands in the mesh's header: what `verify` has to be told.
    pub(super) fn options(&self) -> impl Iterator<Item = RunOption> {
        let name = |path: &PathBuf| path.file_name().map_or(path.as_path(), Path::new).display().to_string();
        let file = self.cutline.iter().map(move |path| RunOption::new(OptionName::Cutline, name(path)));
        file.chain(self.cutline_layer.iter().map(|layer| RunOption::new(OptionName::CutlineLayer, layer)))
    }
}
