//! A folder of tiles that comes to its name whole: made under another one beside it, synced once, then renamed.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;
use tempfile::TempDir;

use super::error::PyramidError;
use super::grid::TileKey;
use super::manifest::{LAYER, PROMISE};
use crate::base::durable;

/// A set of tiles that is not under its name yet. Dropped before [`StagedSet::commit`], it is removed.
pub(super) struct StagedSet {
    /// Holds the set, so that the set itself has the permissions that new folders have.
    private: TempDir,
    set: PathBuf,
    output: PathBuf,
    gzip: bool,
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> PyramidError {
    let path = path.to_path_buf();
    move |source| PyramidError::File { path, source }
}

impl StagedSet {
    /// Begins a set that is going to be `output`: nothing, an empty folder, or with `overwrite` an earlier set.
    pub(super) fn create(output: &Path, overwrite: bool, gzip: bool) -> Result<StagedSet, PyramidError> {
        check(output, overwrite)?;
        let (parent, name) = (parent(output), output.file_name().unwrap_or_default());
        let prefix = format!(".{}.", name.to_string_lossy());
        let private = tempfile::Builder::new().prefix(&prefix).suffix(".partial").tempdir_in(parent);
        // The system's words, without the name of what nobody asked for.
        let private = private.map_err(|error| failed(parent)(error.kind().into()))?;
        let set = private.path().join("set");
        fs::create_dir(&set).map_err(failed(&set))?;
        Ok(StagedSet { private, set, output: output.to_path_buf(), gzip })
    }

    /// Makes the folders of a level's columns.
    pub(super) fn prepare(&self, tiles: &[TileKey]) -> Result<(), PyramidError> {
        for column in tiles.chunk_by(|a, b| a.x == b.x) {
            let folder = self.set.join(format!("{}/{}", column[0].level, column[0].x));
            fs::create_dir_all(&folder).map_err(failed(&folder))?;
        }
        Ok(())
    }

    /// Writes a tile, and tells how many bytes there are in the file.
    pub(super) fn put(&self, tile: TileKey, bytes: &[u8]) -> Result<u64, PyramidError> {
        let path = self.set.join(format!("{tile}.terrain"));
        let write = |bytes: &[u8]| {
            let mut file = fs::File::create(&path)?;
            file.write_all(bytes).map(|()| bytes.len() as u64)
        };
        let written = match self.gzip {
            true => compressed(bytes).and_then(|bytes| write(&bytes)),
            false => write(bytes),
        };
        written.map_err(failed(&path))
    }

    /// Writes a file beside the tiles.
    pub(super) fn put_json(&self, name: &str, value: &impl serde::Serialize) -> Result<(), PyramidError> {
        let path = self.set.join(name);
        let text = serde_json::to_string_pretty(value).map_err(|e| failed(&path)(e.into()))?;
        fs::write(&path, text + "\n").map_err(failed(&path))
    }

    /// Gives the set its name. All of it is on the disk before that.
    pub(super) fn commit(self, overwrite: bool) -> Result<(), PyramidError> {
        let StagedSet { private, set, output, .. } = self;
        let folder = fs::File::open(&set).map_err(failed(&set))?;
        rustix::fs::syncfs(&folder).map_err(|e| failed(&output)(e.into()))?;
        // Something may have come up meanwhile.
        check(&output, overwrite)?;
        if output.symlink_metadata().is_ok() {
            // An earlier set goes when the new one is there.
            let earlier = private.path().join("earlier");
            fs::rename(&output, &earlier).map_err(failed(&output))?;
            if let Err(error) = fs::rename(&set, &output) {
                // Where even this fails, the earlier set stays in the private folder.
                if fs::rename(&earlier, &output).is_err() {
                    let _ = private.keep();
                }
                return Err(failed(&output)(error));
            }
        } else {
            fs::rename(&set, &output).map_err(failed(&output))?;
        }
        durable::sync_dir(parent(&output)).map_err(failed(&output))?;
        let path = private.path().to_path_buf();
        private.close().map_err(failed(&path))
    }
}

/// Compressed, the same bytes whenever it is done.
fn compressed(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}

fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Whether a set may take this name.
fn check(output: &Path, overwrite: bool) -> Result<(), PyramidError> {
    let occupied = |found: &str| PyramidError::Occupied { path: output.to_path_buf(), found: found.to_string() };
    if output.file_name().is_none() {
        return Err(occupied("no name of a folder"));
    }
    match output.symlink_metadata() {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(()),
        Err(e) => return Err(failed(output)(e)),
        Ok(found) if !found.is_dir() => return Err(occupied("something that is no folder")),
        Ok(_) => {}
    }
    let is_empty = fs::read_dir(output).map_err(failed(output))?.next().is_none();
    let is_ours = output.join(PROMISE).is_file();
    match (is_empty, is_ours, overwrite) {
        (true, _, _) => Ok(()),
        (_, true, true) => match foreign(output).map_err(failed(output))? {
            None => Ok(()),
            Some(path) => Err(occupied(&format!("an earlier set of tiles with {} in it", path.display()))),
        },
        (_, true, false) => Err(occupied("an earlier set of tiles")),
        (_, false, _) => Err(occupied("other files")),
    }
}

/// Something in a set of tiles that is none of its files, if there is any: it would go with the set.
fn foreign(set: &Path) -> std::io::Result<Option<PathBuf>> {
    let is_number = |name: &str| name.parse::<u32>().is_ok();
    let mut folders = vec![(set.to_path_buf(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        for entry in fs::read_dir(&folder)? {
            let entry = entry?;
            let (name, kind) = (entry.file_name(), entry.file_type()?);
            let name = name.to_str().unwrap_or_default();
            let is_ours = match depth {
                0 if kind.is_file() => [LAYER, PROMISE].contains(&name),
                0 | 1 => kind.is_dir() && is_number(name),
                _ => kind.is_file() && name.strip_suffix(".terrain").is_some_and(is_number),
            };
            if !is_ours {
                return Ok(Some(entry.path()));
            }
            if kind.is_dir() {
                folders.push((entry.path(), depth + 1));
            }
        }
    }
    Ok(None)
}
