//! Mapping files into memory: the only place with `unsafe`.

use std::ffi::CString;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

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
    // in time raises SIGBUS, see `exit_on_truncation`.
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

/// From now on, a mapped file that loses bytes while they are being read ends this process with exit code 1 and
/// `message` on standard error instead of a bare SIGBUS; `partial`, the unfinished output, is removed first. For
/// programs; a library leaves signals alone. May be called once per process.
///
/// # Errors
/// What the system says; a NUL byte in the path.
#[allow(unsafe_code)]
pub fn exit_on_truncation(message: &str, partial: &Path) -> io::Result<()> {
    let message = format!("{message}\n").into_bytes();
    let partial = CString::new(partial.as_os_str().as_bytes())?;
    let end = move || {
        // Nobody is left to be told that this failed.
        let _ = rustix::io::write(rustix::stdio::stderr(), &message);
        let _ = rustix::fs::unlink(partial.as_c_str());
        signal_hook::low_level::exit(1);
    };
    // SAFETY: the action makes three system calls that are safe in a signal handler (write, unlink, _exit), allocates
    // nothing, takes no lock and does not return.
    unsafe { signal_hook::low_level::register(signal_hook::consts::SIGBUS, end) }.map(|_| ())
}
