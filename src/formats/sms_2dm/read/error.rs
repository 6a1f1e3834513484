//! What is wrong with a 2DM file.

use std::path::PathBuf;

use crate::formats::{ReadError, TextError};

/// Why a 2DM file cannot be used. Every message names the file; lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Sms2dmError {
    /// What is wrong is wrong in any text format.
    #[error(transparent)]
    Text(#[from] TextError),
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
}

impl From<Sms2dmError> for ReadError {
    fn from(error: Sms2dmError) -> ReadError {
        match error {
            Sms2dmError::Text(error) => error.into(),
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
