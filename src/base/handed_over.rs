//! Memory that stages hand over: what one has used is there for the next.
//!
//! A thread takes a tile through stages, and what most of them need is gone with the stage. Lists of ordinary tiles are
//! small and kept, so that nothing is taken from the system tile by tile; those of dense tiles are freed, so that a thread
//! never holds what two stages need.

use super::mesh::TileMesh;

/// Tiles of more triangles are dense: what a stage needs for one is freed when the stage is over. So a thread keeps less than
/// [`KEPT_BYTES`] from tile to tile. (Few are many in unit tests, so that small tiles are dense.)
pub(crate) const DENSE: usize = if cfg!(test) { 1 << 8 } else { 1 << 14 };

/// Encoded chunks of more bytes are those of dense tiles.
pub(crate) const DENSE_BYTES: usize = 24 * DENSE;

/// What all stages keep of ordinary tiles, at the most: for each triangle and half a vertex 56 bytes of an engine and its
/// mesh, 49 of polishing, 20 each of a chunk, its encoded form, and what puts it together.
pub(crate) const KEPT_BYTES: u64 = DENSE as u64 * KEPT_BYTES_PER_TRIANGLE;

/// The same for each triangle.
pub(crate) const KEPT_BYTES_PER_TRIANGLE: u64 = 56 + 49 + 3 * 20;

/// Samples of a tile up to which engines reserve memory for the densest mesh: pages that are not needed stay untouched, and
/// growing lists do not take twice what they hold.
pub(crate) const RESERVED_SAMPLES: usize = 1 << 22;

/// Empties a list. Its memory is kept unless it had more than `most` items.
pub(crate) fn clear<T>(list: &mut Vec<T>, most: usize) {
    if list.len() > most {
        *list = Vec::new();
    } else {
        list.clear();
    }
}

/// Makes a list of `len` items at most, without more room than for these: lists that grow by doubling take up to twice what
/// they hold.
pub(crate) fn make_room<T>(list: &mut Vec<T>, len: usize) {
    list.clear();
    list.reserve_exact(len);
}

impl TileMesh {
    /// Forgets the mesh, as [`TileMesh::clear`] does; its memory is kept if it was no dense one.
    pub(crate) fn hand_over(&mut self) {
        clear(&mut self.vertices, DENSE / 2);
        clear(&mut self.triangles, DENSE);
        self.relaxed = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_freed() {
        let mut list = vec![1u8; 100];
        clear(&mut list, 100);
        assert!(list.is_empty() && list.capacity() >= 100);
        list.resize(101, 1);
        clear(&mut list, 100);
        assert_eq!(list.capacity(), 0);
    }
}
