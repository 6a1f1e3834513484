//! Why a raster could not be made.

use std::path::PathBuf;

use super::OptionError;
use crate::base::control::Cancelled;
use crate::base::staged::OutputError;

/// Why a raster could not be made. Nothing is left under its name then.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SynthError {
    /// A number that cannot be.
    #[error(transparent)]
    Option(#[from] OptionError),
    /// The output file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// GDAL refuses: no such compression in this build, or a full disk.
    #[error("{}: {what}: {reason}", path.display())]
    Gdal {
        /// The output.
        path: PathBuf,
        /// What was tried.
        what: &'static str,
        /// What GDAL said.
        reason: String,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
