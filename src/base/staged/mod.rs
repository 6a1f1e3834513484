//! Output files that appear whole or not at all.
//!
//! In comes the path an output shall have; out goes a file to write to, which takes that path only when it is
//! complete. Whatever can be known to be wrong with the path is found before the long run, not after it.

mod beside;
mod checks;
mod error;

pub use error::OutputError;

use std::ffi::{OsStr, OsString};
use std::fs::{File, Metadata, OpenOptions, Permissions};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempPath};

use beside::Companion;

use crate::base::durable;
use crate::base::faults::{self, Point};

/// A file that is being written under a temporary name (`.NAME.XXXXXX.partial`) in the folder of its final path.
///
/// Only its owner may read it until it is complete. Dropping it removes it, on every way out of a function: a failed
/// or cancelled run leaves nothing behind.
#[derive(Debug)]
pub struct StagedFile {
    partial: NamedTempFile,
    path: PathBuf,
    overwrite: bool,
    permissions: Permissions,
    /// What the run reads.
    inputs: Vec<PathBuf>,
    companions: Vec<Companion>,
}

impl StagedFile {
    /// Stages a file that [`StagedFile::commit`] will give the name `path`.
    ///
    /// With `overwrite` an existing file is replaced at the commit, and is untouched until then; its permissions are
    /// kept, and a symbolic link keeps pointing at it. `inputs` are the files the run reads: none of them may be
    /// replaced. Inputs that are no paths of existing files (GDAL's virtual names) are not compared.
    ///
    /// # Errors
    /// [`OutputError`] when the folder is missing or cannot be written to, when `path` exists and `overwrite` is not
    /// set, when it is no plain file, or one of `inputs` under whatever name.
    pub fn create(path: &Path, overwrite: bool, inputs: &[&Path]) -> Result<StagedFile, OutputError> {
        StagedFile::create_announced(path, overwrite, inputs, &|_| Ok(()))
    }

    /// Does what [`StagedFile::create`] does, and tells `announce` the path of the partial file before it is made, so
    /// that it can be found and removed after the process was killed.
    ///
    /// # Errors
    /// As there; what `announce` says comes as [`OutputError::Folder`].
    pub fn create_announced(
        path: &Path,
        overwrite: bool,
        inputs: &[&Path],
        announce: &dyn Fn(&Path) -> std::io::Result<()>,
    ) -> Result<StagedFile, OutputError> {
        let Place { name, existing, target, folder } = Place::of(path, overwrite, inputs)?;
        let unwritable = |source| OutputError::Folder { path: path.to_path_buf(), folder: folder.clone(), source };
        let mut permissions = existing.map(|existing| existing.permissions());
        let mut prefix = OsString::from(".");
        prefix.push(name);
        prefix.push(".");
        let make = |path: &Path| {
            announce(path)?;
            faults::reach(Point::OutputAnnounced);
            if permissions.is_none() {
                permissions = Some(default_permissions(path)?);
            }
            create_new(path, 0o600)
        };
        let partial = Builder::new().prefix(&prefix).suffix(".partial").make_in(&folder, make).map_err(unwritable)?;
        faults::reach(Point::OutputStaged);
        let permissions = permissions.map_or_else(|| Ok(partial.as_file().metadata()?.permissions()), Ok);
        let permissions = permissions.map_err(unwritable)?;
        let inputs = inputs.iter().map(|input| input.to_path_buf()).collect();
        Ok(StagedFile { partial, path: target, overwrite, permissions, inputs, companions: Vec::new() })
    }

    /// Finds what [`StagedFile::create`] would find wrong with an output, and makes nothing that has a name: whatever ends
    /// the process, nothing is left. A folder may still turn out to be closed when the file is made.
    ///
    /// # Errors
    /// As [`StagedFile::create`].
    pub fn check(path: &Path, overwrite: bool, inputs: &[&Path]) -> Result<(), OutputError> {
        let Place { folder, .. } = Place::of(path, overwrite, inputs)?;
        let unwritable = |source| OutputError::Folder { path: path.to_path_buf(), folder: folder.clone(), source };
        checks::is_writable(&folder).map_err(unwritable)
    }

    /// The file to write to. Whoever buffers flushes before the commit.
    pub fn file(&mut self) -> &mut File {
        self.partial.as_file_mut()
    }

    /// Where the bytes are until the commit: for writers that open the file by themselves.
    pub fn partial_path(&self) -> &Path {
        self.partial.path()
    }

    /// Lets nobody but the owner read what is at [`StagedFile::partial_path`], where a writer has put another file.
    ///
    /// # Errors
    /// What the system says.
    pub fn keep_private(&self) -> std::io::Result<()> {
        #[cfg(unix)]
        std::fs::set_permissions(self.partial_path(), std::os::unix::fs::PermissionsExt::from_mode(0o600))?;
        Ok(())
    }

    /// The path the file will have; with symbolic links to an existing file resolved.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What a failed write to this file is to be reported as.
    pub fn write_error(&self, source: std::io::Error) -> OutputError {
        OutputError::Write { path: self.path.clone(), source }
    }

    /// Has a small file beside this one, of the same name but for its extension, when this one takes its name: with this
    /// content, or with `None` no such file, as an old one would be taken for one of this file.
    ///
    /// One that has this content already stays as it is. Another is replaced or removed only if the output may be
    /// overwritten, and never if it belongs to an input.
    ///
    /// # Errors
    /// [`OutputError`] if there is a file that must stay, or the output itself has this extension.
    pub fn beside(&mut self, extension: &str, content: Option<Vec<u8>>) -> Result<(), OutputError> {
        self.companions.extend(Companion::of(self, extension, content)?);
        Ok(())
    }

    /// Gives the file its name, in one step: whoever looks finds the old file or the new one, whole. When it returns,
    /// the bytes and the name are on the disk. Files beside it ([`StagedFile::beside`]) take their names just before, so
    /// that whoever finds this one finds them too.
    ///
    /// # Errors
    /// [`OutputError::Write`] when the disk does not take the bytes or the name, [`OutputError::Exists`] when a file
    /// of that name has come up meanwhile and may not be overwritten. Nothing is left behind then, and files beside it are
    /// as they were.
    pub fn commit(self) -> Result<(), OutputError> {
        let StagedFile { partial, path, overwrite, permissions, companions, .. } = self;
        let failed = |source| OutputError::Write { path: path.clone(), source };
        // By name, not by handle: a writer that was given `partial_path` may have put another file there.
        let partial = partial.into_temp_path();
        OpenOptions::new().append(true).open(&partial).and_then(|f| f.sync_all()).map_err(failed)?;
        std::fs::set_permissions(&partial, permissions.clone()).map_err(failed)?;
        faults::reach(Point::OutputWritten);
        let mut placed = Vec::new();
        for companion in companions {
            placed.push(companion.place(&permissions)?);
            faults::reach(Point::CompanionPlaced);
        }
        if overwrite {
            partial.persist(&path).map_err(|e| failed(e.error))?;
        } else {
            persist_new(partial, &path)?;
        }
        placed.into_iter().for_each(beside::Placed::keep);
        faults::reach(Point::OutputRenamed);
        durable::sync_dir(checks::parent(&path)).map_err(failed)
    }
}

/// Where an output will be, once it is known that it may be there.
struct Place<'a> {
    name: &'a OsStr,
    /// What is there already.
    existing: Option<Metadata>,
    target: PathBuf,
    folder: PathBuf,
}

impl Place<'_> {
    fn of<'a>(path: &'a Path, overwrite: bool, inputs: &[&Path]) -> Result<Place<'a>, OutputError> {
        let name = checks::file_name(path)?;
        let existing = checks::existing(path)?;
        if let Some(existing) = &existing {
            checks::is_no_input(path, existing, inputs)?;
            if !overwrite {
                return Err(OutputError::Exists { path: path.to_path_buf() });
            }
        }
        let target = checks::target(path, existing.is_some());
        let folder = checks::folder(path, &target)?;
        Ok(Place { name, existing, target, folder })
    }
}

/// A new file, with these permissions less the umask.
fn create_new(path: &Path, mode: u32) -> std::io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, mode);
    #[cfg(not(unix))]
    let _ = mode;
    options.open(path)
}

/// Renames without replacing, in one step where the file system can.
fn persist_new(partial: TempPath, path: &Path) -> Result<(), OutputError> {
    let exists = || OutputError::Exists { path: path.to_path_buf() };
    let Err(refused) = partial.persist_noclobber(path) else { return Ok(()) };
    if refused.error.kind() == ErrorKind::AlreadyExists || path.symlink_metadata().is_ok() {
        return Err(exists());
    }
    // Some file systems know neither links nor a rename that spares what is there.
    let failed = |e: tempfile::PathPersistError| OutputError::Write { path: path.to_path_buf(), source: e.error };
    refused.path.persist(path).map_err(failed)
}

/// The permissions that the process's umask and the folder leave to a new file, asked of the kernel by making one: to read a
/// umask one has to change it, for all threads. It is made, empty, under the name of the partial file, and removed: no other
/// name is ever used, so that a killed run leaves nothing that nobody knows of.
fn default_permissions(partial: &Path) -> std::io::Result<Permissions> {
    let found = create_new(partial, 0o666)?.metadata();
    faults::reach(Point::OutputProbed);
    std::fs::remove_file(partial)?;
    Ok(found?.permissions())
}

#[cfg(test)]
mod tests;
