//! What is wrong with an OBJ file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why an OBJ file cannot be used. Every message names the file; lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line does not say what it should.
    #[error("{}: line {line}: expected {expected}, found {found:?}", path.display())]
    Line {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What would have been right.
        expected: &'static str,
        /// The line as it is, shortened.
        found: String,
    },
    /// A line is longer than any line of a mesh.
    #[error("{}: line {line}: expected at most {limit} bytes, found more", path.display())]
    LineTooLong {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// The most bytes it may take.
        limit: usize,
    },
    /// A face is not a triangle.
    #[error("{}: line {line}: expected a triangle, found {found} corners", path.display())]
    NotATriangle {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// Its corners.
        found: u64,
    },
    /// A face names a vertex that is not there.
    #[error(
        "{}: line {line}: expected vertices 1 to {vertices}, or -1 to -{before} counted back, found {found}",
        path.display()
    )]
    VertexIndex {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// How many vertices there are.
        vertices: u64,
        /// How many there are before this line.
        before: u64,
        /// The number as it is.
        found: i64,
    },
    /// There is no vertex in it.
    #[error("{}: expected vertices (lines that begin with v), found none", path.display())]
    NoVertices {
        /// The mesh.
        path: PathBuf,
    },
    /// It has not as many vertices or faces as its first line says.
    #[error("{}: expected {expected} {what}, as the first line says, found {found}", path.display())]
    Count {
        /// The mesh.
        path: PathBuf,
        /// Vertices or triangles.
        what: &'static str,
        /// What the first line says.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// Its last line is missing.
    #[error("{}: expected the line {expected:?} at the end, found the end of the file after line {line}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// The line that should be there.
        expected: &'static str,
        /// The last line.
        line: u64,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected {expected} {what}, as when it was opened, found {found}: the file is being changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
        /// Vertices or faces.
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

impl From<ObjError> for ReadError {
    fn from(error: ObjError) -> ReadError {
        match error {
            ObjError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            ObjError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
