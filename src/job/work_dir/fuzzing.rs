//! The readers of a work dir's notes, for the fuzzers.

use std::path::Path;

use super::manifest::Manifest;
use super::{Job, WorkDir};
use crate::base::Files;

fn job() -> Job {
    let (parameters, raster) = (vec![("max error", "1".to_string())], vec![("width", "5".to_string())]);
    Job { parameters, raster, importance: Vec::new(), files: Files::none() }
}

/// A manifest of any bytes is read or refused, and what is read is written as something that is read as the same; a work
/// dir with it is opened or refused.
pub(crate) fn manifest(bytes: &[u8], temp_dir: &Path) {
    let folder = tempfile::tempdir_in(temp_dir).expect("a folder");
    let dir = folder.path().join("work");
    std::fs::create_dir(&dir).expect("made");
    std::fs::write(Manifest::path(&dir), bytes).expect("written");
    let opened = WorkDir::open(&dir, &job());
    let Ok(text) = std::str::from_utf8(bytes) else {
        assert!(opened.is_err());
        return;
    };
    let Ok(read) = Manifest::parse(Path::new("manifest.json"), text) else {
        assert!(opened.is_err());
        return;
    };
    let written = serde_json::to_string(&read).expect("plain data");
    let again = Manifest::parse(Path::new("manifest.json"), &written).expect("what was written");
    assert_eq!((again.stamp(), serde_json::to_string(&again).ok()), (read.stamp(), Some(written)));
    let same = Manifest::new(&job()).must_continue(&dir, &read).is_ok();
    assert_eq!(opened.is_ok(), same);
}

/// The bytes of a manifest that continues the fuzzers' job.
#[cfg(test)]
pub(crate) fn a_manifest() -> Vec<u8> {
    serde_json::to_vec_pretty(&Manifest::new(&job())).expect("plain data")
}
