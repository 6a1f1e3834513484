//! Chunks as files in folders, one folder per row of tiles.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use crate::base::durable;
use crate::base::faults::{self, Point};
use crate::base::private_file::PrivateFile;

/// Chunks as files that outlive the process: `ROW/COLUMN.chunk`, one folder per row of tiles.
///
/// A chunk is written under a private name, synced, and then renamed ([`PrivateFile`]): under its name there is never a
/// part of one, unless the disk lies; the checksum finds that. Several processes may bring the same chunk: its bytes are
/// the same, so it does not matter whose stays. A row's folder is synced by the thread that brings its last chunk, or by
/// [`Folders::sync`]. A power cut before that may forget the names of some chunks of rows in work, and those tiles are made
/// again; syncing after every chunk would double the waiting for nothing but their time. What a killed run has left of
/// chunks, one per thread, goes with the folder.
///
/// There is no lock. Memory: one counter per row.
#[derive(Debug)]
pub(super) struct Folders {
    dir: PathBuf,
    columns: usize,
    /// The end of every chunk file: says which job it belongs to.
    stamp: [u8; 4],
    /// Chunks still to come, by row.
    missing: Vec<AtomicUsize>,
    bytes: AtomicU64,
}

impl Folders {
    /// Chunks of rows of `columns` tiles in `dir`, which is made if it is missing.
    pub(super) fn new(dir: &Path, columns: usize, tiles: usize, stamp: u32) -> io::Result<Folders> {
        match durable::create_private_dir(dir) {
            Err(e) if e.kind() != ErrorKind::AlreadyExists => return Err(e),
            Err(_) => {}
            Ok(()) => durable::sync_dir(dir.parent().unwrap_or(Path::new(".")))?,
        }
        let missing = (0..tiles / columns).map(|_| AtomicUsize::new(columns)).collect();
        Ok(Folders { dir: dir.to_path_buf(), columns, stamp: stamp.to_le_bytes(), missing, bytes: AtomicU64::new(0) })
    }

    /// Bytes on disk.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Where the chunk of a tile is.
    pub(super) fn path(&self, tile: usize) -> PathBuf {
        self.row(tile).join(format!("{}.chunk", tile % self.columns))
    }

    fn row(&self, tile: usize) -> PathBuf {
        self.dir.join((tile / self.columns).to_string())
    }

    /// Keeps the bytes of a chunk (and adds the stamp to them).
    pub(super) fn write(&self, tile: usize, bytes: &mut Vec<u8>) -> io::Result<()> {
        bytes.extend_from_slice(&self.stamp);
        let path = self.path(tile);
        let file = match PrivateFile::create(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => {
                self.make_row(tile)?;
                PrivateFile::create(&path)
            }
            other => other,
        }?;
        file.commit(bytes, || faults::reach(Point::ChunkWritten))?;
        faults::reach(Point::ChunkRenamed);
        self.is_there(tile, bytes.len())
    }

    /// Another thread may have made it meanwhile.
    fn make_row(&self, tile: usize) -> io::Result<()> {
        match durable::create_private_dir(&self.row(tile)) {
            Err(e) if e.kind() == ErrorKind::AlreadyExists => Ok(()),
            Err(e) => Err(e),
            Ok(()) => durable::sync_dir(&self.dir),
        }
    }

    /// Counts a chunk that is in its place; the last of a row makes the row's names durable.
    pub(super) fn is_there(&self, tile: usize, bytes: usize) -> io::Result<()> {
        self.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
        if self.missing[tile / self.columns].fetch_sub(1, Ordering::Relaxed) == 1 {
            durable::sync_dir(&self.row(tile))?;
        }
        Ok(())
    }

    /// Makes the names of chunks in rows durable that have some, but not all.
    pub(super) fn sync(&self) -> io::Result<()> {
        for (row, missing) in self.missing.iter().enumerate() {
            if (1..self.columns).contains(&missing.load(Ordering::Relaxed)) {
                durable::sync_dir(&self.row(row * self.columns))?;
            }
        }
        Ok(())
    }

    /// Whether there is a chunk of this job under a tile's name; a look at the end of the file.
    pub(super) fn holds(&self, tile: usize) -> io::Result<bool> {
        let mut file = match File::open(self.path(tile)) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(false),
            other => other?,
        };
        if file.metadata()?.len() < self.stamp.len() as u64 {
            return Ok(false);
        }
        let mut end = [0; 4];
        file.seek(SeekFrom::End(-(end.len() as i64)))?;
        file.read_exact(&mut end)?;
        Ok(end == self.stamp)
    }

    /// Reads the bytes of a chunk, without the stamp. `None`: there is none, or it belongs to another job.
    pub(super) fn read(&self, tile: usize, bytes: &mut Vec<u8>) -> io::Result<Option<()>> {
        bytes.clear();
        match File::open(self.path(tile)) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            other => other?.read_to_end(bytes)?,
        };
        if !bytes.ends_with(&self.stamp) {
            return Ok(None);
        }
        bytes.truncate(bytes.len() - self.stamp.len());
        Ok(Some(()))
    }
}
