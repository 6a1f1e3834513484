//! What is wrong with an STL file.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::formats::ReadError;

/// Why an STL file cannot be used. Every message names the file; triangles are counted from 0, lines from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StlError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It ends within the header.
    #[error("{}: expected a header of 84 bytes, found {found} bytes", path.display())]
    TooShort {
        /// The mesh.
        path: PathBuf,
        /// How long it is.
        found: u64,
    },
    /// It is not as long as its count of triangles says.
    #[error("{}: expected {expected} bytes for {count} triangles, as many as bytes 80 to 83 say, found {found}", path.display())]
    Length {
        /// The mesh.
        path: PathBuf,
        /// How long it should be.
        expected: u64,
        /// What it says.
        count: u32,
        /// How long it is.
        found: u64,
    },
    /// The header of a file of terrabite's does not say what it should.
    #[error("{}: byte {offset}: expected {expected}, found {found}", path.display())]
    Header {
        /// The mesh.
        path: PathBuf,
        /// Where it should be.
        offset: u64,
        /// What would have been right.
        expected: &'static str,
        /// What is there.
        found: String,
    },
    /// A triangle of a solid is not where it should be.
    #[error("{}: byte {offset}, triangle {triangle}: expected {expected}, found {found:?}", path.display())]
    Misplaced {
        /// The mesh.
        path: PathBuf,
        /// Where it begins.
        offset: u64,
        /// Which one it is.
        triangle: u64,
        /// What would have been right.
        expected: String,
        /// Its corners.
        found: [[f32; 3]; 3],
    },
    /// A solid has an edge that is not as often there in the other direction.
    #[error(
        "{}: byte {offset}, triangle {triangle}: expected a closed solid, found the edge from {from:?} to {to:?} more often \
         than the one back",
        path.display()
    )]
    Open {
        /// The mesh.
        path: PathBuf,
        /// Where a triangle with this edge begins.
        offset: u64,
        /// Which one it is.
        triangle: u64,
        /// Where the edge starts.
        from: [f32; 3],
        /// Where it ends.
        to: [f32; 3],
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
    /// A text ends before its last solid does.
    #[error("{}: expected {expected}, found the end of the file after line {line}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// The last line.
        line: u64,
        /// What would have been right.
        expected: &'static str,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected the {faces} triangles that it had when it was opened, found others: the file is being changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
        /// How many there were.
        faces: u64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<StlError> for ReadError {
    fn from(error: StlError) -> ReadError {
        match error {
            StlError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            StlError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}
