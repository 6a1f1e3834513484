//! What is wrong with a LandXML file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why a LandXML file cannot be used. Every message names the file; bytes are counted from 0.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LandXmlError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is no XML.
    #[error("{}: byte {offset}: expected XML, found an error: {message}", path.display())]
    Xml {
        /// The mesh.
        path: PathBuf,
        /// Where it is wrong.
        offset: u64,
        /// What the parser said.
        message: String,
    },
    /// An element, or what it says, is not what it should be.
    #[error("{}: byte {offset}: expected {expected}, found {found:?}", path.display())]
    Element {
        /// The mesh.
        path: PathBuf,
        /// Where it ends.
        offset: u64,
        /// What would have been right.
        expected: &'static str,
        /// What is there, shortened.
        found: String,
    },
    /// A tag or a text is longer than any of a mesh, or elements are nested deeper.
    #[error("{}: byte {offset}: expected at most {limit} {what}, found more", path.display())]
    TooMuch {
        /// The mesh.
        path: PathBuf,
        /// Where it is too much.
        offset: u64,
        /// What there is too much of.
        what: &'static str,
        /// The most there may be.
        limit: usize,
    },
    /// The end of the root element is missing.
    #[error("{}: expected {expected}, found the end of the file", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// What should be there.
        expected: &'static str,
    },
    /// There are other surfaces than one.
    #[error("{}: expected one surface of type TIN, found {found}", path.display())]
    Surfaces {
        /// The mesh.
        path: PathBuf,
        /// What there is.
        found: String,
    },
    /// A face names a point that is not there.
    #[error("{}: face {face}: expected ids of points, found {found}", path.display())]
    PointId {
        /// The mesh.
        path: PathBuf,
        /// The face, from 0, invisible ones not counted.
        face: u64,
        /// The id.
        found: u64,
    },
    /// Two points have the same id.
    #[error("{}: point {point}: expected an id of its own, found that of point {other}", path.display())]
    RepeatedId {
        /// The mesh.
        path: PathBuf,
        /// The point, from 0.
        point: u64,
        /// The one before it that has the same id.
        other: u64,
    },
    /// It has not as many points or faces as it says.
    #[error("{}: expected {expected} {what}, as the property of this name says, found {found}", path.display())]
    Count {
        /// The mesh.
        path: PathBuf,
        /// Vertices, triangles or edges.
        what: &'static str,
        /// What it says.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected {expected} {what}, as when it was opened, found {found}: the file is being changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
        /// Points, faces, breaklines or bytes.
        what: &'static str,
        /// How many there were.
        expected: u64,
        /// How many there are; more than expected are not counted to the end.
        found: u64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<LandXmlError> for ReadError {
    fn from(error: LandXmlError) -> ReadError {
        match error {
            LandXmlError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            LandXmlError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
