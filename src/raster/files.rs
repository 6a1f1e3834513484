use std::path::{Path, PathBuf};
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::{Opening, Raster, RasterError, identity};

/// The files that hold a raster's samples, as far as they are known: their lengths and times of modification.
///
/// Of a GeoTIFF that is a plain file, all are known: it is that file. Of other formats only the file they are opened by
/// is, where there is one: a VRT's sources and names inside archives are not looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Files {
    /// Whether these are all the files with samples.
    all: bool,
    files: Vec<FileState>,
}

/// A file as it was when it was looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct FileState {
    bytes: u64,
    /// Seconds and nanoseconds since 1970; before that, 0.
    modified: (u64, u32),
}

impl FileState {
    fn of(path: &Path) -> Option<FileState> {
        let found = path.metadata().ok().filter(std::fs::Metadata::is_file)?;
        let since = found.modified().ok()?.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        Some(FileState { bytes: found.len(), modified: (since.as_secs(), since.subsec_nanos()) })
    }
}

impl Files {
    /// Looks at the files of `raster`.
    pub fn of(raster: &Raster) -> Files {
        let files: Vec<FileState> = FileState::of(raster.path()).into_iter().collect();
        Files { all: !files.is_empty() && raster.driver() == "GTiff", files }
    }

    /// Of no raster at all: the beginning of [`Files::and`].
    pub fn none() -> Files {
        Files { all: true, files: Vec::new() }
    }

    /// No file is known: nothing is the same for sure.
    pub fn unknown() -> Files {
        Files { all: false, files: Vec::new() }
    }

    /// These files and those of another raster.
    pub fn and(mut self, other: &Files) -> Files {
        self.all &= other.all;
        self.files.extend_from_slice(&other.files);
        self
    }

    /// Whether the samples are the same for sure: all files are known, and none differs in length or time. Names do not
    /// count: files may be moved.
    pub fn same_samples(&self, other: &Files) -> bool {
        self.all && self == other
    }
}

/// Notices that a raster is changed while a run reads it.
///
/// Cost: a look at one file; where not all files are known, also the reading of [`identity`], at the beginning and at
/// each check.
#[derive(Debug)]
pub struct Watch {
    path: PathBuf,
    opening: Opening,
    files: Files,
    identity: Option<Vec<(&'static str, String)>>,
}

impl Watch {
    /// Begins to watch. To be called before any sample is read.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    pub fn new(raster: &Raster) -> Result<Watch, RasterError> {
        let files = Files::of(raster);
        let identity = if files.all { None } else { Some(identity(raster)?) };
        Ok(Watch { path: raster.path().to_path_buf(), opening: raster.opening(), files, identity })
    }

    /// The files as they were at the beginning.
    pub fn files(&self) -> &Files {
        &self.files
    }

    /// Makes sure that the raster is what it was.
    ///
    /// # Errors
    /// [`RasterError::Changed`] names the difference; or the raster cannot be read any more.
    pub fn check(&self) -> Result<(), RasterError> {
        if let Some(before) = self.files.files.first() {
            let now = FileState::of(&self.path);
            let state = |s: &FileState| format!("{} bytes, modified {}.{:09}", s.bytes, s.modified.0, s.modified.1);
            if now.as_ref() != Some(before) {
                let found = now.as_ref().map_or("no such file".to_string(), state);
                return Err(self.changed("file", state(before), found));
            }
        }
        let Some(before) = &self.identity else { return Ok(()) };
        // A handle of its own: GDAL may hold blocks of the old one.
        let now = identity(&self.opening.open()?)?;
        match before.iter().zip(now).find(|(before, now)| *before != now) {
            Some(((what, expected), (_, found))) => Err(self.changed(what, expected.clone(), found)),
            None => Ok(()),
        }
    }

    fn changed(&self, what: &str, expected: String, found: String) -> RasterError {
        RasterError::Changed { path: self.path.clone(), what: what.to_string(), expected, found }
    }
}
