//! What `verify` makes beside its verdict.

use std::path::PathBuf;

use crate::run::Extras;

#[derive(Debug, clap::Args)]
pub(super) struct QaArgs {
    /// Write the vertical error of every sample, surface less raster, as a tiled GeoTIFF with the raster's place and CRS. Its
    /// nodata value is NaN, where there is no surface or no height
    #[arg(long, help_heading = "Report", value_name = "TIFF")]
    error_raster: Option<PathBuf>,
    /// Replace the files that --error-raster names
    #[arg(long, help_heading = "Report")]
    overwrite: bool,
}

impl QaArgs {
    /// What is made.
    pub(super) fn extras(&self) -> Extras {
        Extras { error_raster: self.error_raster.clone(), overwrite: self.overwrite, survey: false }
    }
}
