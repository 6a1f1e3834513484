//! Whether the disks can hold a run, before it begins.

use std::path::{Path, PathBuf};

/// A disk has too little room.
#[derive(Debug, thiserror::Error)]
#[error(
    "{}: expected {needed_bytes} bytes free for {what} (an estimate from a few tiles), found {free_bytes}",
    folder.display()
)]
pub struct DiskTooSmall {
    /// A folder on the disk.
    pub folder: PathBuf,
    /// What is to be put there.
    pub what: String,
    /// What it will take, about.
    pub needed_bytes: u64,
    /// What there is.
    pub free_bytes: u64,
}

/// Something that will take room.
#[derive(Debug, Clone, Copy)]
pub struct DiskUse<'a> {
    /// What it is called.
    pub what: &'a str,
    /// The folder it will be in.
    pub folder: &'a Path,
    /// How large it will be, about.
    pub bytes: u64,
}

/// Compares what a run will take with the room on the disks, adding up what comes to lie on one.
///
/// # Errors
/// [`DiskTooSmall`]. A system that does not tell its free space is trusted.
pub fn check_disk(uses: &[DiskUse<'_>]) -> Result<(), DiskTooSmall> {
    for (i, first) in uses.iter().enumerate() {
        let on_this_disk = |u: &&DiskUse<'_>| same_disk(u.folder, first.folder);
        if uses[..i].iter().any(|u| on_this_disk(&u)) {
            continue;
        }
        let here: Vec<&DiskUse<'_>> = uses.iter().filter(|u| u.bytes > 0).filter(on_this_disk).collect();
        let what = here.iter().map(|u| u.what).collect::<Vec<_>>().join(", ");
        room(first.folder, what, here.iter().fold(0, |sum: u64, u| sum.saturating_add(u.bytes)))?;
    }
    Ok(())
}

fn room(folder: &Path, what: String, needed_bytes: u64) -> Result<(), DiskTooSmall> {
    let Ok(disk) = rustix::fs::statvfs(folder) else { return Ok(()) };
    let free_bytes = disk.f_bavail.saturating_mul(disk.f_frsize);
    if needed_bytes <= free_bytes {
        return Ok(());
    }
    Err(DiskTooSmall { folder: folder.to_path_buf(), what, needed_bytes, free_bytes })
}

fn same_disk(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (a.metadata(), b.metadata()) {
        (Ok(a), Ok(b)) => a.dev() == b.dev(),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_to_lie_on_one_disk_is_added_up() {
        let folder = tempfile::tempdir().unwrap();
        let there = |what, bytes| DiskUse { what, folder: folder.path(), bytes };
        check_disk(&[there("tiles", 1), there("output", 1)]).unwrap();
        let refused = check_disk(&[there("tiles", 1 << 62), there("samples", 0), there("output", 7)]).unwrap_err();
        assert_eq!((refused.what.as_str(), refused.needed_bytes), ("tiles, output", (1 << 62) + 7));
    }
}
