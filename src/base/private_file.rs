//! Files that come to their names complete: written under a private name, synced, then renamed.

use std::ffi::{OsStr, OsString};
use std::fs::{File, OpenOptions};
use std::hash::{BuildHasher, RandomState};
use std::io::{self, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::durable::{NO_LINKS, remove_if_there};

/// A file that is not under its name yet, readable for its owner alone. Until [`PrivateFile::commit`] it has a name that no
/// other writer uses, on this machine or another; dropped before that, it is removed.
///
/// So any number of processes may write the same file at the same time: under its name there is one of them, whole, and
/// the last to come stays. A process that is killed leaves its private file behind ([`is_leftover`]).
#[derive(Debug)]
pub struct PrivateFile {
    file: File,
    private: PathBuf,
    path: PathBuf,
    committed: bool,
}

const END: &str = ".partial";

impl PrivateFile {
    /// Makes the file that is going to be `path`, in the same folder.
    ///
    /// # Errors
    /// What the system says; `NotFound` if there is no such folder.
    pub fn create(path: &Path) -> io::Result<PrivateFile> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let mut name = path.file_name().map(OsString::from).unwrap_or_default();
        name.push(format!(".{}-{}{END}", writer(), NEXT.fetch_add(1, Ordering::Relaxed)));
        let private = path.with_file_name(name);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create_new(true)
            .mode(0o600)
            .custom_flags(NO_LINKS)
            .open(&private)?;
        Ok(PrivateFile { file, private, path: path.to_path_buf(), committed: false })
    }

    /// Writes the whole content, makes it durable, and gives the file its name in one step: after a crash the file there is
    /// the old one or the new one. The name is durable when the folder is synced. `written` is called when the content is
    /// durable and the name is still to come.
    ///
    /// # Errors
    /// What the system says; nothing is left behind then.
    pub fn commit(mut self, content: &[u8], written: impl FnOnce()) -> io::Result<()> {
        self.file.write_all(content)?;
        self.commit_written(written)
    }

    /// The same of a file that has been written ([`PrivateFile::file`]).
    ///
    /// # Errors
    /// As [`PrivateFile::commit`].
    pub fn commit_written(self, written: impl FnOnce()) -> io::Result<()> {
        self.file.sync_all()?;
        self.rename(written)
    }

    /// Does what [`PrivateFile::commit`] does without waiting for the disk: after a power cut the file may be there with other
    /// bytes, or none, which its reader has to notice.
    ///
    /// # Errors
    /// As there.
    pub fn commit_unsynced(mut self, content: &[u8], written: impl FnOnce()) -> io::Result<()> {
        self.file.write_all(content)?;
        self.rename(written)
    }

    fn rename(mut self, written: impl FnOnce()) -> io::Result<()> {
        written();
        std::fs::rename(&self.private, &self.path)?;
        self.committed = true;
        Ok(())
    }

    /// The file, to be written at any place.
    pub fn file(&self) -> &File {
        &self.file
    }
}

impl Drop for PrivateFile {
    fn drop(&mut self) {
        if !self.committed {
            // Where even this fails, the file is a leftover.
            let _ = remove_if_there(&self.private);
        }
    }
}

/// Machine, process, and a number that no other process has: two machines may share a folder, and a name.
fn writer() -> &'static str {
    static WRITER: OnceLock<String> = OnceLock::new();
    WRITER.get_or_init(|| {
        let system = rustix::system::uname();
        let machine = system.nodename().to_string_lossy();
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let machine: String = machine.chars().take(40).map(plain).collect();
        format!("{machine}-{}-{:016x}", std::process::id(), RandomState::new().hash_one(0))
    })
}

/// Whether a file of this name in a folder is what a killed process has left of a [`PrivateFile`] for `path`'s name there.
pub fn is_leftover(found: &OsStr, path: &Path) -> bool {
    let Some(name) = path.file_name() else { return false };
    let rest = found.as_bytes().strip_prefix(name.as_bytes()).and_then(|rest| rest.strip_prefix(b"."));
    let Some(writer) = rest.and_then(|rest| rest.strip_suffix(END.as_bytes())) else { return false };
    // Number, random number, process; the machine may have hyphens.
    let parts: Vec<&[u8]> = writer.rsplitn(4, |&b| b == b'-').collect();
    let is_number = |part: &[u8]| !part.is_empty() && part.iter().all(u8::is_ascii_digit);
    match parts[..] {
        [number, random, process, _] => {
            is_number(number) && is_number(process) && random.len() == 16 && random.iter().all(u8::is_ascii_hexdigit)
        }
        _ => false,
    }
}

/// Removes what killed processes have left of a file. Nobody may be writing it.
///
/// # Errors
/// What the system says.
pub fn remove_leftovers(path: &Path) -> io::Result<()> {
    let dir = path.parent().unwrap_or(Path::new("."));
    for entry in dir.read_dir()? {
        let entry = entry?;
        if is_leftover(&entry.file_name(), path) {
            remove_if_there(&entry.path())?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(dir: &Path) -> Vec<OsString> {
        dir.read_dir().unwrap().map(|entry| entry.unwrap().file_name()).collect()
    }

    #[test]
    fn a_file_is_whole_or_not_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("7.chunk");
        let (first, second) = (PrivateFile::create(&path).unwrap(), PrivateFile::create(&path).unwrap());
        let found = names(folder.path());
        assert!(found.len() == 2 && found.iter().all(|name| is_leftover(name, &path)), "{found:?}");
        first.commit(b"one", || assert!(!path.exists())).unwrap();
        second.commit(b"two", || assert_eq!(std::fs::read(&path).unwrap(), b"one")).unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        drop(PrivateFile::create(&path).unwrap());
        assert_eq!(names(folder.path()), ["7.chunk"]);
    }

    #[test]
    fn leftovers_are_known_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("staged");
        std::mem::forget(PrivateFile::create(&path).unwrap());
        for name in [
            "staged",
            "staged.partial",
            "staged.a-1.partial",
            "other.a-1-0123456789abcdef-2.partial",
            "staged.a-1-0123456789abcdef-2",
        ] {
            assert!(!is_leftover(OsStr::new(name), &path), "{name}");
            std::fs::write(folder.path().join(name), "mine").unwrap();
        }
        assert_eq!(names(folder.path()).len(), 6);
        remove_leftovers(&path).unwrap();
        assert_eq!(names(folder.path()).len(), 5);
    }
}
