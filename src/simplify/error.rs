use super::{BudgetTooSmall, DiskTooSmall};
use crate::control::Cancelled;
use crate::field::FieldError;
use crate::raster::RasterError;
use crate::sink::SinkError;
use crate::spool::SpoolError;
use crate::staged::OutputError;
use crate::work_dir::WorkDirError;

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
    #[error("{engine} does not keep the error in channels")]
    Channels {
        /// The engine.
        engine: &'static str,
    },
    /// A tile is longer than places in it can be exact.
    #[error("expected tiles of at most {limit} cells a side, found {found}; choose a smaller --tile")]
    Tile {
        /// The longest side.
        limit: usize,
        /// What was asked for.
        found: usize,
    },
}
