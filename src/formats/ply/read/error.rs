//! What is wrong with a PLY file.

use std::path::PathBuf;

use super::ScalarType;
use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why a PLY file cannot be used. Every message names the file; elements are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlyError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A header line does not say what it should.
    #[error("{}: header line {line}: expected {expected}, found {found:?}", path.display())]
    Header {
        /// The mesh.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What would have been right.
        expected: &'static str,
        /// The line as it is, shortened.
        found: String,
    },
    /// No `end_header` within the bytes a header may take.
    #[error("{}: expected end_header within {limit} bytes", path.display())]
    HeaderTooLong {
        /// The mesh.
        path: PathBuf,
        /// The most bytes a header may take.
        limit: usize,
    },
    /// An element or one of its properties is not there.
    #[error("{}: expected {expected}, found none", path.display())]
    Missing {
        /// The mesh.
        path: PathBuf,
        /// What was looked for.
        expected: String,
    },
    /// The header promises more than the file has bytes for.
    #[error("{}: expected at most {at_most} of element {element:?} in a file of this length, found a count of {count}", path.display())]
    Count {
        /// The mesh.
        path: PathBuf,
        /// The element's name.
        element: String,
        /// What the header says.
        count: u64,
        /// What the file's length allows.
        at_most: u64,
    },
    /// The file ends too early.
    #[error("{}: expected {count} of element {element:?}, found the end of the file in number {index}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// The element's name.
        element: String,
        /// How many the header promises.
        count: u64,
        /// The one that is not complete, from 0.
        index: u64,
    },
    /// A file in text has not the end of its last line, of which its comments speak.
    #[error("{}: expected a line break at the end, found none: the end is missing", path.display())]
    Unended {
        /// The mesh.
        path: PathBuf,
    },
    /// An ascii value is not a number of its type.
    #[error("{}: {element} {index}, property {property:?}: expected {expected}, found {found:?}", path.display())]
    Number {
        /// The mesh.
        path: PathBuf,
        /// The element's name.
        element: String,
        /// Which one, from 0.
        index: u64,
        /// The property's name.
        property: String,
        /// The type it is declared as.
        expected: ScalarType,
        /// The text as it is, shortened.
        found: String,
    },
    /// A list says that it has a negative number of entries.
    #[error("{}: {element} {index}, property {property:?}: expected a list length, found {found}", path.display())]
    ListLength {
        /// The mesh.
        path: PathBuf,
        /// The element's name.
        element: String,
        /// Which one, from 0.
        index: u64,
        /// The property's name.
        property: String,
        /// The length as it is.
        found: i128,
    },
    /// A face is not a triangle.
    #[error("{}: face {face}: expected a triangle, found {found} corners", path.display())]
    NotATriangle {
        /// The mesh.
        path: PathBuf,
        /// The face, from 0.
        face: u64,
        /// Its corners.
        found: u64,
    },
    /// A face names a vertex that is not there.
    #[error("{}: face {face}: expected vertices 0 to below {vertices}, found {found}", path.display())]
    VertexIndex {
        /// The mesh.
        path: PathBuf,
        /// The face, from 0.
        face: u64,
        /// How many vertices there are.
        vertices: u64,
        /// The index as it is.
        found: i128,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PlyError> for ReadError {
    fn from(error: PlyError) -> ReadError {
        match error {
            PlyError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            PlyError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
