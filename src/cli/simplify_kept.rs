//! `simplify --work-dir`: what a run does more than one that starts afresh.

use std::path::Path;

use super::simplify::SimplifyArgs;
use super::{Failure, warnings};
use crate::base::staged::{OutputError, StagedFile};
use crate::base::warning::{Warning, WarningCode};
use crate::base::{Band, Files, Watch, identity};
use crate::field::FieldError;
use crate::job::spool::{Spool, SpoolError};
use crate::job::work_dir::{Finished, Job, WorkDir, WorkDirError};
use crate::job::{Error, Pass, PassName};

/// What a work dir belongs to.
fn job(
    band: &Band,
    importance: Option<&Band>,
    files: Files,
    parameters: Vec<(&'static str, String)>,
) -> Result<Job, Failure> {
    let importance = importance.map(identity).transpose()?.unwrap_or_default();
    Ok(Job { parameters, raster: identity(band)?, importance, files })
}

/// What a run of this job would find finished in its work dir, which is left alone.
pub(super) fn finished(
    dir: &Path,
    band: &Band,
    importance: Option<&Band>,
    parameters: Vec<(&'static str, String)>,
) -> Result<Finished, Failure> {
    Ok(Finished::of(dir, &job(band, importance, Files::none(), parameters)?)?)
}

/// The work dir of a run.
pub(super) struct Kept {
    dir: WorkDir,
    /// Files that are not as they were when it was made.
    changed: Vec<String>,
}

impl Kept {
    /// The work dir of a job with these parameters, by name. `watches` look at the raster, and at the importance raster
    /// where there is one.
    pub(super) fn open(
        dir: &Path,
        band: &Band,
        importance: Option<&Band>,
        watches: &[Box<dyn Watch>],
        parameters: Vec<(&'static str, String)>,
    ) -> Result<Kept, Failure> {
        let files = watches.iter().map(|watch| watch.files()).fold(Files::none(), Files::and);
        let job = job(band, importance, files, parameters)?;
        let dir = WorkDir::open(dir, &job)?;
        let changed = dir.files().differences(&job.files);
        Ok(Kept { dir, changed })
    }

    /// Stages the output so that it is found again. One that an earlier run of this job has completed, without coming
    /// to tell, may be replaced.
    pub(super) fn stage(&self, args: &SimplifyArgs) -> Result<StagedFile, OutputError> {
        let overwrite = args.overwrite || self.dir.has_committed(&args.output);
        StagedFile::create_announced(&args.output, overwrite, &args.inputs(), &|partial| self.dir.staging(partial))
    }

    pub(super) fn path(&self) -> &Path {
        self.dir.path()
    }

    /// What the finished tiles there take.
    pub(super) fn chunk_bytes(&self) -> u64 {
        self.dir.chunk_bytes()
    }

    pub(super) fn spool(&self, pass: &Pass) -> Result<Spool, SpoolError> {
        self.dir.spool(pass.grid(), pass.name() == PassName::Seams)
    }

    pub(super) fn committing(&self) -> Result<(), Error> {
        self.dir.committing().map_err(|source| WorkDirError::Io { path: self.dir.path().to_path_buf(), source }.into())
    }

    /// The output is there whatever comes of this, so it is no failure.
    pub(super) fn finish(self) {
        let file = self.dir.path().to_path_buf();
        if let Err(error) = self.dir.finish() {
            let message = error.to_string().trim_start_matches(&format!("{}: ", file.display())).to_string();
            warnings::collect([Warning { code: WarningCode::WorkDirLeft, file, count: 1, message }]);
        }
    }

    /// What is to be done where an input has changed since the finished tiles were made.
    fn made_before(&self) -> String {
        let (dir, way_out) = (self.dir.path().display(), "delete that folder, or restore the input");
        match self.changed.as_slice() {
            [] => format!("the finished tiles in {dir} were made from the old one: {way_out}"),
            names => format!("the finished tiles in {dir} were made before {} changed: {way_out}", names.join(", ")),
        }
    }

    /// A run that did not get through, and what is to be done with its finished tiles.
    pub(super) fn explain(self, error: Error) -> Failure {
        let dir = self.dir.path().display();
        let hint = match &error {
            _ if !self.dir.has_chunks() => None,
            Error::Raster(error) | Error::Field(FieldError::Raster(error)) if error.is_change() => {
                Some(self.made_before())
            }
            // No run of this command can succeed.
            Error::NoGround { .. }
            | Error::Field(
                FieldError::Nodata { .. }
                | FieldError::NotAHeight { .. }
                | FieldError::NotAWeight { .. }
                | FieldError::Inexact { .. },
            ) => None,
            _ => Some(format!("finished tiles are kept in {dir}: the same command continues")),
        };
        let failure = Failure::from(error);
        match hint {
            Some(hint) => failure.hint(&hint),
            None => failure,
        }
    }
}
