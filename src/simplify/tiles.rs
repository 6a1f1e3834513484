use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::pool::Pool;
use super::{Error, Mesh, Params};
use crate::control::{Cancelled, Control, Stage};
use crate::exact::MAX_TOLERANCE;
use crate::faults::{self, Point};
use crate::field::{Field, Tile};
use crate::lattice::MAX_TILE_CELLS;
use crate::measure::measure;
use crate::mesh::TileMesh;
use crate::raster::{RasterError, Window};
use crate::seam::{MinLink, Rim};
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

/// How a raster of this size is cut.
///
/// # Errors
/// [`Error::Tile`] if a tile is longer than places in it can be exact.
pub fn grid(width: usize, height: usize, params: &Params) -> Result<TileGrid, Error> {
    let grid = TileGrid::new(width, height, params.tile);
    if grid.fits_lattice() {
        return Ok(grid);
    }
    let longest = width.max(height) - 1;
    let found = if params.tile == 0 { longest } else { params.tile.min(longest) };
    Err(Error::Tile { limit: MAX_TILE_CELLS, found })
}

/// Makes sure that the engine keeps the weighted error of fields with channels.
///
/// # Errors
/// [`Error::Channels`] if it does not.
pub fn must_keep_channels(_: &Params) -> Result<(), Error> {
    if GreedyCuts::KEEPS_CHANNELS { Ok(()) } else { Err(Error::Channels { engine: "greedy cuts" }) }
}

/// Triangulates a field on the threads of the current rayon pool.
///
/// Memory: one `Workspace` per busy thread (a tile's samples, its front and its mesh), whatever the size of the field.
/// Temporary disk: about 20 bytes per triangle, and 2 KiB per tile for the histogram of its errors.
///
/// # Errors
/// [`Error`]; nothing is left behind.
pub fn triangulate(field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
    let spool = Spool::new(&params.temp_dir, grid(field.width(), field.height(), params)?.len())?;
    triangulate_into(spool, field, params, control)
}

/// Does what [`triangulate`] does, into a spool for as many tiles as [`grid`] says. A tile whose chunk the
/// spool has already is not made again.
///
/// # Errors
/// [`Error`]; what becomes of the finished tiles is the spool's matter.
pub fn triangulate_into(spool: Spool, field: &Field, params: &Params, control: &Control<'_>) -> Result<Mesh, Error> {
    if !(params.max_error.is_finite() && params.max_error >= 0.0) {
        return Err(Error::Tolerance(params.max_error));
    }
    if field.channel_error().is_some() {
        must_keep_channels(params)?;
    }
    let grid = grid(field.width(), field.height(), params)?;
    assert_eq!(spool.tiles(), grid.len(), "chunks of a spool for this grid");
    let clocks = Clocks::default();
    let found = AtomicU64::new(0);
    control.progress.begin(Stage::Triangulate, grid.len() as u64, field.width() as u64 * field.height() as u64);
    let job = Job { field, params, grid, control };
    let workspaces = Pool::default();
    (0..grid.len()).into_par_iter().try_for_each(|index| {
        control.cancel.check()?;
        faults::reach(Point::TileBegun);
        let (samples, was_there) = workspaces.with(|w: &mut Workspace| w.provide(&job, index, &spool, &clocks))?;
        if was_there {
            found.fetch_add(1, Ordering::Relaxed);
            control.progress.found(Stage::Triangulate, samples);
            return Ok(());
        }
        control.progress.step(Stage::Triangulate, samples);
        Ok::<(), Error>(())
    })?;
    control.progress.end(Stage::Triangulate);
    let (found, times) = (found.into_inner(), clocks.read());
    let channels = field.channels().to_vec();
    let (geo_transform, max_error) = (field.geo_transform(), params.max_error);
    Ok(Mesh { spool, grid, geo_transform, channels, max_error, times, found })
}

/// What all tiles of a run have in common.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) field: &'a Field,
    pub(super) params: &'a Params,
    pub(super) grid: TileGrid,
    pub(super) control: &'a Control<'a>,
}

/// What one thread needs to take a tile from its samples to the spool; reused from tile to tile.
#[derive(Default)]
pub(super) struct Workspace {
    tile: Tile,
    min_link: MinLink,
    engine: <GreedyCuts as Engine>::Scratch,
    mesh: TileMesh,
    chunk: Chunk,
    encoded: Vec<u8>,
}

impl Workspace {
    /// Sees to it that the spool has a tile's chunk. Returns how many samples the tile owns, and whether the chunk was
    /// there already.
    fn provide(&mut self, job: &Job<'_>, index: usize, spool: &Spool, clocks: &Clocks) -> Result<(u64, bool), Error> {
        Ok(match self.find(job, index, spool)? {
            Some(samples) => (samples, true),
            None => (self.run(job, index, spool, clocks)?, false),
        })
    }

    /// Takes over a chunk that the spool has; returns how many samples its tile owns. Where the raster may have changed
    /// since, the tile's samples are loaded and compared with those the chunk was made from.
    fn find(&mut self, job: &Job<'_>, index: usize, spool: &Spool) -> Result<Option<u64>, Error> {
        if !spool.find(index, &mut self.chunk, &mut self.encoded)? {
            return Ok(None);
        }
        if spool.check_samples() {
            let Job { field, grid, .. } = *job;
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

    /// Takes one tile from its samples to the spool. Returns how many samples the tile owns.
    fn run(&mut self, job: &Job<'_>, index: usize, spool: &Spool, clocks: &Clocks) -> Result<u64, Error> {
        let Job { field, params, grid, control } = *job;
        let id = grid.tile(index);
        let last = (grid.is_last_column(id), grid.is_last_row(id));
        let window = grid.window(id);
        clocks.load.time(|| field.load(window, &mut self.tile))?;
        let rim =
            clocks.seams.time(|| Rim::new(&self.tile, tolerance(params), last, &mut self.min_link, &control.cancel))?;
        clocks.cuts.time(|| self.cut(params, &rim, control))?;
        let origin = (window.column as u64, window.row as u64);
        let errors = clocks.measure.time(|| measure(&self.tile, &self.mesh, tolerance(params), origin, last));
        let samples = errors.samples;
        clocks.spool.time(|| {
            self.chunk.fill(index, &rim, &self.mesh, errors, self.tile.checksum());
            let names = field.channels().iter().map(|c| c.name.as_str());
            self.chunk.set_attributes(names, |channel, vertex| self.tile.channel_at_vertex(channel, vertex));
            spool.append(&self.chunk, &mut self.encoded)
        })?;
        Ok(samples)
    }

    /// Triangulates one tile and returns how many samples and triangles it has.
    pub(super) fn probe(&mut self, job: &Job<'_>, index: usize) -> Result<(usize, usize), Error> {
        let id = job.grid.tile(index);
        job.field.load(job.grid.window(id), &mut self.tile)?;
        let tolerance = tolerance(job.params);
        let rim = Rim::new(&self.tile, tolerance, (true, true), &mut self.min_link, &job.control.cancel)?;
        self.cut(job.params, &rim, job.control)?;
        Ok((self.tile.width() * self.tile.height(), self.mesh.triangles.len()))
    }

    fn cut(&mut self, params: &Params, rim: &Rim, control: &Control<'_>) -> Result<(), Cancelled> {
        let task = Task {
            tile: &self.tile,
            domain: &rim.domain,
            tolerance: tolerance(params),
            feasibility: params.feasibility,
            cancel: &control.cancel,
        };
        GreedyCuts.triangulate(&task, &mut self.engine, &mut self.mesh)
    }
}

/// The tolerance that tiles work with: larger ones than heights can need change nothing, and would overflow.
fn tolerance(params: &Params) -> f64 {
    params.max_error.min(MAX_TOLERANCE)
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
