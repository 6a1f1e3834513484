//! A run with a work dir: what it does more than one that starts afresh.

use std::path::Path;

use super::{Fate, Request, RunError, Warned};
use crate::base::staged::{OutputError, StagedFile};
use crate::base::{Band, Files, RasterError, Watch, identity};
use crate::field::FieldError;
use crate::job::spool::{Spool, SpoolError};
use crate::job::work_dir::{Finished, Job, WorkDir, WorkDirError};
use crate::job::{Error, Figures, Pass, Store};

/// What a work dir belongs to.
fn job(
    band: &Band,
    importance: Option<&Band>,
    files: Files,
    parameters: Vec<(&'static str, String)>,
) -> Result<Job, RasterError> {
    let importance = importance.map(identity).transpose()?.unwrap_or_default();
    Ok(Job { parameters, raster: identity(band)?, importance, files })
}

/// What a run of this job would find finished in its work dir, which is left alone.
pub(super) fn finished(
    dir: &Path,
    band: &Band,
    importance: Option<&Band>,
    parameters: Vec<(&'static str, String)>,
) -> Result<Finished, RunError> {
    Ok(Finished::of(dir, &job(band, importance, Files::none(), parameters)?)?)
}

/// The work dir of a run.
pub(super) struct Kept {
    dir: WorkDir,
    /// Files that are not as they were when it was made.
    changed: Vec<String>,
}

impl Kept {
    /// The work dir of a job with these parameters, by name, as `open` gives it. `watches` look at the raster, and at the importance
    /// raster where there is one.
    pub(super) fn open(
        open: impl FnOnce(&Job) -> Result<WorkDir, WorkDirError>,
        band: &Band,
        importance: Option<&Band>,
        watches: &[Box<dyn Watch>],
        parameters: Vec<(&'static str, String)>,
    ) -> Result<Kept, RunError> {
        let files = watches.iter().map(|watch| watch.files()).fold(Files::none(), Files::and);
        let job = job(band, importance, files, parameters)?;
        let dir = open(&job)?;
        let changed = dir.files().differences(&job.files);
        Ok(Kept { dir, changed })
    }

    /// The work dir itself.
    pub(super) fn dir(&self) -> &WorkDir {
        &self.dir
    }

    /// Stages the output so that it is found again. One that an earlier run of this job has completed, without coming
    /// to tell, may be replaced.
    pub(super) fn stage(&self, request: &Request<'_>) -> Result<StagedFile, OutputError> {
        let (output, inputs) = (request.output.as_path(), request.inputs());
        let overwrite = request.overwrite || self.dir.has_committed(output);
        StagedFile::create_announced(output, overwrite, &inputs, &|partial| self.dir.staging(partial))
    }

    pub(super) fn path(&self) -> &Path {
        self.dir.path()
    }

    /// What the finished tiles there take.
    pub(super) fn chunk_bytes(&self) -> u64 {
        self.dir.chunk_bytes()
    }

    pub(super) fn spool(&self, pass: &Pass) -> Result<Spool, SpoolError> {
        self.dir.spool(pass)
    }

    pub(super) fn committing(&self) -> Result<(), Error> {
        self.dir.committing().map_err(|source| WorkDirError::Io { path: self.dir.path().to_path_buf(), source }.into())
    }

    pub(super) fn finish(self, warned: &Warned<'_>) {
        if let Some(warning) = self.dir.finish_or_warn() {
            warned.tell(warning);
        }
    }

    /// A run that did not get through, and what becomes of its finished tiles.
    pub(super) fn explain(self, error: Error) -> RunError {
        let fate = match &error {
            Error::Spool(SpoolError::Damaged { .. }) | Error::Unlike { .. } => Fate::Damaged,
            Error::Missing(missing) => {
                Fate::Incomplete { pass: Some(missing.pass).filter(|_| missing.trial.is_none()) }
            }
            _ if !self.dir.has_chunks() => return error.into(),
            Error::Raster(error) | Error::Field(FieldError::Raster(error)) if error.is_change() => {
                Fate::Outdated(self.changed)
            }
            // No run of this request can succeed.
            Error::NoGround { .. }
            | Error::Field(
                FieldError::Nodata { .. }
                | FieldError::NotAHeight { .. }
                | FieldError::NotAWeight { .. }
                | FieldError::Inexact { .. },
            ) => return error.into(),
            _ => Fate::Continue,
        };
        RunError::Kept { error: Box::new(error), dir: self.dir.path().to_path_buf(), fate }
    }
}

impl Store for Kept {
    fn spool(&self, trial: Option<f64>, pass: &Pass) -> Result<Spool, SpoolError> {
        match trial {
            None => self.dir.spool(pass),
            Some(tolerance) => self.dir.trial_spool(tolerance, pass),
        }
    }

    fn recall(&self, way: &str, tolerance: f64) -> Result<Option<Figures>, Error> {
        Ok(self.dir.recall_trial(way, tolerance)?)
    }

    fn note(&self, way: &str, tolerance: f64, figures: &Figures) -> Result<(), Error> {
        Ok(self.dir.note_trial(way, tolerance, figures)?)
    }

    fn forget(&self, trial: f64) -> Result<(), Error> {
        Ok(self.dir.forget_trial(trial)?)
    }
}
