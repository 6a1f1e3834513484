//! What tiles tell of their insertions, on disk.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::kernel::triangulate::progressive::Key;

/// What every tile has told of its insertions, in unlinked temporary files: 56 bytes per insertion. Holds nothing in
/// memory; tiles tell from any thread, without a lock.
#[derive(Debug)]
pub(in crate::job) struct Curves {
    file: File,
    next: AtomicU64,
    /// Where a tile's record begins, and how many there are.
    index: File,
    tiles: usize,
}

/// What an insertion adds to the whole mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::job) struct Cost {
    pub(in crate::job) points: u64,
    pub(in crate::job) triangles: u64,
}

/// An insertion as it was told, or all that is there from the start. A vertex of a seam is told by both tiles; it costs
/// where it is owned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::job) struct Told {
    pub(in crate::job) key: Key,
    pub(in crate::job) cost: Cost,
    /// The change of the sum of squared errors.
    pub(in crate::job) squares: f64,
}

const RECORD: usize = 56;

/// Records written and read at a time.
const BATCH: usize = 4096;

impl Curves {
    /// What an insertion takes on disk.
    pub(in crate::job) const BYTES: u64 = RECORD as u64;

    pub(in crate::job) fn new(dir: &Path, tiles: usize) -> io::Result<Curves> {
        let index = tempfile::tempfile_in(dir)?;
        index.set_len(tiles as u64 * 16)?;
        Ok(Curves { file: tempfile::tempfile_in(dir)?, next: AtomicU64::new(0), index, tiles })
    }

    /// Bytes on disk.
    pub(in crate::job) fn bytes(&self) -> u64 {
        self.next.load(Ordering::Relaxed) + self.tiles as u64 * 16
    }

    /// Keeps what a tile tells, in the order of its keys. `buffer` is scratch memory, 56 bytes for each of [`BATCH`] records.
    pub(in crate::job) fn tell(&self, tile: usize, told: &[Told], buffer: &mut Vec<u8>) -> io::Result<()> {
        let offset = self.next.fetch_add((told.len() * RECORD) as u64, Ordering::Relaxed);
        for (told, offset) in told.chunks(BATCH).zip((offset..).step_by(BATCH * RECORD)) {
            buffer.clear();
            for t in told {
                let [rank, interior, owner, ordinal] = t.key.words();
                let Cost { points, triangles } = t.cost;
                for word in [rank, interior, owner, ordinal, points, triangles, t.squares.to_bits()] {
                    buffer.extend_from_slice(&word.to_le_bytes());
                }
            }
            self.file.write_all_at(buffer, offset)?;
        }
        let mut entry = [0; 16];
        entry[..8].copy_from_slice(&offset.to_le_bytes());
        entry[8..].copy_from_slice(&(told.len() as u64).to_le_bytes());
        self.index.write_all_at(&entry, tile as u64 * 16)
    }

    /// Visits all that was told, tile by tile, each tile's in the order of its keys, until `visit` says that it is enough.
    pub(in crate::job) fn for_each(&self, mut visit: impl FnMut(&Told) -> bool) -> io::Result<()> {
        let mut buffer = vec![0; BATCH * RECORD];
        for tile in 0..self.tiles {
            let mut entry = [0; 16];
            self.index.read_exact_at(&mut entry, tile as u64 * 16)?;
            let [mut offset, mut left] = [word(&entry, 0), word(&entry, 1)];
            while left > 0 {
                let count = left.min(BATCH as u64);
                let bytes = &mut buffer[..count as usize * RECORD];
                self.file.read_exact_at(bytes, offset)?;
                if !bytes.chunks_exact(RECORD).all(|record| visit(&decode(record))) {
                    return Ok(());
                }
                offset += count * RECORD as u64;
                left -= count;
            }
        }
        Ok(())
    }
}

fn word(bytes: &[u8], i: usize) -> u64 {
    bytes[8 * i..8 * i + 8].iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte))
}

fn decode(record: &[u8]) -> Told {
    let at = |i| word(record, i);
    Told {
        key: Key::from_words([at(0), at(1), at(2), at(3)]),
        cost: Cost { points: at(4), triangles: at(5) },
        squares: f64::from_bits(at(6)),
    }
}
