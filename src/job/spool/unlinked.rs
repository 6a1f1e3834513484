//! Chunks in one temporary file that nobody else sees.

use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Chunks one after the other in an unlinked temporary file: it vanishes with the process, however that ends.
///
/// Each thread takes the place of its chunk with one atomic addition; there is no lock.
#[derive(Debug)]
pub(super) struct Unlinked {
    file: File,
    end: AtomicU64,
}

impl Unlinked {
    pub(super) fn new(dir: &Path) -> io::Result<Unlinked> {
        Ok(Unlinked { file: tempfile::tempfile_in(dir)?, end: AtomicU64::new(0) })
    }

    /// Bytes on disk.
    pub(super) fn bytes(&self) -> u64 {
        self.end.load(Ordering::Relaxed)
    }

    /// Returns where the bytes were put.
    pub(super) fn append(&self, bytes: &[u8]) -> io::Result<u64> {
        let offset = self.end.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        self.file.write_all_at(bytes, offset)?;
        Ok(offset)
    }

    pub(super) fn read(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        self.file.read_exact_at(bytes, offset)
    }
}
