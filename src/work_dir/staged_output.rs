//! Where the output of a run is staged, so that what a killed run leaves can be found.
//!
//! The note is a line, `staging` or `committing DEVICE INODE`, and the partial file's path as it is, whatever its bytes.
//! It is durable before the partial file is made, and again before it is renamed.

use std::ffi::OsStr;
use std::io::{self, ErrorKind};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::durable;

pub(super) const NAME: &str = "staged";

struct Note {
    partial: PathBuf,
    /// Device and inode, once the file is complete.
    complete: Option<(u64, u64)>,
}

pub(super) fn note_partial(dir: &Path, partial: &Path) -> io::Result<()> {
    Note { partial: std::path::absolute(partial)?, complete: None }.write(dir)
}

pub(super) fn note_commit(dir: &Path) -> io::Result<()> {
    let Some(note) = Note::read(dir)? else { return Ok(()) };
    let found = note.partial.metadata()?;
    Note { complete: Some((found.dev(), found.ino())), ..note }.write(dir)
}

/// Whether `output` is the file that was about to take its name: then it took it.
pub(super) fn has_committed(dir: &Path, output: &Path) -> bool {
    let complete = Note::read(dir).ok().flatten().and_then(|note| note.complete);
    complete.is_some() && output.metadata().ok().map(|found| (found.dev(), found.ino())) == complete
}

/// Removes the partial file of a run that was killed, if there is one. A file that has taken its name stays.
pub(super) fn remove_partial(dir: &Path) -> io::Result<()> {
    let Some(note) = Note::read(dir)? else { return Ok(()) };
    match note.partial.symlink_metadata() {
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(()),
        Err(e) => Err(e),
        Ok(found) if found.is_file() && is_partial(&note.partial) => {
            // Its inode may serve another file from now on.
            let note = Note { complete: None, ..note };
            note.write(dir)?;
            durable::remove_if_there(&note.partial)
        }
        Ok(_) => Ok(()),
    }
}

pub(super) fn forget(dir: &Path) -> io::Result<()> {
    durable::remove_if_there(&durable::partial_path(&dir.join(NAME)))?;
    durable::remove_if_there(&dir.join(NAME))
}

/// The note is text that anyone could have changed: only what a run itself names so is removed.
fn is_partial(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.as_bytes().starts_with(b".") && n.as_bytes().ends_with(b".partial"))
}

impl Note {
    fn write(&self, dir: &Path) -> io::Result<()> {
        let line = match self.complete {
            None => "staging\n".to_string(),
            Some((device, inode)) => format!("committing {device} {inode}\n"),
        };
        let mut bytes = line.into_bytes();
        bytes.extend_from_slice(self.partial.as_os_str().as_bytes());
        durable::replace(&dir.join(NAME), &bytes, || {})?;
        durable::sync_dir(dir)
    }

    /// `None` where there is no note, or none that makes sense.
    fn read(dir: &Path) -> io::Result<Option<Note>> {
        let bytes = match std::fs::read(dir.join(NAME)) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
            other => other?,
        };
        let Some(end) = bytes.iter().position(|&b| b == b'\n') else { return Ok(None) };
        let partial = PathBuf::from(OsStr::from_bytes(&bytes[end + 1..]));
        let line = String::from_utf8_lossy(&bytes[..end]);
        let complete = match line.split(' ').collect::<Vec<_>>().as_slice() {
            ["staging"] => None,
            ["committing", device, inode] => device.parse().ok().zip(inode.parse().ok()),
            _ => return Ok(None),
        };
        Ok(Some(Note { partial, complete }))
    }
}
