//! What several tests need and only one of them makes.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// A folder in `parent` that is made once and kept. Threads and processes that ask at the same time wait for the first.
///
/// `content` names what is in it. A folder that was made for other content, that is not `usable`, or whose making was
/// cut off, is made anew. `make` gets a path at which nothing is.
pub(crate) fn made_once(
    parent: &Path,
    name: &str,
    content: &str,
    usable: impl FnOnce(&Path) -> bool,
    make: impl FnOnce(&Path),
) -> PathBuf {
    fs::create_dir_all(parent).unwrap();
    let (folder, stamp) = (parent.join(name), parent.join(format!("{name}.content")));
    // The lock belongs to the open file: it ends with it, also when `make` panics or the process is killed.
    let lock = File::create(parent.join(format!("{name}.lock"))).unwrap();
    lock.lock().unwrap();
    if fs::read_to_string(&stamp).is_ok_and(|found| found == content) && usable(&folder) {
        return folder;
    }
    // The stamp goes first and comes last.
    for gone in [fs::remove_file(&stamp), fs::remove_dir_all(&folder)] {
        assert!(!gone.is_err_and(|e| e.kind() != std::io::ErrorKind::NotFound), "{} is in the way", folder.display());
    }
    make(&folder);
    fs::write(stamp, content).unwrap();
    folder
}
