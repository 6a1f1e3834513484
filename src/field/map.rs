//! Mapping a file into memory: the crate's one `unsafe`.

use std::fs::File;
use std::io;

use memmap2::Mmap;

/// Maps a whole file read-only.
///
/// # Errors
/// What the system says.
#[allow(unsafe_code)]
pub(super) fn map(file: &File) -> io::Result<Mmap> {
    // SAFETY: the map is only ever read, as plain bytes for which any value is valid. A temporary file is unlinked and
    // ours alone. A raster mapped in place can be changed or truncated by another process while it is in use, which no
    // program can prevent; changed bytes give other heights, and a truncation stops the process (SIGBUS).
    unsafe { Mmap::map(file) }
}
