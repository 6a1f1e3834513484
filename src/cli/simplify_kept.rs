//! `simplify --work-dir`: what a run does more than one that starts afresh.

use std::path::Path;

use super::simplify::SimplifyArgs;
use super::{Failure, print};
use crate::field::FieldError;
use crate::raster::{Files, Raster, RasterError, Watch, identity};
use crate::simplify::{Error, Pass};
use crate::spool::{Spool, SpoolError};
use crate::staged::{OutputError, StagedFile};
use crate::tiling::TileGrid;
use crate::work_dir::{Job, WorkDir, WorkDirError};

/// The work dir of a run.
pub(super) struct Kept(WorkDir);

impl Kept {
    /// The work dir of a job with these parameters, by name. `watches` look at the raster, and at the importance raster
    /// where there is one.
    pub(super) fn open(
        dir: &Path,
        raster: &Raster,
        importance: Option<&Raster>,
        watches: &[Watch],
        parameters: Vec<(&'static str, String)>,
    ) -> Result<Kept, Failure> {
        let importance = importance.map(identity).transpose()?.unwrap_or_default();
        let files = watches.iter().map(Watch::files).fold(Files::none(), Files::and);
        let job = Job { parameters, raster: identity(raster)?, importance, files };
        Ok(Kept(WorkDir::open(dir, &job)?))
    }

    /// Stages the output so that it is found again. One that an earlier run of this job has completed, without coming
    /// to tell, may be replaced.
    pub(super) fn stage(&self, args: &SimplifyArgs) -> Result<StagedFile, OutputError> {
        let overwrite = args.overwrite || self.0.has_committed(&args.output);
        StagedFile::create_announced(&args.output, overwrite, &args.inputs(), &|partial| self.0.staging(partial))
    }

    pub(super) fn path(&self) -> &Path {
        self.0.path()
    }

    /// What the finished tiles there take.
    pub(super) fn chunk_bytes(&self) -> u64 {
        self.0.chunk_bytes()
    }

    pub(super) fn spool(&self, grid: TileGrid, pass: Pass) -> Result<Spool, SpoolError> {
        self.0.spool(grid, pass == Pass::Seams)
    }

    pub(super) fn committing(&self) -> Result<(), Error> {
        self.0.committing().map_err(|source| WorkDirError::Io { path: self.0.path().to_path_buf(), source }.into())
    }

    /// The output is there whatever comes of this, so it is no failure.
    pub(super) fn finish(self) {
        if let Err(error) = self.0.finish() {
            print::error(&format!("warning: {error}; the work dir is not needed any more and can be deleted"));
        }
    }

    /// A run that did not get through, and what is to be done with its finished tiles.
    pub(super) fn explain(self, error: Error) -> Failure {
        let dir = self.0.path().display();
        let hint = match &error {
            _ if !self.0.has_chunks() => None,
            Error::Raster(RasterError::Changed { .. }) => Some(format!(
                "the finished tiles in {dir} were made from the old one: delete that folder, or restore the raster"
            )),
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
