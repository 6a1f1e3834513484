use std::path::PathBuf;

use crate::base::staged::OutputError;

/// Why a mesh cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SinkError {
    /// The file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A height would change more by being written than was allowed for.
    #[error(
        "{}: expected heights that are written within {allowed} of what they are, found {height}, which would change by \
         {found}; --precision double, or another --z-scale, loses less",
        path.display()
    )]
    Lossy {
        /// The output.
        path: PathBuf,
        /// The height.
        height: f64,
        /// How much it may change.
        allowed: f64,
        /// How much it would.
        found: f64,
    },
    /// The format has no numbers for so many vertices.
    #[error(
        "{}: expected at most {limit} vertices, as many as {format} can number, found {found}; a larger --max-error \
         needs fewer",
        path.display()
    )]
    TooLarge {
        /// The output.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// The most vertices it takes.
        limit: u64,
        /// How many there are.
        found: u64,
    },
}
