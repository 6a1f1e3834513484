//! Work dirs of jobs whose finished parts are files that the job names itself, in the folder for chunks.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use super::manifest::Manifest;
use super::{CHUNKS, PlannedCommand, WorkDir, WorkDirError, failed, lock, remove_leftovers, staged_output};
use crate::base::durable;
use crate::base::private_file::PrivateFile;
use crate::base::warning::{Warning, WarningCode};

/// What is to be told of an output that has taken its name.
pub(super) const REPORT: &str = "report";

impl WorkDir {
    /// The folder of finished parts, made if it is missing. It goes with the work dir; where it is empty, nothing has begun.
    ///
    /// # Errors
    /// [`WorkDirError::Io`].
    pub fn parts(&self) -> Result<PathBuf, WorkDirError> {
        let folder = self.dir.join(CHUNKS);
        match durable::create_private_dir(&folder) {
            Err(e) if e.kind() != ErrorKind::AlreadyExists => Err(failed(&folder)(e)),
            Err(_) => Ok(folder),
            Ok(()) => durable::sync_dir(&self.dir).map_err(failed(&self.dir)).map(|()| folder),
        }
    }

    /// A number for everything that decides finished parts: it ties them to their job.
    pub fn stamp(&self) -> u32 {
        self.manifest.stamp()
    }

    /// Keeps what is to be told of the output once it has its name: a run that is killed then does not come to tell.
    ///
    /// # Errors
    /// What the system says.
    pub fn keep_report(&self, report: &[u8]) -> io::Result<()> {
        let bytes = [&self.stamp().to_le_bytes(), report].concat();
        PrivateFile::create(&self.dir.join(REPORT))?.commit(&bytes, || {})
    }

    /// What was kept so of an output that has its name; `None` where it is not there, or may be of other samples.
    pub fn report_of(&self, output: &Path) -> Option<Vec<u8>> {
        let bytes = std::fs::read(self.dir.join(REPORT)).ok()?;
        let (stamp, report) = bytes.split_first_chunk()?;
        let is_its = *stamp == self.stamp().to_le_bytes() && self.same_samples && self.has_committed(output);
        is_its.then(|| report.to_vec())
    }

    /// Ends the job, as [`WorkDir::finish`] does. The output is there whatever comes of this, so it is a warning and no failure.
    ///
    /// # Panics
    /// As there.
    pub fn finish_or_warn(self) -> Option<Warning> {
        let file = self.dir.clone();
        let error = self.finish().err()?.to_string();
        let message = error.trim_start_matches(&format!("{}: ", file.display())).to_string();
        Some(Warning { code: WarningCode::WorkDirLeft, file, count: 1, message })
    }

    /// Opens the work dir of a run that has been laid out, whatever its job: for whoever needs nothing but what is kept in it. The
    /// partial output of a killed run is removed.
    ///
    /// # Errors
    /// [`WorkDirError`]: no run is laid out in it, another version has done so, another process works in it.
    pub fn open_laid_out(dir: &Path) -> Result<WorkDir, WorkDirError> {
        let joined = WorkDir::join_laid_out(dir)?;
        let lock = lock::lock(&joined.dir, false)?;
        remove_leftovers(&joined.dir).map_err(failed(&joined.dir))?;
        staged_output::remove_partial(&joined.dir).map_err(failed(&joined.dir))?;
        let mut again = WorkDir::join_laid_out(dir)?;
        again.lock = Some(lock);
        Ok(again)
    }

    /// Joins it, as any number of processes may at once: nothing is locked.
    ///
    /// # Errors
    /// As [`WorkDir::open_laid_out`], but for [`WorkDirError::InUse`].
    pub fn join_laid_out(dir: &Path) -> Result<WorkDir, WorkDirError> {
        let dir = std::path::absolute(dir).unwrap_or_else(|_| dir.to_path_buf());
        PlannedCommand::of(&dir)?;
        let path = Manifest::path(&dir);
        let manifest = match std::fs::read_to_string(&path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return Err(WorkDirError::NotPlanned { dir }),
            other => Manifest::parse(&path, &other.map_err(failed(&path))?)?,
        };
        Ok(WorkDir { dir, manifest, same_samples: true, lock: None })
    }
}
