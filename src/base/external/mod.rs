//! More records than memory holds: temporary files without a name, external sorting, queues, lists. For those who read and judge
//! written meshes, and for lines; whoever makes meshes has chunks.

mod scratch;
mod shelves;
mod sort;
mod store;

use std::path::PathBuf;

pub(crate) use scratch::{Queue, Scratch};
pub(crate) use shelves::Shelves;
pub(crate) use sort::{Sorted, Sorter};
pub(crate) use store::{Store, StoreWriter};

use super::control::Cancelled;

/// Why temporary files are of no use.
#[derive(Debug, thiserror::Error)]
pub enum ScratchError {
    /// One cannot be made, written or read back.
    #[error("temporary files in {}: {source}", dir.display())]
    File {
        /// Where they are.
        dir: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
