use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::engine::EngineScratch;
use super::goal::Told;
use super::in_order::{End, find_end};
use super::pool::Pool;
use super::{Error, Mesh, Params, Quality};
use crate::control::{Cancelled, Control, Stage};
use crate::exact::MAX_TOLERANCE;
use crate::faults::{self, Point};
use crate::field::{Field, Tile};
use crate::lattice::MAX_TILE_CELLS;
use crate::measure::{Bound, measure, shape};
use crate::mesh::TileMesh;
use crate::raster::{RasterError, Window};
use crate::seam::{MinLink, Rim};
use crate::spool::{Chunk, Spool};
use crate::tiling::TileGrid;
use crate::triangulate::Task;

/// Seconds of all threads together, by what a tile goes through.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct TileTimes {
    /// Copying samples out of the field.
    pub load: f64,
    /// The sides.
    pub seams: f64,
    /// The engine.
    pub engine: f64,
    /// Polishing.
    pub polish: f64,
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
    // Under a goal the tolerance may be left open.
    let open = params.max_error == f64::INFINITY && !params.goal.is_none();
    if !(params.max_error.is_finite() && params.max_error >= 0.0 || open) {
        return Err(Error::Tolerance(params.max_error));
    }
    if field.channel_error().is_some() {
        params.takes_channels()?;
    }
    if params.points.as_ref().is_some_and(|p| !p.is_empty()) {
        params.takes_points()?;
    }
    let grid = grid(field.width(), field.height(), params)?;
    assert_eq!(spool.tiles(), grid.len(), "chunks of a spool for this grid");
    let clocks = Clocks::default();
    let found = AtomicU64::new(0);
    let workspaces = Pool::default();
    let mut job = Job { field, params, grid, control, end: None };
    job.end = find_end(&job, &workspaces)?;
    control.progress.begin(Stage::Triangulate, grid.len() as u64, field.width() as u64 * field.height() as u64);
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
    Ok(Mesh {
        spool,
        grid,
        geo_transform: field.geo_transform(),
        channels: field.channels().to_vec(),
        max_error: params.max_error,
        error_scale: job.end.map_or(params.max_error, |end| end.scale(&job)),
        outcome: job.end.map(|end| end.outcome),
        times,
        survey_bytes: job.end.map_or(0, |end| end.survey_bytes),
        found,
    })
}

/// What all tiles of a run have in common.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) field: &'a Field,
    pub(super) params: &'a Params,
    pub(super) grid: TileGrid,
    pub(super) control: &'a Control<'a>,
    /// Where tiles end, under a goal.
    pub(super) end: Option<End>,
}

/// What one thread needs to take a tile from its samples to the spool; reused from tile to tile.
#[derive(Default)]
pub(super) struct Workspace {
    pub(super) tile: Tile,
    pub(super) points: Vec<(usize, usize)>,
    min_link: MinLink,
    pub(super) engine: EngineScratch,
    pub(super) mesh: TileMesh,
    chunk: Chunk,
    pub(super) encoded: Vec<u8>,
    pub(super) told: Vec<Told>,
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
                let samples = if self.tile.is_weighted() { "samples and weights" } else { "samples" };
                let what = format!("{width} × {height} {samples} at column {column}, row {row} with the checksum");
                let [expected, found] = [expected, found].map(|checksum| format!("{checksum:08x}"));
                return Err(RasterError::Changed { path: field.name().to_path_buf(), what, expected, found }.into());
            }
        }
        Ok(Some(self.chunk.errors.samples))
    }

    /// Takes one tile from its samples to the spool. Returns how many samples the tile owns.
    fn run(&mut self, job: &Job<'_>, index: usize, spool: &Spool, clocks: &Clocks) -> Result<u64, Error> {
        let Job { field, params, grid, .. } = *job;
        let id = grid.tile(index);
        let last = (grid.is_last_column(id), grid.is_last_row(id));
        let window = grid.window(id);
        let (rim, bound) = match &job.end {
            None => {
                clocks.load.time(|| field.load(window, &mut self.tile))?;
                let rim = clocks.seams.time(|| self.rim(job, window, last))?;
                clocks.engine.time(|| self.cut(job, &rim))?;
                clocks.polish.time(|| self.polish(job, &rim))?;
                (rim, Bound::Within(tolerance(params)))
            }
            Some(end) => clocks.engine.time(|| self.run_to(job, index, end))?,
        };
        let origin = (window.column as u64, window.row as u64);
        let errors = clocks.measure.time(|| {
            let mut errors = measure(&self.tile, &self.mesh, bound, origin, last);
            // Whoever has no time for polishing has none for looking at it.
            if params.quality != Quality::None {
                errors.shape = Some(Box::new(shape(&self.tile, &self.mesh, tolerance(params))));
            }
            errors
        });
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
        let window = job.grid.window(id);
        job.field.load(window, &mut self.tile)?;
        let rim = self.rim(job, window, (true, true))?;
        self.cut(job, &rim)?;
        self.polish(job, &rim)?;
        Ok((self.tile.width() * self.tile.height(), self.mesh.triangles.len()))
    }

    /// The rim of the tile that is loaded, and the points inside it.
    fn rim(&mut self, job: &Job<'_>, window: Window, last: (bool, bool)) -> Result<Rim, Cancelled> {
        self.find_points(job, window);
        let tolerance = tolerance(job.params);
        Rim::new(&self.tile, tolerance, &self.points, last, &mut self.min_link, &job.control.cancel)
    }

    /// Finds the points of the tile that is loaded.
    pub(super) fn find_points(&mut self, job: &Job<'_>, window: Window) {
        self.points.clear();
        if let Some(points) = &job.params.points {
            points.within(window, &mut self.points);
        }
    }

    fn cut(&mut self, job: &Job<'_>, rim: &Rim) -> Result<(), Cancelled> {
        let task = task(&self.tile, rim, tolerance(job.params), job);
        self.engine.triangulate(job.params.engine, &task, &mut self.mesh)
    }

    fn polish(&mut self, job: &Job<'_>, rim: &Rim) -> Result<(), Cancelled> {
        let task = task(&self.tile, rim, tolerance(job.params), job);
        self.engine.polish(job.params, &task, &mut self.mesh)
    }
}

/// What engines and polishing are given of a tile.
pub(super) fn task<'a>(tile: &'a Tile, rim: &'a Rim, tolerance: f64, job: &Job<'a>) -> Task<'a> {
    let (feasibility, cancel) = (job.params.feasibility, &job.control.cancel);
    Task { tile, domain: &rim.domain, tolerance, feasibility, cancel }
}

/// The tolerance that tiles work with: larger ones than heights can need change nothing, and would overflow. (Where errors
/// weigh more than 1 they would allow more; that much, nobody asks for.)
pub(super) fn tolerance(params: &Params) -> f64 {
    params.max_error.min(MAX_TOLERANCE)
}

#[derive(Default)]
struct Clocks {
    load: Clock,
    seams: Clock,
    engine: Clock,
    polish: Clock,
    measure: Clock,
    spool: Clock,
}

impl Clocks {
    fn read(&self) -> TileTimes {
        TileTimes {
            load: self.load.seconds(),
            seams: self.seams.seconds(),
            engine: self.engine.seconds(),
            polish: self.polish.seconds(),
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
