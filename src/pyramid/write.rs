//! A folder of tiles that comes to its name whole: made under another one beside it, synced once, then renamed.

use std::fmt::Write as _;
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::error::PyramidError;
use super::grid::TileKey;
use super::manifest::{LAYER, PROMISE};
use crate::base::durable;
use crate::base::faults::{self, Point};

/// A set of tiles that is not under its name yet. Dropped before [`StagedSet::commit`], it is removed.
pub(super) struct StagedSet {
    set: PathBuf,
    output: PathBuf,
}

fn failed(path: &Path) -> impl FnOnce(std::io::Error) -> PyramidError {
    let path = path.to_path_buf();
    move |source| PyramidError::File { path, source }
}

impl StagedSet {
    /// Begins a set that is going to be `output`: nothing, an empty folder, or with `overwrite` an earlier set. `announce` is told
    /// its path before it is made, so that it can be found and removed after the process was killed.
    pub(super) fn create(
        output: &Path,
        overwrite: bool,
        announce: &dyn Fn(&Path) -> std::io::Result<()>,
    ) -> Result<StagedSet, PyramidError> {
        check(output, overwrite)?;
        let (parent, name) = (parent(output), output.file_name().unwrap_or_default());
        let prefix = format!(".{}.", name.to_string_lossy());
        let make = |path: &Path| {
            announce(path)?;
            faults::reach(Point::OutputAnnounced);
            fs::create_dir(path)
        };
        let made = tempfile::Builder::new().prefix(&prefix).suffix(".partial").make_in(parent, make);
        // The system's words, without the name of what nobody asked for.
        let made = made.map_err(|error| failed(parent)(error.kind().into()))?;
        let set = made.into_temp_path().keep().map_err(|e| failed(parent)(e.error))?;
        faults::reach(Point::OutputStaged);
        Ok(StagedSet { set, output: output.to_path_buf() })
    }

    /// Makes the folders of a level's columns.
    pub(super) fn prepare(&self, tiles: &[TileKey]) -> Result<(), PyramidError> {
        for column in tiles.chunk_by(|a, b| a.x == b.x) {
            let folder = self.set.join(format!("{}/{}", column[0].level, column[0].x));
            fs::create_dir_all(&folder).map_err(failed(&folder))?;
        }
        Ok(())
    }

    /// Writes a tile's file.
    pub(super) fn put(&self, tile: TileKey, content: &[u8]) -> Result<(), PyramidError> {
        let path = self.set.join(format!("{tile}.terrain"));
        fs::write(&path, content).map_err(failed(&path))
    }

    /// Writes a file beside the tiles.
    pub(super) fn put_json(&self, name: &str, value: &impl serde::Serialize) -> Result<(), PyramidError> {
        let path = self.set.join(name);
        let text = serde_json::to_string_pretty(value).map_err(|e| failed(&path)(e.into()))?;
        fs::write(&path, text + "\n").map_err(failed(&path))
    }

    /// The names and lengths of the set's files, a line for each: the manifests and these tiles.
    pub(super) fn list(&self, tiles: impl Iterator<Item = TileKey>) -> Result<String, PyramidError> {
        let mut list = String::new();
        for name in [LAYER, PROMISE].map(str::to_string).into_iter().chain(tiles.map(|tile| format!("{tile}.terrain")))
        {
            let path = self.set.join(&name);
            let length = path.metadata().map_err(failed(&path))?.len();
            writeln!(list, "{length} {name}").expect("memory takes all lines");
        }
        Ok(list)
    }

    /// Gives the set its name. All of it is on the disk before that; then `committing` is told.
    pub(super) fn commit(
        self,
        overwrite: bool,
        committing: &dyn Fn() -> std::io::Result<()>,
    ) -> Result<(), PyramidError> {
        let (set, output) = (&self.set, &self.output);
        let folder = fs::File::open(set).map_err(failed(set))?;
        rustix::fs::syncfs(&folder).map_err(|e| failed(output)(e.into()))?;
        faults::reach(Point::OutputWritten);
        // Something may have come up meanwhile.
        check(output, overwrite)?;
        committing().map_err(failed(output))?;
        change_places(set, output, overwrite).map_err(failed(output))?;
        faults::reach(Point::OutputRenamed);
        durable::sync_dir(parent(output)).map_err(failed(output))?;
        // An earlier set, where they have changed places.
        match fs::remove_dir_all(set) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(failed(set)(e)),
            _ => Ok(()),
        }
    }
}

impl Drop for StagedSet {
    fn drop(&mut self) {
        // Nobody is left to be told; the folder's name says that it may be deleted.
        let _ = fs::remove_dir_all(&self.set);
    }
}

/// Gives a set its name. An earlier one there has the set's then: both change places in one step, so that whoever looks finds one
/// of them, whole. Where a file system cannot do that, there is a moment without any.
fn change_places(set: &Path, output: &Path, overwrite: bool) -> std::io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    use rustix::io::Errno;
    match fs::rename(set, output) {
        Err(e) if overwrite && matches!(e.kind(), ErrorKind::DirectoryNotEmpty | ErrorKind::AlreadyExists) => {}
        other => return other,
    }
    match renameat_with(CWD, set, CWD, output, RenameFlags::EXCHANGE) {
        Err(Errno::INVAL | Errno::NOSYS | Errno::NOTSUP) => {}
        other => return Ok(other?),
    }
    let earlier = set.with_extension("earlier");
    fs::rename(output, &earlier)?;
    if let Err(error) = fs::rename(set, output) {
        // Where even this fails, the earlier set keeps that name.
        let _ = fs::rename(&earlier, output);
        return Err(error);
    }
    fs::remove_dir_all(&earlier)
}

/// Compressed, the same bytes whenever it is done.
pub(super) fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).expect("memory takes all bytes")
}

fn parent(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Makes sure that all files of a [list](StagedSet::list) are in a set, with their lengths. A look at each, and none into it.
pub(super) fn must_have(set: &Path, list: &str) -> Result<(), PyramidError> {
    for (length, name) in list.lines().filter_map(|line| line.split_once(' ')) {
        let path = set.join(name);
        let found = match path.metadata() {
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => None,
            other => Some(other.map_err(failed(&path))?).filter(fs::Metadata::is_file).map(|file| file.len()),
        };
        if found.map(|found| found.to_string()).as_deref() != Some(length) {
            return Err(PyramidError::Altered { path, expected: length.to_string(), found });
        }
    }
    Ok(())
}

/// What [`PyramidError::Occupied`] calls what may be replaced.
pub(crate) const EARLIER_SET: &str = "an earlier set of tiles";

/// Whether a set may take this name.
pub(super) fn check(output: &Path, overwrite: bool) -> Result<(), PyramidError> {
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
            Some(path) => Err(occupied(&format!("{EARLIER_SET} with {} in it", path.display()))),
        },
        (_, true, false) => Err(occupied(EARLIER_SET)),
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
