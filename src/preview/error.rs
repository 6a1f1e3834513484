//! Why there is no picture.

use std::path::{Path, PathBuf};

use crate::base::RasterError;
use crate::base::control::Cancelled;
use crate::base::staged::OutputError;
use crate::formats::ReadError;
use crate::raster::ViewError;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PreviewError {
    /// The raster cannot be used.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The raster cannot be looked at in this way.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The mesh cannot be used.
    #[error(transparent)]
    Mesh(ReadError),
    /// The output file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A number that an option cannot take.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// The option, as the command line names it without dashes.
        option: &'static str,
        /// What it takes.
        expected: &'static str,
        /// What it was given.
        found: String,
    },
    /// A file cannot be written or read back.
    #[error("{}: {what}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        what: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl PreviewError {
    pub(super) fn io(path: &Path, what: &'static str, source: std::io::Error) -> Self {
        PreviewError::Io { path: path.to_path_buf(), what, source }
    }
}

impl From<ReadError> for PreviewError {
    fn from(error: ReadError) -> PreviewError {
        match error {
            ReadError::Cancelled(stopped) => PreviewError::Cancelled(stopped),
            damaged => PreviewError::Mesh(damaged),
        }
    }
}
