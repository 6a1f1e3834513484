//! The spool: chunks by the number of their tile.

use std::io::ErrorKind;
use std::ops::Range;
use std::path::{Path, PathBuf};

use super::folders::Folders;
use super::index::{Index, Record};
use super::unlinked::Unlinked;
use super::{Chunk, ChunkCounts, SpoolError, codec};
use crate::base::handed_over::make_room;

/// Chunks on disk, found by their tile's number: in unlinked temporary files, or in a folder that outlives the run.
///
/// Chunks are appended by any thread without a lock. Memory: one encoded chunk per call.
#[derive(Debug)]
pub struct Spool {
    dir: PathBuf,
    index: Index,
    chunks: Chunks,
}

#[derive(Debug)]
enum Chunks {
    Unlinked(Unlinked),
    Folders { folders: Folders, check_samples: bool },
}

impl Spool {
    /// A spool for `tiles` chunks, in temporary files in `dir` that no one else sees and that vanish with it.
    ///
    /// # Errors
    /// [`SpoolError::File`].
    pub fn new(dir: &Path, tiles: usize) -> Result<Spool, SpoolError> {
        let failed = |source| SpoolError::File { dir: dir.to_path_buf(), source };
        let chunks = Chunks::Unlinked(Unlinked::new(dir).map_err(failed)?);
        Ok(Spool { dir: dir.to_path_buf(), index: Index::new(dir, tiles).map_err(failed)?, chunks })
    }

    /// A spool for `tiles` chunks, rows of `columns`, that are kept in `dir` and may be there from an earlier run.
    ///
    /// `stamp` tells the jobs apart whose chunks may not be mixed. `check_samples`: the raster may have changed since,
    /// see [`Spool::check_samples`]. Other processes may keep chunks of the same job there at the same time.
    ///
    /// # Errors
    /// [`SpoolError::Kept`].
    pub fn kept(
        dir: &Path,
        columns: usize,
        tiles: usize,
        stamp: u32,
        check_samples: bool,
    ) -> Result<Spool, SpoolError> {
        let failed = |source| SpoolError::Kept { path: dir.to_path_buf(), source };
        let folders = Folders::new(dir, columns, tiles, stamp).map_err(failed)?;
        let index = Index::new(dir, tiles).map_err(failed)?;
        Ok(Spool { dir: dir.to_path_buf(), index, chunks: Chunks::Folders { folders, check_samples } })
    }

    /// How many chunks it is for.
    pub fn tiles(&self) -> usize {
        self.index.tiles()
    }

    /// Bytes on disk.
    pub fn bytes(&self) -> u64 {
        let chunks = match &self.chunks {
            Chunks::Unlinked(unlinked) => unlinked.bytes(),
            Chunks::Folders { folders, .. } => folders.bytes(),
        };
        chunks + self.index.bytes()
    }

    /// Whether its chunks outlive it.
    pub fn is_kept(&self) -> bool {
        matches!(self.chunks, Chunks::Folders { .. })
    }

    /// Whether a chunk that is found must be compared with the samples of its tile ([`Chunk::samples_checksum`]),
    /// because nothing else proves that they are those it was made from.
    pub fn check_samples(&self) -> bool {
        matches!(self.chunks, Chunks::Folders { check_samples: true, .. })
    }

    /// Looks for the chunk of a tile that an earlier run has kept, and takes it over. A chunk that is torn, or another
    /// tile's, or another job's, counts as missing: it is to be made and appended again.
    ///
    /// To be called at most once for a tile, and before it is appended.
    ///
    /// # Errors
    /// [`SpoolError::Kept`] when what is there cannot be read.
    pub fn find(&self, tile: usize, chunk: &mut Chunk, buffer: &mut Vec<u8>) -> Result<bool, SpoolError> {
        let Chunks::Folders { folders, .. } = &self.chunks else { return Ok(false) };
        let failed = |source| SpoolError::Kept { path: folders.path(tile), source };
        if folders.read(tile, buffer).map_err(failed)?.is_none() {
            return Ok(false);
        }
        let sound = codec::decode(buffer, chunk).is_ok()
            && chunk.tile == tile
            && chunk.before_borrowed() <= chunk.vertices.len()
            && chunk.pending as usize <= chunk.before_borrowed();
        if sound {
            let record = Record { offset: 0, length: buffer.len() as u64, counts: chunk.counts() };
            self.index.set(tile, &record).map_err(failed)?;
            folders.is_there(tile, buffer.len()).map_err(failed)?;
        }
        Ok(sound)
    }

    /// Whether the chunk of a tile is kept, without reading it: one that is damaged counts. Of a spool that is not kept,
    /// nothing.
    ///
    /// # Errors
    /// [`SpoolError::Kept`] when what is there cannot be read.
    pub fn holds(&self, tile: usize) -> Result<bool, SpoolError> {
        let Chunks::Folders { folders, .. } = &self.chunks else { return Ok(false) };
        folders.holds(tile).map_err(|source| SpoolError::Kept { path: folders.path(tile), source })
    }

    /// Keeps a chunk under its tile's number. `buffer` is scratch memory.
    ///
    /// # Errors
    /// [`SpoolError::File`], [`SpoolError::Kept`], [`SpoolError::TooLarge`].
    pub fn append(&self, chunk: &Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError> {
        for (what, count) in
            [("vertices", chunk.vertices.len() + chunk.borrows()), ("triangles", chunk.triangles.len())]
        {
            if u32::try_from(count).is_err() {
                return Err(SpoolError::TooLarge { tile: chunk.tile, what, count });
            }
        }
        buffer.clear();
        codec::encode(chunk, buffer);
        let length = buffer.len() as u64;
        let offset = match &self.chunks {
            Chunks::Unlinked(unlinked) => unlinked.append(buffer).map_err(|e| self.failed(e))?,
            Chunks::Folders { folders, .. } => {
                let failed = |source| SpoolError::Kept { path: folders.path(chunk.tile), source };
                folders.write(chunk.tile, buffer).map_err(failed)?;
                0
            }
        };
        self.index.set(chunk.tile, &Record { offset, length, counts: chunk.counts() }).map_err(|e| self.failed(e))
    }

    /// Makes the names of all chunks durable that were appended or found so far, where they are kept: a row of tiles that
    /// is not complete does not do so by itself.
    ///
    /// # Errors
    /// [`SpoolError::Kept`].
    pub fn sync(&self) -> Result<(), SpoolError> {
        match &self.chunks {
            Chunks::Unlinked(_) => Ok(()),
            Chunks::Folders { folders, .. } => folders.sync().map_err(|e| self.failed(e)),
        }
    }

    /// The counts of a run of tiles that have all been appended or found.
    ///
    /// # Errors
    /// [`SpoolError::File`], [`SpoolError::Kept`].
    pub fn counts(&self, tiles: Range<usize>) -> Result<Vec<ChunkCounts>, SpoolError> {
        self.index.counts(tiles).map_err(|e| self.failed(e))
    }

    /// Reads the chunk of a tile back, or one that is kept and was neither appended nor found here. `chunk` and `buffer` lend
    /// their memory.
    ///
    /// # Errors
    /// [`SpoolError::File`], [`SpoolError::Kept`]; [`SpoolError::Damaged`] if it is not what was appended.
    pub fn read(&self, tile: usize, chunk: &mut Chunk, buffer: &mut Vec<u8>) -> Result<(), SpoolError> {
        let damaged = |(expected, found)| SpoolError::Damaged { dir: self.dir.clone(), tile, expected, found };
        match &self.chunks {
            Chunks::Unlinked(unlinked) => {
                let Record { offset, length, .. } = self.index.get(tile).map_err(|e| self.failed(e))?;
                let kept = unlinked.bytes();
                if offset.checked_add(length).is_none_or(|end| end > kept) {
                    let found = format!("{length} bytes at {offset}");
                    return Err(damaged((format!("a chunk within {kept} bytes"), found)));
                }
                make_room(buffer, length as usize);
                buffer.resize(length as usize, 0);
                unlinked.read(offset, buffer).map_err(|e| self.failed(e))?;
            }
            Chunks::Folders { folders, .. } => {
                let failed = |source| SpoolError::Kept { path: folders.path(tile), source };
                let gone = || failed(ErrorKind::NotFound.into());
                folders.read(tile, buffer).map_err(failed)?.ok_or_else(gone)?;
            }
        }
        codec::decode(buffer, chunk).map_err(damaged)?;
        if chunk.tile != tile {
            return Err(damaged((format!("tile {tile}"), format!("tile {}", chunk.tile))));
        }
        Ok(())
    }

    fn failed(&self, source: std::io::Error) -> SpoolError {
        let dir = self.dir.clone();
        match self.chunks {
            Chunks::Unlinked(_) => SpoolError::File { dir, source },
            Chunks::Folders { .. } => SpoolError::Kept { path: dir, source },
        }
    }
}
