//! What is wrong with a UGRID file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why a UGRID file cannot be used. Every message names the file; bytes, faces and values are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UgridError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is an HDF5 file, as which NetCDF-4 is written.
    #[error(
        "{}: expected a classic NetCDF file, found HDF5, which is NetCDF-4 if anything; nccopy -k cdf5 OLD.nc NEW.nc makes a \
         classic one of it",
        path.display()
    )]
    Hdf5 {
        /// The mesh.
        path: PathBuf,
    },
    /// The head of the file does not say what it should.
    #[error("{}: byte {place}: expected {expected}, found {found}", path.display())]
    Head {
        /// The mesh.
        path: PathBuf,
        /// Where.
        place: u64,
        /// What would have been right.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// The head goes on and on.
    #[error("{}: expected a head of at most {limit} bytes, found a longer one", path.display())]
    HeadTooLong {
        /// The mesh.
        path: PathBuf,
        /// The most bytes that it may take.
        limit: u64,
    },
    /// The file ends too early.
    #[error("{}: expected {what} up to byte {expected}, found the end of the file at byte {found}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// What is not complete.
        what: String,
        /// Where it should end.
        expected: u64,
        /// Where the file ends.
        found: u64,
    },
    /// There is no mesh in it, or not all of one.
    #[error("{}: expected {expected}, found none", path.display())]
    Missing {
        /// The mesh.
        path: PathBuf,
        /// What was looked for.
        expected: String,
    },
    /// A variable is other than that of a mesh of triangles.
    #[error("{}: variable {variable:?}: expected {expected}, found {found}", path.display())]
    Variable {
        /// The mesh.
        path: PathBuf,
        /// The variable.
        variable: String,
        /// What would have been right.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A value is none that its variable has.
    #[error("{}: variable {variable:?}, value {index}: expected a whole number from 0 to 255, found {found}", path.display())]
    Byte {
        /// The mesh.
        path: PathBuf,
        /// The variable.
        variable: String,
        /// Which value.
        index: u64,
        /// The value.
        found: f64,
    },
    /// A face is not a triangle.
    #[error("{}: face {face}: expected a triangle, found {found} corners", path.display())]
    NotATriangle {
        /// The mesh.
        path: PathBuf,
        /// The face.
        face: u64,
        /// Its corners.
        found: usize,
    },
    /// A face names a node that is not there.
    #[error("{}: face {face}: expected nodes {start} to below {end}, found {found}", path.display())]
    VertexIndex {
        /// The mesh.
        path: PathBuf,
        /// The face.
        face: u64,
        /// The number of the first node.
        start: i128,
        /// The number after the last node's.
        end: i128,
        /// The number as it is.
        found: i128,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected {expected} bytes, as when it was opened, found {found}: the file is being changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
        /// How many there were.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<UgridError> for ReadError {
    fn from(error: UgridError) -> ReadError {
        match error {
            UgridError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            UgridError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
