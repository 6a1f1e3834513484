//! Why a job cannot be done.

use std::path::PathBuf;

use super::rules::Incompatible;
use super::shards::MissingTiles;
use super::{BudgetTooSmall, DiskTooSmall, GoalTooSmall};
use crate::base::RasterError;
use crate::base::control::Cancelled;
use crate::base::external::ScratchError;
use crate::base::staged::OutputError;
use crate::field::FieldError;
use crate::formats::SinkError;
use crate::job::spool::SpoolError;
use crate::job::work_dir::WorkDirError;
use crate::kernel::boundary::MAX_CELLS;
use crate::kernel::breaklines::TwoHeights;
use crate::kernel::polish::ScheduleError;

/// Why a mesh could not be made. The variant says which stage could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Opening or reading the raster.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// Making its samples readable, or a sample that is no height.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// Keeping finished tiles.
    #[error(transparent)]
    Spool(#[from] SpoolError),
    /// Keeping lines, and edges that follow them, beside memory.
    #[error(transparent)]
    Scratch(ScratchError),
    /// Writing the output.
    #[error(transparent)]
    Sink(#[from] SinkError),
    /// The output file itself.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The folder that keeps finished tiles.
    #[error(transparent)]
    WorkDir(#[from] WorkDirError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The memory budget.
    #[error(transparent)]
    Budget(#[from] BudgetTooSmall),
    /// The disks.
    #[error(transparent)]
    Disk(#[from] DiskTooSmall),
    /// The tolerance is no usable number.
    #[error("expected a tolerance that is finite and at least 0, found {0}")]
    Tolerance(f64),
    /// Features that do not go together: all conflicts.
    #[error(transparent)]
    Incompatible(#[from] Incompatible),
    /// Chunks of the first pass and of the last do not belong together: they were not made from the same samples, or in the same run.
    #[error(
        "expected {trimmed} samples left uncovered, as the first pass has them, found {bare} in the last: chunks of different runs"
    )]
    Unlike {
        /// Samples that the first pass has left uncovered.
        trimmed: u64,
        /// Those that the last has.
        bare: u64,
    },
    /// Tiles that others have to make before the mesh can be put together.
    #[error(transparent)]
    Missing(#[from] MissingTiles),
    /// No cell of the raster has three heights.
    #[error("{}: expected a cell with three heights at least, found none: there is no ground to triangulate", path.display())]
    NoGround {
        /// The raster.
        path: PathBuf,
    },
    /// A point lies where no ground is.
    #[error("expected points on the ground, found one at column {column}, row {row}, where no cell has three heights")]
    PointOffGround {
        /// The sample's column.
        column: usize,
        /// The sample's row.
        row: usize,
    },
    /// A breakline passes between samples where no double is within the tolerance of the surface.
    #[error(
        "expected a tolerance that heights between samples can keep to, found one that no double at column {column}, row {row} keeps to, on a breakline"
    )]
    LineHeight {
        /// Column of the raster, with fractions.
        column: f64,
        /// Row, with fractions.
        row: f64,
    },
    /// Lines meet at a place where they have several heights.
    #[error(transparent)]
    TwoHeights(#[from] TwoHeights),
    /// The rim is to be trimmed by more than anybody means.
    #[error("expected to trim 0 to {MAX_CELLS} cells, found {0}")]
    Trim(u32),
    /// A number of polishing's schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// The floor for angles.
    #[error("expected a smallest angle from 0 to 60 degrees, found {0}")]
    MinAngle(f64),
    /// The limit on straying.
    #[error("expected a limit on straying of 1 or more, found {0}")]
    MaxStray(f64),
    /// An engine that makes its triangles once and for all, where the rule book has let a goal pass.
    #[error("expected an engine that can stop at a goal, found {engine}")]
    NoStop {
        /// What it is called.
        engine: &'static str,
    },
    /// The budget of vertices or triangles.
    #[error(transparent)]
    Goal(#[from] GoalTooSmall),
    /// A tile is longer than places in it can be exact.
    #[error("expected tiles of at most {limit} cells a side, found {found}")]
    Tile {
        /// The longest side.
        limit: usize,
        /// What was asked for.
        found: usize,
    },
}

impl From<ScratchError> for Error {
    fn from(error: ScratchError) -> Error {
        match error {
            ScratchError::Cancelled(stopped) => Error::Cancelled(stopped),
            file => Error::Scratch(file),
        }
    }
}
