//! Why a mesh cannot be written or read.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::base::external::ScratchError;
use crate::base::staged::OutputError;

/// Why a mesh cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SinkError {
    /// The file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A height would change more by being written than was allowed for.
    #[error(
        "{}: expected heights that are written within {allowed} of what they are, found {height}, which would change by \
         {found}",
        path.display()
    )]
    Lossy {
        /// The output.
        path: PathBuf,
        /// The height.
        height: f64,
        /// How much it may change.
        allowed: f64,
        /// How much it would.
        found: f64,
    },
    /// The format keeps an attribute in single precision alone, and it is in double precision.
    #[error("{}: expected attributes of single precision, the most that {format} keeps, found {name}, which is double", path.display())]
    DoubleAttribute {
        /// The output.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// The attribute.
        name: String,
    },
    /// The mesh, or what was asked for, is nothing that the format can hold.
    #[error("{}: expected {expected}, found {found}", path.display())]
    Unfit {
        /// The output.
        path: PathBuf,
        /// What would have been right.
        expected: String,
        /// What there is.
        found: String,
    },
    /// The library that writes the format says that it cannot.
    #[error("{}: {message}", path.display())]
    Library {
        /// The output.
        path: PathBuf,
        /// What it said.
        message: String,
    },
    /// Temporary files.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
    /// The format cannot number this many vertices or triangles.
    #[error(
        "{}: expected at most {limit} {what}, as many as {format} can number, found {found}",
        path.display()
    )]
    TooLarge {
        /// The output.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// What there is too much of.
        what: &'static str,
        /// The most it takes.
        limit: u64,
        /// How many there are.
        found: u64,
    },
}

/// Why a mesh cannot be read. Every message names the file, and the place in it where it is damaged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is a folder, a device or a pipe. Meshes are read more than once, from any place.
    #[error("{}: expected a file, found {found}", path.display())]
    NotAFile {
        /// What was to be a mesh.
        path: PathBuf,
        /// What is there.
        found: &'static str,
    },
    /// Neither its name nor its first bytes are those of a format that is read.
    #[error("{}: expected a mesh in one of the formats {expected}, found none of them", path.display())]
    Unrecognised {
        /// The file.
        path: PathBuf,
        /// The formats.
        expected: String,
    },
    /// Vertices do not have an attribute.
    #[error("{}: expected the attribute {name:?} of vertices, found none of this name", path.display())]
    NoAttribute {
        /// The mesh.
        path: PathBuf,
        /// What was looked for.
        name: String,
    },
    /// An edge that follows a line ends where there is no vertex.
    #[error("{}: edge {edge}: expected two vertices, found another {found}", path.display())]
    EdgeEnd {
        /// The mesh.
        path: PathBuf,
        /// The edge, from 0.
        edge: u64,
        /// A number or a place.
        found: &'static str,
    },
    /// The file is damaged, or has what is not read of its format. The error is the format's own.
    #[error(transparent)]
    Damaged(Box<dyn std::error::Error + Send + Sync>),
    /// Temporary files.
    #[error(transparent)]
    Scratch(ScratchError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<ScratchError> for ReadError {
    fn from(error: ScratchError) -> ReadError {
        match error {
            ScratchError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            file => ReadError::Scratch(file),
        }
    }
}
