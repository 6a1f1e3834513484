//! Mapping files into memory: with `cli/signals`, `cli/heap` and `raster/cache` the only place with `unsafe`.

use std::fs::File;
use std::io;
use std::ops::Range;

use memmap2::{Mmap, UncheckedAdvice};

/// Maps a whole file read-only.
///
/// # Errors
/// What the system says.
#[allow(unsafe_code)]
pub(super) fn map(file: &File) -> io::Result<Mmap> {
    // SAFETY: the map is only ever read, as plain bytes for which any value is valid. A temporary file is unlinked and
    // ours alone. A raster mapped in place can be changed or truncated by another process while it is in use, which no
    // program can prevent; changed bytes give other heights, and a truncation that `Store::truncated` does not see
    // in time raises SIGBUS: so the file of a raster is mapped only where the caller says so
    // (`FieldOptions::maps_files`).
    unsafe { Mmap::map(file) }
}

/// Tells the system that these bytes of a map are not needed for now: their pages stop counting as resident, and come
/// back from the file, or from the page cache, if they are read again. Other threads may be reading them.
#[allow(unsafe_code)]
pub(super) fn give_back(map: &Mmap, bytes: Range<usize>) {
    // A system that does not take the advice only keeps the pages.
    // SAFETY: the map is a shared, read-only map of a file, so dropped pages are read back with the same contents.
    let _ = unsafe { map.unchecked_advise_range(UncheckedAdvice::DontNeed, bytes.start, bytes.len()) };
}
