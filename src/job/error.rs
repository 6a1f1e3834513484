use std::path::PathBuf;

use super::{BudgetTooSmall, DiskTooSmall, GoalTooSmall};
use crate::base::RasterError;
use crate::base::control::Cancelled;
use crate::base::staged::OutputError;
use crate::field::FieldError;
use crate::formats::SinkError;
use crate::job::spool::SpoolError;
use crate::job::work_dir::WorkDirError;
use crate::kernel::boundary::MAX_CELLS;
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
    /// The engine does not keep errors in channels.
    #[error("engine {engine} does not bound errors in channels")]
    Channels {
        /// The engine.
        engine: &'static str,
    },
    /// There are channels, and a budget or a root mean square to end at.
    #[error("channels cannot be combined with a budget or a root mean square")]
    GoalWithChannels,
    /// There are channels, and a mesh is to be polished, which keeps heights alone.
    #[error("channels cannot be combined with polishing, found quality {quality}")]
    PolishWithChannels {
        /// The quality.
        quality: &'static str,
    },
    /// There are points, but the engine cannot make vertices of them.
    #[error("engine {engine} cannot make vertices of given points")]
    NoPreinsertion {
        /// The engine.
        engine: &'static str,
    },
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
    /// The engine makes its triangles once and for all: it cannot stop at a budget.
    #[error("engine {engine} cannot stop at a budget or a root mean square")]
    NoGoal {
        /// The engine.
        engine: &'static str,
    },
    /// Passes that insert many samples cannot stop at one of them, and other measures than errors are no thresholds.
    #[error("a budget or a root mean square requires sequential insertion by local error")]
    GoalWithPasses,
    /// A rim under a goal is not there before the insertions are.
    #[error("a budget or a root mean square cannot be combined with trimming, found {0} cells")]
    GoalWithTrim(u32),
    /// What is bridged has no errors to count.
    #[error("a budget or a root mean square cannot be combined with bridged holes, found holes of up to {0} samples")]
    GoalWithHoles(u64),
    /// The rim is to be trimmed by more than anybody means.
    #[error("expected to trim 0 to {MAX_CELLS} cells, found {0}")]
    Trim(u32),
    /// Heights are fitted by polishing.
    #[error("fitted heights require polishing, found quality none")]
    FittedWithoutPolish,
    /// There are numbers for polishing, and none.
    #[error("options of polishing require polishing, found quality none")]
    TuningWithoutPolish,
    /// A number of polishing's schedule.
    #[error(transparent)]
    Schedule(#[from] ScheduleError),
    /// The floor for angles.
    #[error("expected a smallest angle from 0 to 60 degrees, found {0}")]
    MinAngle(f64),
    /// What is polished has other vertices and errors than the engine ended with.
    #[error("a budget or a root mean square cannot be combined with polishing, found quality {quality}")]
    GoalWithPolish {
        /// The quality.
        quality: &'static str,
    },
    /// The budget of vertices or triangles.
    #[error(transparent)]
    Goal(#[from] GoalTooSmall),
    /// A tile is longer than places in it can be exact.
    #[error("expected tiles of at most {limit} cells a side, found {found}; choose a smaller --tile")]
    Tile {
        /// The longest side.
        limit: usize,
        /// What was asked for.
        found: usize,
    },
}
