//! Why finished tiles cannot be kept.

use std::path::PathBuf;

/// Why chunks cannot be kept or read back.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SpoolError {
    /// The temporary files cannot be made, written or read.
    #[error("{}: the temporary file of finished tiles failed: {source}", dir.display())]
    File {
        /// The folder of temporary files.
        dir: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A chunk that is kept, or the folder for them, cannot be made, written or read.
    #[error("{}: keeping finished tiles failed: {source}", path.display())]
    Kept {
        /// The chunk's file, or the folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// What was read back is not what was written.
    #[error("{}: the chunk of tile {tile} is damaged: expected {expected}, found {found}", dir.display())]
    Damaged {
        /// The folder of temporary files.
        dir: PathBuf,
        /// The tile's number.
        tile: usize,
        /// What it should be.
        expected: String,
        /// What it is.
        found: String,
    },
    /// More than 2³² vertices or 2³² triangles in one tile.
    #[error("tile {tile} has {count} {what}, more than a chunk can number")]
    TooLarge {
        /// The tile's number.
        tile: usize,
        /// What there is too much of.
        what: &'static str,
        /// How many.
        count: usize,
    },
}
