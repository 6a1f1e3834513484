//! Files and folders that are private, and that are still there after a power cut.

use std::fs::{DirBuilder, File, Permissions};
use std::io::{self, ErrorKind};
use std::os::unix::fs::{DirBuilderExt, PermissionsExt};
use std::path::Path;

/// For files in folders where others may have put links.
pub const NO_LINKS: i32 = rustix::fs::OFlags::NOFOLLOW.bits() as i32;

/// Makes a folder that only its owner may look into.
///
/// # Errors
/// What the system says; `AlreadyExists` if there is something of that name.
pub fn create_private_dir(path: &Path) -> io::Result<()> {
    DirBuilder::new().mode(0o700).create(path)
}

/// The sticky bit, which does nothing in a private folder: it says that the folder was made here, by a process that has not
/// come to note so in it. It is set in the step that makes the folder, so that no kill comes between.
const MARKED: u32 = 0o1700;

/// Does what [`create_private_dir`] does, and marks the folder, see [`is_marked`].
///
/// # Errors
/// As there.
pub fn create_marked_dir(path: &Path) -> io::Result<()> {
    DirBuilder::new().mode(MARKED).create(path)
}

/// Whether a folder was made by [`create_marked_dir`], and is still marked.
pub fn is_marked(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|m| m.is_dir() && m.permissions().mode() & 0o7777 == MARKED)
}

/// Marks a private folder, or takes the mark away.
///
/// # Errors
/// What the system says.
pub fn mark(path: &Path, marked: bool) -> io::Result<()> {
    std::fs::set_permissions(path, Permissions::from_mode(if marked { MARKED } else { 0o700 }))
}

/// Makes the names in a folder durable: what was made, renamed or removed there stays so.
///
/// # Errors
/// What the system says.
pub fn sync_dir(dir: &Path) -> io::Result<()> {
    match File::open(dir)?.sync_all() {
        // Some network file systems cannot sync a folder; the files themselves are synced.
        Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        other => other,
    }
}

/// Removes a file that may not be there.
///
/// # Errors
/// What the system says.
pub fn remove_if_there(path: &Path) -> io::Result<()> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    }
}
