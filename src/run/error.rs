//! Why a run did not get through.

use std::path::PathBuf;

use super::checkpoints::CheckpointError;
use super::{LookError, UnusableLines};
#[cfg(feature = "gdal")]
use crate::base::LineKind;
use crate::base::RasterError;
use crate::base::external::ScratchError;
use crate::base::staged::OutputError;
use crate::field::FieldError;
use crate::formats::{ReadError, SinkError, SinkOption};
use crate::job::rules::{Incompatible, NotInShards};
use crate::job::work_dir::WorkDirError;
use crate::job::{BudgetTooSmall, Error};
#[cfg(feature = "gdal")]
use crate::raster::{DrapeError, PointsError, ShapesError, ViewError, WriteError};
use crate::verify::VerifyError;

/// Why a run did not get through. Nothing is left under the output's name then.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Features that do not go together: all conflicts.
    #[error(transparent)]
    Incompatible(#[from] Incompatible),
    /// The raster, or its cutline.
    #[cfg(feature = "gdal")]
    #[error(transparent)]
    View(#[from] ViewError),
    /// A band that is to be an attribute.
    #[error(transparent)]
    Attribute(RasterError),
    /// The samples of an image are numbers of colours in a table, and no bands are named.
    #[error(transparent)]
    ColourTable(RasterError),
    /// The importance raster.
    #[error(transparent)]
    Importance(RasterError),
    /// The layer of points.
    #[cfg(feature = "gdal")]
    #[error(transparent)]
    Points(#[from] PointsError),
    /// A layer of lines that become edges.
    #[cfg(feature = "gdal")]
    #[error("{error}")]
    Shapes {
        /// What the lines are.
        kind: LineKind,
        /// What is wrong with it.
        error: ShapesError,
    },
    /// Lines that become edges.
    #[error(transparent)]
    Lines(#[from] UnusableLines),
    /// The image that is to lie over the mesh.
    #[cfg(feature = "gdal")]
    #[error(transparent)]
    Texture(#[from] DrapeError),
    /// The extension of the output says no format, and none is named.
    #[error("{}: expected an extension of a format of meshes ({known}), found {found}", path.display())]
    Format {
        /// The output.
        path: PathBuf,
        /// The extensions there are.
        known: String,
        /// The extension.
        found: String,
    },
    /// The format does not take an option.
    #[error("{}: expected a format with {option} ({formats}), found {format}", path.display())]
    FormatOption {
        /// The output.
        path: PathBuf,
        /// The format.
        format: &'static str,
        /// The option.
        option: SinkOption,
        /// The formats that take it.
        formats: String,
    },
    /// Single precision does not tell the places of vertices apart.
    #[error(
        "{}: expected quarters of cells that single precision tells apart, found {width} × {height} samples, too many for it",
        path.display()
    )]
    Indistinct {
        /// The raster.
        path: PathBuf,
        /// Samples across.
        width: usize,
        /// Samples down.
        height: usize,
    },
    /// Heights lose more in writing than half of what they may be off.
    #[error(
        "{}: expected to lose at most half of the {what} {limit} in writing heights, found a loss of up to {loss:.2e} with \
         heights up to {largest}",
        path.display()
    )]
    Loss {
        /// The raster.
        path: PathBuf,
        /// Of what: the tolerance, or the root mean square.
        what: &'static str,
        /// What heights may be off.
        limit: f64,
        /// What they lose.
        loss: f64,
        /// The largest of them.
        largest: f64,
        /// Whether they are written in single precision.
        single: bool,
    },
    /// A run that is made in shards has to do without a goal.
    #[error(transparent)]
    NotInShards(#[from] NotInShards),
    /// A run in shards is laid out in a work dir.
    #[error("expected a request that names a work dir, found none")]
    NoWorkDir,
    /// The job has no such pass.
    #[error("expected a pass from 1 to {passes}, found {pass}")]
    NoSuchPass {
        /// How many there are.
        passes: usize,
        /// The one that was asked for.
        pass: usize,
    },
    /// So many threads cannot be started.
    #[error("{threads} threads cannot be started: {reason}")]
    Threads {
        /// How many.
        threads: usize,
        /// What the system says.
        reason: String,
    },
    /// A vertex of the mesh that is converted is nowhere.
    #[error("{}: vertex {vertex}: expected finite coordinates, found {found:?}", path.display())]
    NotFinite {
        /// The mesh.
        path: PathBuf,
        /// The vertex, from 0.
        vertex: u64,
        /// Its coordinates.
        found: [f64; 3],
    },
    /// A mesh that is converted cannot be placed as asked.
    #[error("{}: expected map coordinates and heights as they are, found {found}", path.display())]
    Placed {
        /// The mesh.
        path: PathBuf,
        /// What its header says.
        found: &'static str,
    },
    /// The mesh that is converted.
    #[error(transparent)]
    Mesh(#[from] ReadError),
    /// Temporary files.
    #[error(transparent)]
    Scratch(#[from] ScratchError),
    /// Judging a mesh.
    #[error(transparent)]
    Verify(#[from] VerifyError),
    /// The checkpoints.
    #[error(transparent)]
    Checkpoints(#[from] CheckpointError),
    /// The raster of errors.
    #[cfg(feature = "gdal")]
    #[error(transparent)]
    ErrorRaster(#[from] WriteError),
    /// The work.
    #[error(transparent)]
    Job(Box<Error>),
    /// The work, where finished tiles are kept.
    #[error("{error}")]
    Kept {
        /// What it ended by.
        error: Box<Error>,
        /// The work dir.
        dir: PathBuf,
        /// What becomes of the tiles.
        fate: Fate,
    },
}

/// What becomes of finished tiles in a work dir once a run has ended early.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fate {
    /// The same request goes on with them.
    Continue,
    /// They are not all there.
    Incomplete {
        /// The pass, from 1, that has to be made; `None` for all, at the tolerance that a search tries next.
        pass: Option<usize>,
    },
    /// One of them is damaged, or of another run.
    Damaged,
    /// They were made from an input that has changed since; by name the files that differ, as far as they are known.
    Outdated(Vec<String>),
}

impl RunError {
    pub(super) fn of_look(error: LookError) -> RunError {
        match error {
            LookError::Raster(error) => error.into(),
            LookError::Cancelled(stopped) => Error::from(stopped).into(),
        }
    }

    /// What the work ended by, if it had begun.
    pub fn of_job(&self) -> Option<&Error> {
        match self {
            RunError::Job(error) | RunError::Kept { error, .. } => Some(error),
            _ => None,
        }
    }
}

macro_rules! of_the_job {
    ($($error:ty),*) => {$(
        impl From<$error> for RunError {
            fn from(error: $error) -> RunError {
                RunError::Job(Box::new(error.into()))
            }
        }
    )*};
}
of_the_job!(RasterError, FieldError, OutputError, SinkError, WorkDirError, BudgetTooSmall);

impl From<Error> for RunError {
    fn from(error: Error) -> RunError {
        RunError::Job(Box::new(error))
    }
}
