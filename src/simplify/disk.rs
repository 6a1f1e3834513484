//! Whether the disks can hold a run, before it begins.

use std::path::{Path, PathBuf};

use crate::info::Estimate;

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
    pub what: &'static str,
    /// What it will take, about.
    pub needed_bytes: u64,
    /// What there is.
    pub free_bytes: u64,
}

/// Compares an estimate with the room on the disks of the temporary folder and of the output.
///
/// # Errors
/// [`DiskTooSmall`]. A system that does not tell its free space is trusted.
pub fn check_disk(estimate: &Estimate, temp_dir: &Path, output_folder: &Path) -> Result<(), DiskTooSmall> {
    let temporary = estimate.field_bytes + estimate.spool_bytes;
    let same = same_disk(temp_dir, output_folder);
    let (what, first) = match same {
        true => ("temporary files and the output", temporary + estimate.output_bytes),
        false => ("temporary files", temporary),
    };
    room(temp_dir, what, first)?;
    if same { Ok(()) } else { room(output_folder, "the output", estimate.output_bytes) }
}

fn room(folder: &Path, what: &'static str, needed_bytes: u64) -> Result<(), DiskTooSmall> {
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
