//! Where chunks are, and what they count.

use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::Path;

use super::ChunkCounts;
use crate::kernel::seam::RimCounts;

/// Bytes of a record on disk: offset, length, vertices, triangles, then the five rim counts and the shared vertices.
const RECORD: usize = 4 * 8 + 6 * 4;

/// What has to be known of every chunk, in an unlinked temporary file of fixed-size records, one per tile.
///
/// Records are written by any thread without a lock. It holds nothing in memory.
#[derive(Debug)]
pub(super) struct Index {
    file: File,
    tiles: usize,
}

/// Where a chunk lies, and its counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Record {
    /// In the file of all chunks; 0 where each has its own.
    pub(super) offset: u64,
    /// Encoded bytes.
    pub(super) length: u64,
    pub(super) counts: ChunkCounts,
}

impl Index {
    pub(super) fn new(dir: &Path, tiles: usize) -> io::Result<Index> {
        let file = tempfile::tempfile_in(dir)?;
        file.set_len((tiles * RECORD) as u64)?;
        Ok(Index { file, tiles })
    }

    pub(super) fn tiles(&self) -> usize {
        self.tiles
    }

    /// Bytes on disk.
    pub(super) fn bytes(&self) -> u64 {
        (self.tiles * RECORD) as u64
    }

    pub(super) fn set(&self, tile: usize, record: &Record) -> io::Result<()> {
        self.file.write_all_at(&record.encode(), (tile * RECORD) as u64)
    }

    pub(super) fn get(&self, tile: usize) -> io::Result<Record> {
        let mut bytes = [0; RECORD];
        self.file.read_exact_at(&mut bytes, (tile * RECORD) as u64)?;
        Ok(Record::decode(&bytes))
    }

    pub(super) fn counts(&self, tiles: Range<usize>) -> io::Result<Vec<ChunkCounts>> {
        let mut bytes = vec![0; tiles.len() * RECORD];
        self.file.read_exact_at(&mut bytes, (tiles.start * RECORD) as u64)?;
        let (records, _) = bytes.as_chunks::<RECORD>();
        Ok(records.iter().map(|r| Record::decode(r).counts).collect())
    }
}

impl Record {
    fn encode(&self) -> [u8; RECORD] {
        let mut bytes = [0; RECORD];
        let words = [self.offset, self.length, self.counts.vertices, self.counts.triangles];
        bytes.as_chunks_mut::<8>().0.iter_mut().zip(words).for_each(|(b, w)| *b = w.to_le_bytes());
        let RimCounts { corners, north, west, east, south } = self.counts.rim;
        let rim = [corners, north, west, east, south, self.counts.shared];
        bytes[32..].as_chunks_mut::<4>().0.iter_mut().zip(rim).for_each(|(b, c)| *b = c.to_le_bytes());
        bytes
    }

    fn decode(bytes: &[u8; RECORD]) -> Record {
        let word = |i: usize| u64::from_le_bytes(bytes.as_chunks().0[i]);
        let count = |i: usize| u32::from_le_bytes(bytes[32..].as_chunks().0[i]);
        let rim = RimCounts { corners: count(0), north: count(1), west: count(2), east: count(3), south: count(4) };
        let counts = ChunkCounts { rim, shared: count(5), vertices: word(2), triangles: word(3) };
        Record { offset: word(0), length: word(1), counts }
    }
}
