use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use super::codec;
use super::{Chunk, ChunkCounts, SpoolError};
use crate::seam::RimCounts;

/// Chunks in an unlinked temporary file, found by tile number through a second one of fixed-size records.
///
/// Chunks are appended by any thread without a lock: each takes its place with one atomic addition. Memory: one encoded
/// chunk per call.
#[derive(Debug)]
pub struct Spool {
    dir: PathBuf,
    chunks: File,
    index: File,
    end: AtomicU64,
    tiles: usize,
}

/// Where a chunk lies, and its counts. On disk: offset, length, vertices, triangles, then the five rim counts.
const RECORD: usize = 4 * 8 + 5 * 4;

impl Spool {
    /// A spool for `tiles` chunks, in temporary files in `dir` that no one else sees and that vanish with it.
    ///
    /// # Errors
    /// [`SpoolError::File`].
    pub fn new(dir: &Path, tiles: usize) -> Result<Spool, SpoolError> {
        let failed = |source| SpoolError::File { dir: dir.to_path_buf(), source };
        let chunks = tempfile::tempfile_in(dir).map_err(failed)?;
        let index = tempfile::tempfile_in(dir).map_err(failed)?;
        index.set_len((tiles * RECORD) as u64).map_err(failed)?;
        Ok(Spool { dir: dir.to_path_buf(), chunks, index, end: AtomicU64::new(0), tiles })
    }

    /// How many chunks it is for.
    pub fn tiles(&self) -> usize {
        self.tiles
    }

    /// Bytes on disk.
    pub fn bytes(&self) -> u64 {
        self.end.load(Ordering::Relaxed) + (self.tiles * RECORD) as u64
    }

    /// Keeps a chunk under its tile's number. `buffer` is scratch memory.
    ///
    /// # Errors
    /// [`SpoolError::File`], [`SpoolError::TooLarge`].
    pub fn append(&self, chunk: &Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError> {
        for (what, count) in
            [("vertices", chunk.vertices.len() + chunk.foreign.len()), ("triangles", chunk.triangles.len())]
        {
            if u32::try_from(count).is_err() {
                return Err(SpoolError::TooLarge { tile: chunk.tile, what, count });
            }
        }
        buffer.clear();
        codec::encode(chunk, buffer);
        let offset = self.end.fetch_add(buffer.len() as u64, Ordering::Relaxed);
        self.chunks.write_all_at(buffer, offset).map_err(|e| self.failed(e))?;
        let counts = chunk.counts();
        let mut record = Vec::with_capacity(RECORD);
        for word in [offset, buffer.len() as u64, counts.vertices, counts.triangles] {
            record.extend_from_slice(&word.to_le_bytes());
        }
        let RimCounts { corners, north, west, east, south } = counts.rim;
        for count in [corners, north, west, east, south] {
            record.extend_from_slice(&count.to_le_bytes());
        }
        self.index.write_all_at(&record, (chunk.tile * RECORD) as u64).map_err(|e| self.failed(e))
    }

    /// The counts of a run of tiles that have all been appended.
    ///
    /// # Errors
    /// [`SpoolError::File`].
    pub fn counts(&self, tiles: std::ops::Range<usize>) -> Result<Vec<ChunkCounts>, SpoolError> {
        let mut bytes = vec![0; tiles.len() * RECORD];
        self.index.read_exact_at(&mut bytes, (tiles.start * RECORD) as u64).map_err(|e| self.failed(e))?;
        Ok(bytes.chunks_exact(RECORD).map(|r| Record::of(r).counts).collect())
    }

    /// Reads the chunk of a tile back. `chunk` and `buffer` lend their memory.
    ///
    /// # Errors
    /// [`SpoolError::File`]; [`SpoolError::Damaged`] if it is not what was appended.
    pub fn read(&self, tile: usize, chunk: &mut Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError> {
        let mut record = [0; RECORD];
        self.index.read_exact_at(&mut record, (tile * RECORD) as u64).map_err(|e| self.failed(e))?;
        let Record { offset, length, .. } = Record::of(&record);
        let damaged = |(expected, found)| SpoolError::Damaged { dir: self.dir.clone(), tile, expected, found };
        let kept = self.end.load(Ordering::Relaxed);
        if offset.checked_add(length).is_none_or(|end| end > kept) {
            return Err(damaged((format!("a chunk within {kept} bytes"), format!("{length} bytes at {offset}"))));
        }
        buffer.resize(length as usize, 0);
        self.chunks.read_exact_at(buffer, offset).map_err(|e| self.failed(e))?;
        codec::decode(buffer, chunk).map_err(damaged)?;
        if chunk.tile != tile {
            return Err(damaged((format!("tile {tile}"), format!("tile {}", chunk.tile))));
        }
        Ok(())
    }

    fn failed(&self, source: std::io::Error) -> SpoolError {
        SpoolError::File { dir: self.dir.clone(), source }
    }
}

struct Record {
    offset: u64,
    length: u64,
    counts: ChunkCounts,
}

impl Record {
    fn of(bytes: &[u8]) -> Record {
        let word = |i: usize| bytes[i * 8..][..8].iter().rev().fold(0u64, |w, &b| w << 8 | u64::from(b));
        let count = |i: usize| bytes[32 + i * 4..][..4].iter().rev().fold(0u32, |w, &b| w << 8 | u32::from(b));
        let rim = RimCounts { corners: count(0), north: count(1), west: count(2), east: count(3), south: count(4) };
        Record { offset: word(0), length: word(1), counts: ChunkCounts { rim, vertices: word(2), triangles: word(3) } }
    }
}
