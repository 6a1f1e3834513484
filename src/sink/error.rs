use std::path::PathBuf;

use crate::staged::OutputError;

/// Why a mesh cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SinkError {
    /// The file.
    #[error(transparent)]
    Output(#[from] OutputError),
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
