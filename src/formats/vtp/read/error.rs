//! What is wrong with a VTP file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why a VTP file cannot be used. Every message names the file; bytes, faces and values are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VtpError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The XML does not say what it should.
    #[error("{}: byte {place}: expected {expected}, found {found}", path.display())]
    Xml {
        /// The mesh.
        path: PathBuf,
        /// Where.
        place: u64,
        /// What would have been right.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// Something that a mesh has is not there.
    #[error("{}: expected {expected}, found none", path.display())]
    Missing {
        /// The mesh.
        path: PathBuf,
        /// What was looked for.
        expected: String,
    },
    /// The file does not end where its XML does.
    #[error("{}: expected </VTKFile> at the end, at byte {length}, found none: the file has been cut off", path.display())]
    CutOff {
        /// The mesh.
        path: PathBuf,
        /// The file's length.
        length: u64,
    },
    /// Arrays are compressed.
    #[error(
        "{}: expected arrays that are not compressed, found {compressor}; write the file again with no compressor \
         (in VTK: SetCompressorTypeToNone)",
        path.display()
    )]
    Compressed {
        /// The mesh.
        path: PathBuf,
        /// What they are compressed with.
        compressor: String,
    },
    /// An array is other than that of a mesh of triangles.
    #[error("{}: array {array:?}: expected {expected}, found {found}", path.display())]
    Array {
        /// The mesh.
        path: PathBuf,
        /// The array.
        array: String,
        /// What would have been right.
        expected: String,
        /// What it is.
        found: String,
    },
    /// An array ends too early, or has what is no number.
    #[error("{}: array {array:?}, value {index}: expected {expected}, found {found}", path.display())]
    Value {
        /// The mesh.
        path: PathBuf,
        /// The array.
        array: String,
        /// Which value.
        index: u64,
        /// What would have been right.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// A face is not a triangle.
    #[error("{}: face {face}: expected a triangle, found {found} corners", path.display())]
    NotATriangle {
        /// The mesh.
        path: PathBuf,
        /// The face.
        face: u64,
        /// Its corners.
        found: i128,
    },
    /// A face names a point that is not there.
    #[error("{}: face {face}: expected points 0 to below {points}, found {found}", path.display())]
    VertexIndex {
        /// The mesh.
        path: PathBuf,
        /// The face.
        face: u64,
        /// How many points there are.
        points: u64,
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

impl From<VtpError> for ReadError {
    fn from(error: VtpError) -> ReadError {
        match error {
            VtpError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            VtpError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
