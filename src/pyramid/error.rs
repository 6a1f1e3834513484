//! What can go wrong with a pyramid.

use std::path::PathBuf;

use super::grid::TileKey;
use crate::base::RasterError;
use crate::base::control::Cancelled;
use crate::field::FieldError;
use crate::job::plan::BudgetTooSmall;
use crate::job::work_dir::WorkDirError;
use crate::raster::{GeodesyError, ViewError};

/// Why no pyramid is made, or none can be judged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PyramidError {
    /// The raster cannot be opened as it is asked for.
    #[error(transparent)]
    View(#[from] ViewError),
    /// The raster cannot be read.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// Samples cannot be read, or kept in a temporary file.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The raster lies on no ellipsoid, or nobody knows how.
    #[error("{}: {source}", path.display())]
    Geodesy {
        /// The raster.
        path: PathBuf,
        /// Why.
        source: GeodesyError,
    },
    /// The memory budget is too small.
    #[error(transparent)]
    Budget(#[from] BudgetTooSmall),
    /// Nothing of the raster has a place on the ellipsoid, or there is nothing between samples with heights.
    #[error(
        "{}: expected a place on the ellipsoid between four samples with heights, found none", path.display()
    )]
    Nothing {
        /// The raster.
        path: PathBuf,
    },
    /// The grid that the raster asks for is out of range.
    #[error("{}: expected samples from {least} to {most}° apart, found {found}°", path.display())]
    Spacing {
        /// The raster.
        path: PathBuf,
        /// The finest.
        least: f64,
        /// The coarsest.
        most: f64,
        /// What there is.
        found: f64,
    },
    /// A level has fewer than eight cells to a tile.
    #[error("expected a finest level of at most {expected} for the raster's samples, found {found}")]
    Level {
        /// The most.
        expected: u32,
        /// What was asked for.
        found: u32,
    },
    /// No triangle of the grid is flat enough.
    #[error(
        "level {level}: triangles of the grid's own size sag under the ellipsoid by more than a quarter of {} m",
        metres(*max_error)
    )]
    Curvature {
        /// The level.
        level: u32,
        /// Its error.
        max_error: f64,
        /// What decides it.
        bound_by: BoundBy,
    },
    /// Heights have to be coarser than the tolerance.
    #[error(
        "tile {tile}: heights of this range can be written in steps of {} m only, which is too coarse for {} m",
        metres(*step),
        metres(*max_error)
    )]
    Step {
        /// The tile.
        tile: TileKey,
        /// The step.
        step: f64,
        /// The level's error.
        max_error: f64,
        /// What decides it.
        bound_by: BoundBy,
        /// Whether steps were asked for that are not below 1/8 m.
        fine_heights: bool,
    },
    /// Rounding, curvature and the ground's steepness leave no mesh.
    #[error(
        "tile {tile}: found no mesh within {} m on the lattice of 32767 places that the format has{}",
        metres(*max_error),
        worst.map(|worst| worst.to_string()).unwrap_or_default()
    )]
    Unreachable {
        /// The tile.
        tile: TileKey,
        /// The level's error.
        max_error: f64,
        /// What decides it.
        bound_by: BoundBy,
        /// The worst sample of the last mesh.
        worst: Option<Worst>,
    },
    /// Samples of the raster itself are so steep or so near to others that the lattice of the format leaves no mesh.
    #[error(
        "tile {tile}: found no mesh within {within} m of the raster's own samples on the lattice of 32767 places that the format has: {count} or \
         more stay beyond, the worst {error:.2} m off at {lon:.6}°, {lat:.6}°",
        within = metres(*max_error)
    )]
    OwnSamples {
        /// The tile.
        tile: TileKey,
        /// The level's error.
        max_error: f64,
        /// What decides it.
        bound_by: BoundBy,
        /// Triangles of the best mesh that have such a sample.
        count: usize,
        /// The largest error, and where it is, in degrees.
        error: f64,
        /// See [`PyramidError::OwnSamples::error`].
        lon: f64,
        /// See [`PyramidError::OwnSamples::error`].
        lat: f64,
    },
    /// A tile needs more vertices than readers can number.
    #[error("tile {tile}: expected at most 65536 vertices, twice those of the border included, found {found}")]
    Vertices {
        /// The tile.
        tile: TileKey,
        /// How many it needs.
        found: usize,
    },
    /// There is something at the output's path.
    #[error("{}: expected an empty folder or nothing, found {found}", path.display())]
    Occupied {
        /// The output.
        path: PathBuf,
        /// What is there.
        found: String,
    },
    /// A file of the finished set that the run has made is not as it was written.
    #[error(
        "{}: expected the file of {expected} bytes that was written, found {}", path.display(), of_length(*found)
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// Its length.
        expected: String,
        /// What it has now; `None` where there is no such file.
        found: Option<u64>,
    },
    /// A file or folder cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The work dir cannot be used.
    #[error(transparent)]
    WorkDir(WorkDirError),
    /// A run in shards needs a work dir.
    #[error("expected a work dir in the request for a run in shards, found none")]
    NoWorkDir,
    /// A work dir is without the samples of the grid.
    #[error("{}: expected the samples of the grid in the work dir, found none", dir.display())]
    Gone {
        /// The work dir.
        dir: PathBuf,
    },
    /// Samples of the grid are not those that were written.
    #[error("{}: expected the samples of the grid as they were written, found others in block {block}", dir.display())]
    Damaged {
        /// The folder that their file is in.
        dir: PathBuf,
        /// The number of 64 × 64 samples.
        block: u64,
    },
    /// Tiles of a run in shards that nobody has made yet.
    #[error("expected all {of} tiles, found {} missing: {}", missing.len(), first(missing))]
    Missing {
        /// Which.
        missing: Vec<TileKey>,
        /// Tiles of the run.
        of: u64,
    },
    /// The run has a work dir, which keeps what is finished.
    #[error("{error}")]
    Kept {
        /// Why it did not get through.
        error: Box<PyramidError>,
        /// The work dir.
        dir: PathBuf,
        /// Where the raster has changed: the files that are not as they were when the work dir was made.
        outdated: Option<Vec<String>>,
    },
    /// A folder holds no set of tiles.
    #[error("{}: expected a set of tiles made by terrabite, found {found}", path.display())]
    NotTiles {
        /// The file.
        path: PathBuf,
        /// What is there.
        found: String,
    },
    /// The system refuses this number of threads.
    #[error("{threads} threads cannot be started: {reason}")]
    Threads {
        /// How many; 0 for as many as there are cores.
        threads: usize,
        /// What the system said.
        reason: String,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What of a request decides the error of a level: what has to be larger for the level to be allowed more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BoundBy {
    /// [`TilesRequest::max_error`](super::TilesRequest::max_error).
    #[default]
    MaxError,
    /// [`TilesRequest::error_factor`](super::TilesRequest::error_factor): a level above the finest has as much as clients expect, times
    /// the factor.
    ErrorFactor,
}

impl BoundBy {
    /// Of a level with this error, where it may have `loosest` at the most. At the finest level more than the largest error that is asked
    /// for is never allowed; a larger one also makes a coarser level the finest.
    pub(super) fn of(max_error: f64, loosest: f64, is_finest: bool) -> BoundBy {
        if !is_finest && max_error >= loosest { BoundBy::ErrorFactor } else { BoundBy::MaxError }
    }
}

/// A sample that no mesh has been found for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    /// How far off it is, in metres.
    pub error: f64,
    /// Where it is, in degrees.
    pub lon: f64,
    /// See [`Worst::lon`].
    pub lat: f64,
    /// Whether it is beside the raster's rim or a void, where the surface falls to the height outside.
    pub is_at_rim: bool,
}

impl std::fmt::Display for Worst {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Worst { error, lon, lat, is_at_rim } = self;
        write!(f, ": the worst sample is {error:.2} m off at {lon:.6}°, {lat:.6}°")?;
        if *is_at_rim { write!(f, ", beside the raster's rim or missing samples") } else { Ok(()) }
    }
}

/// A length as reports have it, to the millimetre, without zeros at its end.
fn metres(length: f64) -> String {
    format!("{length:.3}").trim_end_matches('0').trim_end_matches('.').to_string()
}

/// What is found of a file.
fn of_length(found: Option<u64>) -> String {
    found.map_or("none".to_string(), |bytes| format!("one of {bytes} bytes"))
}

/// The first of some tiles.
fn first(tiles: &[TileKey]) -> String {
    const MOST: usize = 5;
    let named = tiles.iter().take(MOST).map(TileKey::to_string);
    named.chain((tiles.len() > MOST).then(|| "…".to_string())).collect::<Vec<_>>().join(", ")
}

impl PyramidError {
    /// The same, of a level whose error is decided by that.
    pub(super) fn of_level(mut self, by: BoundBy) -> PyramidError {
        if let PyramidError::Step { bound_by, .. }
        | PyramidError::Unreachable { bound_by, .. }
        | PyramidError::OwnSamples { bound_by, .. } = &mut self
        {
            *bound_by = by;
        }
        self
    }

    /// Whether the ground is in the way of a tile: smaller parts, or more error, may do.
    pub(super) fn is_of_the_ground(&self) -> bool {
        matches!(
            self,
            PyramidError::Unreachable { .. } | PyramidError::OwnSamples { .. } | PyramidError::Vertices { .. }
        )
    }

    /// Whether no run of the same request can succeed.
    pub(super) fn is_final(&self) -> bool {
        matches!(
            self,
            PyramidError::Nothing { .. }
                | PyramidError::Level { .. }
                | PyramidError::Curvature { .. }
                | PyramidError::Step { .. }
                | PyramidError::Unreachable { .. }
                | PyramidError::OwnSamples { .. }
                | PyramidError::Vertices { .. }
                | PyramidError::Damaged { .. }
                | PyramidError::Altered { .. }
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_rounded_in_messages() {
        assert_eq!([1.0, 0.001, 1204.1771840618535, 20.0, 9.25].map(metres), ["1", "0.001", "1204.177", "20", "9.25"]);
        let level = PyramidError::Curvature { level: 3, max_error: 1204.1771840618535, bound_by: BoundBy::MaxError };
        assert!(level.to_string().ends_with(" of 1204.177 m"), "{level}");
    }
}
