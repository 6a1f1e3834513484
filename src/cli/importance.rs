//! `--importance`: the options that `simplify` and `verify` share.

use std::path::{Path, PathBuf};

use super::combinations::Asked;
use super::{Failure, values};
use crate::base::RasterError;
use crate::job::features::Feature;
use crate::raster::Raster;

/// Where the weights of errors come from.
#[derive(Debug, clap::Args)]
pub(crate) struct ImportanceArgs {
    /// A raster of weights on the same grid: distance × weight is within --max-error at every sample; 0 lets it go free
    #[arg(long, value_name = "RASTER")]
    pub(super) importance: Option<PathBuf>,
    /// The band of the weights, counted from 1
    #[arg(long, value_name = "N", default_value_t = 1, requires = "importance")]
    importance_band: usize,
    /// An open option of the importance raster's format. May be given more than once
    #[arg(long = "importance-oo", value_name = "NAME=VALUE", value_parser = values::open_option, requires = "importance")]
    importance_options: Vec<String>,
}

impl ImportanceArgs {
    /// What of this asks for features.
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Importance, self.importance.is_some());
    }

    /// Opens the importance raster, if there is one, and makes sure that it lies on the samples of `raster`.
    pub(super) fn open(&self, raster: &Raster) -> Result<Option<Raster>, Failure> {
        let Some(path) = &self.importance else { return Ok(None) };
        let importance = Raster::open_with(path, self.importance_band, &self.importance_options).map_err(|error| {
            let failure = Failure::new(&error);
            match error {
                RasterError::NoSuchBand { .. } => failure.hint("choose one with --importance-band"),
                RasterError::SampleType { .. } => failure.hint("choose another band with --importance-band"),
                other => other.into(),
            }
        })?;
        let importance = raster.clip_alike(importance)?;
        raster.to_band()?.same_grid(&importance.to_band()?)?;
        Ok(Some(importance))
    }

    /// What the file is called, without its folders.
    pub(super) fn file_name(&self) -> Option<&Path> {
        self.importance.as_deref().map(|path| path.file_name().map_or(path, Path::new))
    }
}
