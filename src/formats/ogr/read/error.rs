//! What is wrong with a layer.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::base::external::ScratchError;
use crate::formats::ReadError;

/// Why a layer cannot be used. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OgrError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// GDAL does not open it.
    #[error("{}: GDAL cannot open it: {reason}", path.display())]
    Open {
        /// The mesh.
        path: PathBuf,
        /// What GDAL said.
        reason: String,
    },
    /// The database is shorter than its first page says.
    #[error("{}: expected {expected} bytes, as bytes 16 to 31 say, found {found}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// What it should have.
        expected: u64,
        /// What it has.
        found: u64,
    },
    /// There is more than one layer that could be the mesh, or none.
    #[error("{}: expected one layer with geometry, found {found}", path.display())]
    Layers {
        /// The mesh.
        path: PathBuf,
        /// Their names.
        found: String,
    },
    /// What terrabite says of the mesh in the layer's metadata is damaged.
    #[error("{}: expected {expected} in the metadata of the layer, found {found:?}", path.display())]
    Header {
        /// The mesh.
        path: PathBuf,
        /// What would have been right.
        expected: String,
        /// What is there, shortened.
        found: String,
    },
    /// A feature is not made of triangles with heights.
    #[error("{}: feature {feature}: expected {expected}, found {found}", path.display())]
    Feature {
        /// The mesh.
        path: PathBuf,
        /// Its id.
        feature: u64,
        /// What would have been right.
        expected: String,
        /// What there is.
        found: String,
    },
    /// There are not as many as the file says.
    #[error("{}: expected {expected} {what}, as the file says, found {found}: it is damaged", path.display())]
    Count {
        /// The mesh.
        path: PathBuf,
        /// Features, triangles or edges.
        what: &'static str,
        /// What the file says.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected the {expected} triangles that there were when it was opened, found others: the file is being changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
        /// How many there were.
        expected: u64,
    },
    /// Temporary files.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<OgrError> for ReadError {
    fn from(error: OgrError) -> ReadError {
        match error {
            OgrError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            OgrError::Scratch(error) => error.into(),
            OgrError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
