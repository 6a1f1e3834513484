use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::{Error, Mesh, Params};
use crate::control::{Control, Stage};
use crate::faults::{self, Point};
use crate::field::{Field, Tile};
use crate::measure::Meter;
use crate::mesh::TileMesh;
use crate::raster::{RasterError, Window};
use crate::seam::Rim;
use crate::spool::{Chunk, Spool};
use crate::tiling::TileGrid;
use crate::triangulate::cuts::GreedyCuts;
use crate::triangulate::{Engine, Task};

/// Seconds of all threads together, by what a tile goes through.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct TileTimes {
    /// Copying samples out of the field.
    pub load: f64,
    /// The sides.
    pub seams: f64,
    /// The engine.
    pub cuts: f64,
    /// Measuring the errors of the finished mesh.
    pub measure: f64,
    /// Keeping the finished tile.
    pub spool: f64,
}

/// Triangulates a field on the threads of the current rayon pool.
///
/// Memory: one [`Workspace`] per thread (a tile's samples, its front and its mesh), whatever the size of the field.
/// Temporary disk: about 20 bytes per triangle.
///
/// # Errors
/// [`Error`]; nothing is left behind.
pub fn triangulate(field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
    let spool = Spool::new(&params.temp_dir, params.grid(field)?.len())?;
    triangulate_into(spool, field, params, control)
}

/// Does what [`triangulate`] does, into a spool for as many tiles as [`Params::grid`] says. A tile whose chunk the
/// spool has already is not made again.
///
/// # Errors
/// [`Error`]; what becomes of the finished tiles is the spool's matter.
pub fn triangulate_into(spool: Spool, field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
    if !(params.max_error.is_finite() && params.max_error >= 0.0) {
        return Err(Error::Tolerance(params.max_error));
    }
    let grid = params.grid(field)?;
    assert_eq!(spool.tiles(), grid.len(), "chunks of a spool for this grid");
    let clocks = Clocks::default();
    let found = AtomicU64::new(0);
    control.progress.begin(Stage::Triangulate, grid.len() as u64, field.width() as u64 * field.height() as u64);
    (0..grid.len()).into_par_iter().try_for_each_init(Workspace::default, |workspace, index| {
        control.cancel.check()?;
        faults::reach(Point::TileBegun);
        if let Some(samples) = workspace.find(field, grid, index, &spool)? {
            found.fetch_add(1, Ordering::Relaxed);
            control.progress.found(Stage::Triangulate, samples);
            return Ok(());
        }
        let samples = workspace.run(field, params, control, grid, index, &spool, &clocks)?;
        control.progress.step(Stage::Triangulate, samples);
        Ok::<(), Error>(())
    })?;
    control.progress.end(Stage::Triangulate);
    let (found, times) = (found.into_inner(), clocks.read());
    Ok(Mesh { spool, grid, geo_transform: field.geo_transform(), max_error: params.max_error, times, found })
}

/// What one thread needs to take a tile from its samples to the spool; reused from tile to tile.
#[derive(Default)]
struct Workspace {
    tile: Tile,
    mesh: TileMesh,
    meter: Meter,
    chunk: Chunk,
    encoded: Vec<u8>,
}

impl Workspace {
    /// Takes over a chunk that the spool has; returns how many samples its tile owns. Where the raster may have changed
    /// since, the tile's samples are loaded and compared with those the chunk was made from.
    fn find(&mut self, field: &Field, grid: TileGrid, index: usize, spool: &Spool) -> Result<Option<u64>, Error> {
        if !spool.find(index, &mut self.chunk, &mut self.encoded)? {
            return Ok(None);
        }
        if spool.check_samples() {
            let window = grid.window(grid.tile(index));
            field.load(window, &mut self.tile)?;
            let (expected, found) = (self.chunk.samples_checksum, self.tile.checksum());
            if expected != found {
                let Window { column, row, width, height } = window;
                let what = format!("{width} × {height} samples at column {column}, row {row} with the checksum");
                let [expected, found] = [expected, found].map(|checksum| format!("{checksum:08x}"));
                return Err(RasterError::Changed { path: field.name().to_path_buf(), what, expected, found }.into());
            }
        }
        Ok(Some(self.chunk.errors.samples))
    }

    /// Returns how many samples the tile owns.
    #[allow(clippy::too_many_arguments)]
    fn run(
        &mut self,
        field: &Field,
        params: &Params,
        control: &Control<'_>,
        grid: TileGrid,
        index: usize,
        spool: &Spool,
        clocks: &Clocks,
    ) -> Result<u64, Error> {
        let id = grid.tile(index);
        let last = (grid.is_last_column(id), grid.is_last_row(id));
        let window = grid.window(id);
        clocks.load.time(|| field.load(window, &mut self.tile))?;
        let rim = clocks.seams.time(|| Rim::new(&self.tile, params.max_error, last.0, last.1));
        let task = Task {
            tile: &self.tile,
            domain: &rim.domain,
            tolerance: params.max_error,
            feasibility: params.feasibility,
            cancel: &control.cancel,
        };
        clocks.cuts.time(|| GreedyCuts.triangulate(&task, &mut self.mesh))?;
        let origin = (window.column as u64, window.row as u64);
        let errors = clocks.measure.time(|| self.meter.measure(&self.tile, &self.mesh, params.max_error, origin, last));
        let samples = errors.samples;
        clocks.spool.time(|| {
            self.chunk.fill(index, &rim, &self.mesh, errors, self.tile.checksum());
            spool.append(&self.chunk, &mut self.encoded)
        })?;
        Ok(samples)
    }
}

#[derive(Default)]
struct Clocks {
    load: Clock,
    seams: Clock,
    cuts: Clock,
    measure: Clock,
    spool: Clock,
}

impl Clocks {
    fn read(&self) -> TileTimes {
        TileTimes {
            load: self.load.seconds(),
            seams: self.seams.seconds(),
            cuts: self.cuts.seconds(),
            measure: self.measure.seconds(),
            spool: self.spool.seconds(),
        }
    }
}

/// Nanoseconds, added up over threads.
#[derive(Default)]
struct Clock(AtomicU64);

impl Clock {
    fn time<T>(&self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.0.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }

    fn seconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-9
    }
}
