//! Finished tiles on disk: the unit of streaming.
//!
//! Tiles arrive as [`Chunk`]s in any order, from any thread, and are read back by their number. A chunk holds what its
//! tile owns and names what it borrows by (side, ordinal), so that [`Ids`] can number all vertices of the mesh from the
//! chunks' counts alone, without a table of seam vertices. What the spool keeps in memory does not grow with the number
//! of chunks: their places and counts are a file of fixed-size records.
//!
//! A spool is temporary ([`Spool::new`]), or kept in a folder from which a later run takes over what it finds sound
//! ([`Spool::kept`], [`Spool::find`]).

mod chunk;
mod chunks;
mod codec;
mod error;
mod folders;
#[cfg(any(test, feature = "fuzzing"))]
pub(crate) mod fuzzing;
mod ids;
mod index;
mod store;
mod unlinked;

pub use chunk::{Attribute, Chunk, ChunkCounts};
pub use chunks::Chunks;
pub use error::SpoolError;
pub use ids::Ids;
pub use store::Spool;

#[cfg(test)]
mod tests;
