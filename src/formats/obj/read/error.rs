//! What is wrong with an OBJ file.

use std::path::PathBuf;

use crate::formats::{ReadError, TextError};

/// Why an OBJ file cannot be used. Every message names the file; lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ObjError {
    /// What is wrong is wrong in any text format.
    #[error(transparent)]
    Text(#[from] TextError),
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
}

impl From<ObjError> for ReadError {
    fn from(error: ObjError) -> ReadError {
        match error {
            ObjError::Text(error) => error.into(),
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
