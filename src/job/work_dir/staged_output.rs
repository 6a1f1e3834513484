//! Where the output of a run, a file or a folder, is staged, so that what a killed run leaves can be found.
//!
//! The note is a line, `staging` or `committing FILE`, and the partial file's path as it is, whatever its bytes. FILE is
//! DEVICE-INODE-NANOSECONDS, the last being the time when the file was made, or 0 where the file system does not tell.
//! It is durable before the partial file is made, and again before it is renamed. A run that was killed after that is
//! done once more: its line ends with ` over FILE`, the output that is there already.

use std::ffi::OsStr;
use std::fs::Metadata;
use std::io::{self, ErrorKind};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use crate::base::durable;
use crate::base::private_file::PrivateFile;

pub(super) const NAME: &str = "staged";

/// A file, whatever its name. An inode may serve another file once its own is removed, so the time counts when it was made.
type Identity = String;

struct Note {
    partial: PathBuf,
    /// The partial file, once it is complete.
    complete: Option<Identity>,
    /// The output of an earlier run of the same job, which this one will replace.
    over: Option<Identity>,
}

pub(super) fn note_partial(dir: &Path, partial: &Path) -> io::Result<()> {
    // What was complete has taken its name by now: `remove_partial` forgets what has not.
    let over = Note::read(dir)?.and_then(|earlier| earlier.complete.or(earlier.over));
    Note { partial: std::path::absolute(partial)?, complete: None, over }.write(dir)
}

pub(super) fn note_commit(dir: &Path) -> io::Result<()> {
    let Some(note) = Note::read(dir)? else { return Ok(()) };
    let found = note.partial.metadata()?;
    Note { complete: Some(identity(&found)), ..note }.write(dir)
}

/// Whether `output` is the file that was about to take its name: then it took it. Or the one that it was to replace.
pub(super) fn has_committed(dir: &Path, output: &Path) -> bool {
    let (Ok(Some(note)), Ok(found)) = (Note::read(dir), output.metadata()) else { return false };
    [note.complete, note.over].contains(&Some(identity(&found)))
}

fn identity(file: &Metadata) -> Identity {
    let made = file.created().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
    format!("{}-{}-{}", file.dev(), file.ino(), made.map_or(0, |since| since.as_nanos()))
}

/// Removes the partial file, or folder, of a run that was killed, if there is one. What has taken its name stays; a folder may have
/// changed places with the one that it replaces, which is removed then.
pub(super) fn remove_partial(dir: &Path) -> io::Result<()> {
    let Some(note) = Note::read(dir)? else { return Ok(()) };
    match note.partial.symlink_metadata() {
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(()),
        Err(e) => Err(e),
        Ok(found) if (found.is_file() || found.is_dir()) && is_partial(&note.partial) => {
            // Nothing is complete once it is gone.
            let complete = note.complete.filter(|complete| *complete != identity(&found));
            let note = Note { complete, ..note };
            note.write(dir)?;
            match found.is_dir() {
                true => std::fs::remove_dir_all(&note.partial),
                false => durable::remove_if_there(&note.partial),
            }
        }
        Ok(_) => Ok(()),
    }
}

/// The note is text that anyone could have changed: only what a run itself names so is removed.
fn is_partial(path: &Path) -> bool {
    path.file_name().is_some_and(|n| n.as_bytes().starts_with(b".") && n.as_bytes().ends_with(b".partial"))
}

impl Note {
    fn write(&self, dir: &Path) -> io::Result<()> {
        let mut line = match &self.complete {
            None => "staging".to_string(),
            Some(file) => format!("committing {file}"),
        };
        if let Some(file) = &self.over {
            line += &format!(" over {file}");
        }
        line.push('\n');
        let mut bytes = line.into_bytes();
        bytes.extend_from_slice(self.partial.as_os_str().as_bytes());
        PrivateFile::create(&dir.join(NAME))?.commit(&bytes, || {})?;
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
        let words: Vec<&str> = line.split(' ').collect();
        let (words, over) = match words.as_slice() {
            [words @ .., "over", file] => (words, Some(file.to_string())),
            words => (words, None),
        };
        let complete = match words {
            ["staging"] => None,
            ["committing", file] => Some(file.to_string()),
            _ => return Ok(None),
        };
        Ok(Some(Note { partial, complete, over }))
    }
}
