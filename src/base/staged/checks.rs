//! What can be known to be wrong with an output's path before anything is written.

use std::ffi::OsStr;
use std::fs::{FileType, Metadata};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::OutputError;

pub(super) fn file_name(path: &Path) -> Result<&OsStr, OutputError> {
    path.file_name().ok_or_else(|| OutputError::NoName { path: path.to_path_buf() })
}

/// What is at the path: a plain file, or a link to nowhere (which may be replaced like a file), or nothing.
pub(super) fn existing(path: &Path) -> Result<Option<Metadata>, OutputError> {
    let found = match path.metadata() {
        Err(e) if e.kind() == ErrorKind::NotFound => path.symlink_metadata(),
        other => other,
    };
    match found {
        Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        Err(source) => Err(OutputError::Look { path: path.to_path_buf(), source }),
        Ok(m) if m.is_file() || m.is_symlink() => Ok(Some(m)),
        Ok(m) => Err(OutputError::NotAFile { path: path.to_path_buf(), found: kind(m.file_type()) }),
    }
}

fn kind(file_type: FileType) -> &'static str {
    if file_type.is_dir() { "a folder" } else { "a device or a pipe" }
}

/// Refuses to replace what is being read, also through links of either kind.
pub(super) fn is_no_input(path: &Path, existing: &Metadata, inputs: &[&Path]) -> Result<(), OutputError> {
    for input in inputs {
        let same_path = matches!((path.canonicalize(), input.canonicalize()), (Ok(a), Ok(b)) if a == b);
        if same_path || input.metadata().is_ok_and(|m| same_inode(existing, &m)) {
            return Err(OutputError::IsInput { path: path.to_path_buf(), input: input.to_path_buf() });
        }
    }
    Ok(())
}

#[cfg(unix)]
fn same_inode(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}
#[cfg(not(unix))]
fn same_inode(_: &Metadata, _: &Metadata) -> bool {
    false
}

/// The path to rename to: what an existing link points at, so that the link stays a link.
pub(super) fn target(path: &Path, exists: bool) -> PathBuf {
    if !exists {
        return path.to_path_buf();
    }
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// The folder of `target`, which must exist; `path` is what the user calls the output.
pub(super) fn folder(path: &Path, target: &Path) -> Result<PathBuf, OutputError> {
    let folder = parent(target).to_path_buf();
    let missing = |source| OutputError::NoFolder { path: path.to_path_buf(), folder: folder.clone(), source };
    if folder.metadata().map_err(missing)?.is_dir() {
        return Ok(folder);
    }
    Err(missing(std::io::Error::from(ErrorKind::NotADirectory)))
}

/// The folder a path is in; a bare name is in the current one.
pub(super) fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Makes sure that files can be made in a folder, by a file without a name; where the file system has none, by asking.
#[cfg(target_os = "linux")]
pub(super) fn is_writable(folder: &Path) -> std::io::Result<()> {
    use rustix::fs::{Access, AtFlags, CWD, Mode, OFlags, accessat, open};
    use rustix::io::Errno;
    match open(folder, OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC, Mode::RUSR | Mode::WUSR) {
        Ok(_) => Ok(()),
        Err(Errno::OPNOTSUPP | Errno::ISDIR | Errno::NOENT | Errno::INVAL) => {
            Ok(accessat(CWD, folder, Access::WRITE_OK | Access::EXEC_OK, AtFlags::EACCESS)?)
        }
        Err(refused) => Err(refused.into()),
    }
}
#[cfg(not(target_os = "linux"))]
pub(super) fn is_writable(_: &Path) -> std::io::Result<()> {
    Ok(())
}
