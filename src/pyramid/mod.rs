//! A pyramid of terrain tiles (quantized-mesh 1.0) in which every level keeps a stated error.
//!
//! In comes a raster; out goes a folder of tiles with its manifest. `budget` says how many threads have memory, `prepare` opens the raster, and `ground` finds out of it what tiles
//! are made from, which a work dir keeps (`kept`), so that a run can be interrupted, or made by many processes (`shards`). `source` gives the heights of the finest grid (`grid`), a
//! fixed grid of longitudes and latitudes not coarser than the raster, and `samples` keeps them (`store`; `outline`: what coarse levels need of a block). A level is made tile by
//! tile: `lines` finds the sides, which depend on their line and the level alone, `part` makes meshes with the engines of
//! [`crate::kernel`], both of samples that have the curvature of the ellipsoid in them (`fall`), `quantize` brings places and heights onto the lattice that the format has, so that tiles of a level share
//! every vertex on their border, `rim` rounds those at the raster's rim away from it, `surface` is the tile as decoded, `measure` compares that with all samples (`facet`: one triangle; `rough`: many samples at once; `own`: those of the raster itself), and `tile` mends
//! what is beyond the error; `strays` does that of edges that are too far off between samples. `holes` leaves triangles out that are over voids (`voids`). `encode`, `normals`, `manifest` and `write` make files of it.
//!
//! **The promise.** Every tile of level L, as decoded, is within ε_L of every sample of the finest grid that the raster gives a
//! height, along the normal of the ellipsoid. It does not rest on how the mesh was made: `measure` finds the distance of each
//! sample from the very vertices that are written, adds a bound of its rounding, and a tile that fails is mended or refused.
//! Samples that the raster gives no height, and those beyond its outermost samples, have the height that is taken outside;
//! nothing is promised there, and near the raster's border the surface runs from one to the other. The same is true of voids, which may
//! have a height of their own, or be holes: what is left of a tile has every sample of the raster then, within the error.
//!
//! **Memory.** A thread holds the samples of a part (at most 513 × 513, with heights and weights), a window of 256 × 256 samples,
//! the mesh of one tile of at most 65,536 vertices with what is known of its triangles while it is mended, and blocks
//! that it has read. `budget` reckons beforehand, and keeps to what is allowed. Samples of the grid,
//! 8 bytes each, are in an unlinked temporary file or in the work dir (`store`), and read from there: none of it is mapped.
//!
//! **The same bytes.** Tiles depend on the raster and the options, not on threads or on the system's mathematics (sines and cosines are
//! those of the crate `libm`). PROJ decides them, too: another version may move a place by the last bit.

mod body;
mod budget;
#[cfg(test)]
mod budget_tests;
mod encode;
mod error;
mod facet;
mod fall;
mod grid;
mod ground;
mod holes;
mod kept;
mod lines;
mod make;
mod manifest;
mod measure;
#[cfg(test)]
mod measure_tests;
mod normals;
mod outline;
mod own;
mod part;
mod prepare;
mod quantize;
mod report;
mod rim;
mod rough;
mod samples;
mod shards;
mod source;
mod store;
mod strays;
mod surface;
#[cfg(test)]
mod tests;
mod tile;
mod voids;
mod write;

use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::path::PathBuf;

pub use body::Body;
pub use error::{BoundBy, PyramidError, Worst};
pub use grid::{Grid, Level, TileKey};
pub use manifest::{LAYER, Layer, PROMISE, Promise, Range};
pub use report::{LevelReport, TilesReport};
pub(crate) use samples::{Block as SampleBlock, Patch, Samples};
pub use shards::{TilesLayout, TilesShare, lay_out_tiles, merge_tiles, work_on_tiles};
pub use voids::VoidAs;
pub(crate) use write::EARLIER_SET;

use self::budget::Memory;
use crate::base::control::Control;
use crate::job::plan::Fitted;
use crate::raster::View;

/// What tiles are made from, and how.
#[derive(Debug, Clone)]
pub struct TilesRequest {
    /// The raster.
    pub input: PathBuf,
    /// How it is looked at.
    pub view: View,
    /// The folder.
    pub output: PathBuf,
    /// The largest error of the finest level, in metres.
    pub max_error: f64,
    /// The finest level; `None`: the coarser of the first whose client error is not above `max_error`, and the first whose
    /// tiles have at most 128 cells of the finest grid.
    pub max_level: Option<u32>,
    /// No level's error is larger than this times the client's.
    pub error_factor: f64,
    /// A power of two: how many cells the grid has where the raster's samples ask for one.
    pub grid_factor: u32,
    /// The vertical CRS of the heights, where the raster does not say, or says another.
    pub vertical_crs: Option<String>,
    /// The height in metres above the ellipsoid outside of the raster.
    pub outside: f64,
    /// What tiles have where it has voids.
    pub void_as: VoidAs,
    /// Whether the heights of a tile's header are so far apart that CesiumJS keeps floats and does not round to 12 bits: steps are
    /// not below 1/8 m then.
    pub fine_heights: bool,
    /// Between samples of the grid, edges are within this times the level's error of the heights around; infinite: they may be anywhere. With
    /// `own_samples` nothing is promised there.
    pub max_stray: f64,
    /// Whether tiles are within their errors at the raster's own samples, too, not only at those of the grid.
    pub own_samples: bool,
    /// Whether files are compressed.
    pub gzip: bool,
    /// Whether an earlier set of tiles may be replaced.
    pub overwrite: bool,
    /// A folder that keeps what is finished, so that the same request continues there after the process was killed.
    pub work_dir: Option<PathBuf>,
    /// Whether that folder stays when the set is there.
    pub keep_work_dir: bool,
    /// The most memory to use; `None` is [`crate::job::default_budget`].
    pub memory: Option<u64>,
    /// Threads, fewer if the memory is for fewer; `None`: as many as there are cores.
    pub threads: Option<NonZeroUsize>,
    /// The folder of temporary files; `None` is the system's.
    pub temp_dir: Option<PathBuf>,
}

impl TilesRequest {
    /// Tiles within this error, everything else as usual.
    pub fn new(input: impl Into<PathBuf>, output: impl Into<PathBuf>, max_error: f64) -> TilesRequest {
        TilesRequest {
            input: input.into(),
            view: View::default(),
            output: output.into(),
            max_error,
            max_level: None,
            error_factor: 1.0,
            grid_factor: 1,
            vertical_crs: None,
            outside: 0.0,
            void_as: VoidAs::Outside,
            fine_heights: false,
            max_stray: 1.5,
            own_samples: false,
            gzip: false,
            overwrite: false,
            work_dir: None,
            keep_work_dir: false,
            memory: None,
            threads: None,
            temp_dir: None,
        }
    }

    /// The limit on straying that is promised, if one is.
    fn promised_stray(&self) -> Option<f64> {
        Some(self.max_stray).filter(|factor| factor.is_finite() && !self.own_samples)
    }

    fn temp_dir(&self) -> PathBuf {
        self.temp_dir.clone().unwrap_or_else(std::env::temp_dir)
    }
}

/// What a set of tiles is judged by.
pub(crate) struct Basis {
    /// The samples that it was made from.
    pub(crate) samples: Samples,
    /// The grid that is not coarser than the raster.
    pub(crate) coarsest: Grid,
    pub(crate) body: Body,
    /// As [`Promise::vertical_crs`].
    pub(crate) vertical_crs: String,
    /// As [`Promise::view`].
    pub(crate) view: BTreeMap<String, String>,
    /// The threads that it is judged by, and their memory.
    pub(crate) memory: Fitted,
}

/// What judging takes, in bytes, beside reading the raster.
pub(crate) struct Judging {
    /// All threads together.
    pub(crate) in_common: u64,
    /// Each thread.
    pub(crate) each: u64,
}

/// Judges a set of tiles on this grid, on as many threads as the request's memory is for.
pub(crate) fn with_basis<T: Send>(
    request: &TilesRequest,
    grid: Grid,
    judging: Judging,
    control: &Control<'_>,
    judge: impl FnOnce(Basis) -> Result<T, PyramidError> + Send,
) -> Result<T, PyramidError> {
    let prepared = prepare::open(request, control)?;
    let memory = Memory::to_judge(&prepared, grid, judging, request)?;
    let fitted = memory.fitted;
    memory.install(move || {
        let (coarsest, view) = (prepared.source.grid(0)?, prepared.view()?);
        let samples = prepare::resample(&prepared, grid, request, control)?;
        let (body, vertical_crs) = (prepared.body, prepared.vertical);
        judge(Basis { samples, coarsest, body, vertical_crs, view, memory: fitted })
    })
}

/// Makes a set of tiles.
///
/// # Errors
/// [`PyramidError`]; nothing is left under the output's name then, and what is finished stays in the work dir, where there is one.
pub fn tiles(request: &TilesRequest, control: &Control<'_>) -> Result<TilesReport, PyramidError> {
    make::make(request, control)
}
