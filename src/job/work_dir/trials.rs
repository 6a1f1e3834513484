//! What a search for a tolerance has found out, so that it goes on where it was interrupted ([`crate::job::Store`]): a list of
//! what was tried, written anew with each entry, and the chunks of its runs, each run in a folder named after its tolerance.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::layout::COMMAND;
use super::{CHUNKS, WorkDir, WorkDirError, chunk_bytes, failed};
use crate::base::durable;
use crate::base::private_file::PrivateFile;
use crate::job::search::RUN;
use crate::job::spool::{Spool, SpoolError};
use crate::job::{Figures, Pass};

pub(super) const TRIALS: &str = "trials.json";

/// A tolerance that was tried, and what it came to; numbers by their bits.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Trial {
    way: String,
    tolerance: u64,
    vertices: u64,
    triangles: u64,
    rms: u64,
    largest: u64,
}

fn read(path: &Path) -> io::Result<Vec<Trial>> {
    match fs::read(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(e) => Err(e),
        // What cannot be read has to be found out again.
        Ok(text) => Ok(serde_json::from_slice(&text).unwrap_or_default()),
    }
}

/// How many whole runs have been noted in a work dir.
pub(super) fn runs(dir: &Path) -> u64 {
    let all = read(&dir.join(TRIALS)).unwrap_or_default();
    all.iter().filter(|trial| trial.way == RUN).count() as u64
}

/// What the chunks of runs take on disk.
pub(super) fn bytes(chunks: &Path) -> u64 {
    let runs = chunks
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(FOLDER)));
    runs.map(|entry| chunk_bytes(&entry.path())).sum()
}

/// How the names of folders begin that have the chunks of runs.
const FOLDER: &str = "at-";

impl WorkDir {
    /// What has been noted of a tolerance that was tried in some way. Nothing where the raster may have changed since: then
    /// nothing but the samples of tiles can tell. Of a run in shards notes count all the same, as machines may see other times of
    /// files: they say at which tolerances runs are made, and the tiles of the one that counts are compared.
    ///
    /// # Errors
    /// [`WorkDirError::Io`].
    pub fn recall_trial(&self, way: &str, tolerance: f64) -> Result<Option<Figures>, WorkDirError> {
        if !self.same_samples && !self.dir.join(COMMAND).exists() {
            return Ok(None);
        }
        let path = self.dir.join(TRIALS);
        let all = read(&path).map_err(failed(&path))?;
        let found = all.iter().find(|trial| trial.way == way && trial.tolerance == tolerance.to_bits());
        Ok(found.map(|trial| Figures {
            vertices: trial.vertices,
            triangles: trial.triangles,
            rms: f64::from_bits(trial.rms),
            largest: f64::from_bits(trial.largest),
        }))
    }

    /// Notes what a tolerance came to that was tried in some way.
    ///
    /// # Errors
    /// [`WorkDirError::Io`].
    pub fn note_trial(&self, way: &str, tolerance: f64, figures: &Figures) -> Result<(), WorkDirError> {
        let path = self.dir.join(TRIALS);
        let mut all = read(&path).map_err(failed(&path))?;
        let Figures { vertices, triangles, rms, largest } = *figures;
        let [tolerance, rms, largest] = [tolerance, rms, largest].map(f64::to_bits);
        all.retain(|trial| (trial.way.as_str(), trial.tolerance) != (way, tolerance));
        all.push(Trial { way: way.to_string(), tolerance, vertices, triangles, rms, largest });
        let text = serde_json::to_string_pretty(&all).map_err(io::Error::other).map_err(failed(&path))?;
        let write = || {
            PrivateFile::create(&path)?.commit(text.as_bytes(), || {})?;
            durable::sync_dir(&self.dir)
        };
        write().map_err(failed(&path))
    }

    /// The spool that takes over the chunks of a pass of a search's run that are there.
    ///
    /// # Errors
    /// [`SpoolError::Kept`].
    pub fn trial_spool(&self, tolerance: f64, pass: &Pass) -> Result<Spool, SpoolError> {
        self.spool_in(&self.trial(tolerance), pass)
    }

    /// Removes the chunks of a search's run.
    ///
    /// # Errors
    /// [`WorkDirError::Io`].
    pub fn forget_trial(&self, tolerance: f64) -> Result<(), WorkDirError> {
        let dir = self.trial(tolerance);
        match fs::remove_dir_all(&dir) {
            Err(e) if e.kind() != ErrorKind::NotFound => Err(failed(&dir)(e)),
            _ => Ok(()),
        }
    }

    /// The folder of the chunks of a search's run.
    fn trial(&self, tolerance: f64) -> PathBuf {
        self.dir.join(CHUNKS).join(format!("{FOLDER}{tolerance:e}"))
    }
}
