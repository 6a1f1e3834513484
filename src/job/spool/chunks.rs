//! Where a pass reads the chunks that it needs.

use super::{Chunk, Spool, SpoolError};

/// Finished chunks by the number of their tile, wherever they are kept.
pub trait Chunks: Sync {
    /// How many tiles the grid has.
    fn tiles(&self) -> usize;

    /// Reads the chunk of a tile. `chunk` and `buffer` lend their memory.
    ///
    /// # Errors
    /// [`SpoolError`]: it is not there, or cannot be read, or is damaged.
    fn read(&self, tile: usize, chunk: &mut Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError>;
}

impl Chunks for Spool {
    fn tiles(&self) -> usize {
        Spool::tiles(self)
    }

    fn read(&self, tile: usize, chunk: &mut Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError> {
        Spool::read(self, tile, chunk, buffer)
    }
}
