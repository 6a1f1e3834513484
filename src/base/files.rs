//! The files that hold a raster's samples, as they were when a run began.

use std::path::Path;
use std::time::SystemTime;

use serde::{Deserialize, Serialize};

use super::RasterError;

/// The files that hold a raster's samples, as far as they are known: their lengths and times of modification.
///
/// Of a GeoTIFF that is a plain file, all are known: it is that file, with a mask, tags and world files beside it. Of other
/// formats those are known that `companions` finds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Files {
    /// Whether these are all the files with samples.
    all: bool,
    files: Vec<FileState>,
}

/// A file as it was when it was looked at.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileState {
    /// What it is called, counted from the folder of the raster; empty for the raster's own file, which may be renamed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    name: String,
    bytes: u64,
    /// Seconds and nanoseconds since 1970; before that, 0.
    modified: (u64, u32),
}

impl FileState {
    /// The file at `path`, called `name` beside the raster; `None` where there is none.
    pub fn of(path: &Path, name: &str) -> Option<FileState> {
        let found = path.metadata().ok().filter(std::fs::Metadata::is_file)?;
        let since = found.modified().ok()?.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let modified = (since.as_secs(), since.subsec_nanos());
        Some(FileState { name: name.to_string(), bytes: found.len(), modified })
    }

    /// In words, of a file that may not be there.
    pub fn said(state: Option<&FileState>) -> String {
        let said = |s: &FileState| format!("{} bytes, modified {}.{:09}", s.bytes, s.modified.0, s.modified.1);
        state.map_or("no such file".to_string(), said)
    }
}

impl Files {
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

    /// Whether the samples are the same for sure: all files are known, none differs in length or time, and none has come up
    /// or gone. Folders do not count: files may be moved.
    pub fn same_samples(&self, other: &Files) -> bool {
        self.all && self == other
    }

    /// What the files are called that differ, have come up or are gone; "the raster's own file" among them.
    pub fn differences(&self, other: &Files) -> Vec<String> {
        let missing_in = |a: &Files, b: &Files| -> Vec<String> {
            let missing = b.files.iter().filter(|file| !a.files.contains(file));
            missing.map(|file| file.name.clone()).collect()
        };
        let mut names = missing_in(self, other);
        names.extend(missing_in(other, self));
        names.sort();
        names.dedup();
        let said = |name: String| if name.is_empty() { "the raster's own file".to_string() } else { name };
        names.into_iter().map(said).collect()
    }
}

impl Files {
    /// These files; `all` says whether they are all that hold samples.
    pub fn new(all: bool, files: Vec<FileState>) -> Files {
        Files { all, files }
    }

    /// Whether all files with samples are known.
    pub fn are_all(&self) -> bool {
        self.all
    }
}

/// Notices that something a run reads is changed meanwhile.
pub trait Watch: Send + Sync {
    /// The files with samples as they were at the beginning.
    fn files(&self) -> &Files;

    /// Makes sure that everything is what it was.
    ///
    /// # Errors
    /// [`RasterError::Changed`] or [`RasterError::LayerChanged`] names the difference; or it cannot be read any more.
    fn check(&self) -> Result<(), RasterError>;

    /// The same as far as it costs next to nothing: it is asked after each look at samples, so that none is used that is
    /// not of the same raster as those before it.
    ///
    /// # Errors
    /// As [`Watch::check`].
    fn check_files(&self) -> Result<(), RasterError>;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_older_work_dirs_are_understood() {
        let files: Files =
            serde_json::from_str(r#"{"all": true, "files": [{"bytes": 7, "modified": [1, 2]}]}"#).unwrap();
        assert_eq!(files.files[0].name, "");
        assert!(!serde_json::to_string(&files).unwrap().contains("name"));
    }
}
