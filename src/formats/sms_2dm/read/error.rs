//! What is wrong with a 2DM file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why a 2DM file cannot be used. Every message names the file; lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Sms2dmError {
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
    /// Nodes are not numbered one after the other.
    #[error("{}: line {line}: expected node {expected}, the number after the one before, found {found}", path.display())]
    NodeNumber {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// The number after that of the node before.
        expected: u64,
        /// The number as it is.
        found: u64,
    },
    /// An element is not a triangle.
    #[error("{}: line {line}: expected a triangle (E3T), found an element {found:?}", path.display())]
    NotATriangle {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What it is called.
        found: String,
    },
    /// An element names a node that is not there.
    #[error("{}: line {line}: expected nodes {first} to {last}, found {found}", path.display())]
    VertexIndex {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// The first node.
        first: u64,
        /// The last node.
        last: u64,
        /// The number as it is.
        found: u64,
    },
    /// There is no node in it.
    #[error("{}: expected nodes (lines that begin with ND), found none", path.display())]
    NoVertices {
        /// The mesh.
        path: PathBuf,
    },
    /// It has not as many nodes or elements as its second line says.
    #[error("{}: expected {expected} {what}, as the second line says, found {found}", path.display())]
    Count {
        /// The mesh.
        path: PathBuf,
        /// Nodes or elements.
        what: &'static str,
        /// What the second line says.
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
        /// Nodes or elements.
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

impl From<Sms2dmError> for ReadError {
    fn from(error: Sms2dmError) -> ReadError {
        match error {
            Sms2dmError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            Sms2dmError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
