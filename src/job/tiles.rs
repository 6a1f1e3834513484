use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use rayon::prelude::*;

use super::engine::EngineScratch;
use super::goal::Told;
use super::in_order::{End, find_end};
use super::pool::Pool;
use super::shifted::{Lines, polish_shifted};
use super::{Error, Mesh, Params, Quality};
use crate::base::RasterError;
use crate::base::Tile;
use crate::base::Window;
use crate::base::control::{Cancelled, Control, Stage};
use crate::base::exact::MAX_TOLERANCE;
use crate::base::faults::{self, Point};
use crate::base::lattice::{self, MAX_TILE_CELLS};
use crate::base::mesh::TileMesh;
use crate::base::tiling::{TileGrid, TileId};
use crate::field::{Field, LoadScratch};
use crate::job::spool::{Chunk, Spool, SpoolError};
use crate::kernel::boundary;
use crate::kernel::measure::{Bare, Bound, ErrorStats, HeightStats, measure, shape};
use crate::kernel::polish::count_relaxed;
use crate::kernel::seam::{MinLink, Rim};
use crate::kernel::triangulate::Task;

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
    triangulate_into(&|grid, _| Spool::new(&params.temp_dir, grid.len()), field, params, control)
}

/// Makes the spool for a pass over the tiles of a grid.
pub type MakeSpool<'a> = dyn Fn(TileGrid, Pass) -> Result<Spool, SpoolError> + 'a;

/// A pass over a field's tiles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pass {
    /// Over the tiles of [`grid`]: there is always one.
    Tiles,
    /// Over those of the shifted grid: polishing with the seams.
    Seams,
}

/// Does what [`triangulate`] does, into spools of the caller's. A tile whose chunk a spool has already is not made again.
///
/// # Errors
/// [`Error`]; what becomes of the finished tiles is the spools' matter.
///
/// # Panics
/// If a spool is for another number of tiles.
pub fn triangulate_into(
    make_spool: &MakeSpool<'_>,
    field: &Field,
    params: &Params,
    control: &Control<'_>,
) -> Result<Mesh, Error> {
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
    params.takes_trim()?;
    let grid = grid(field.width(), field.height(), params)?;
    let spool = make_spool(grid, Pass::Tiles)?;
    assert_eq!(spool.tiles(), grid.len(), "chunks of a spool for this grid");
    let clocks = Clocks::default();
    let found = AtomicU64::new(0);
    let workspaces = Pool::default();
    let mut job = Job { field, params, grid, shifted: shifted(grid, params), control, end: None };
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
    drop(workspaces);
    if !has_ground(&spool, grid)? {
        return Err(Error::NoGround { path: field.name().to_path_buf() });
    }
    let found = found.into_inner();
    let (spool, chunks, first_bytes) = match job.shifted {
        None => (spool, grid, 0),
        Some(shifted) => {
            let second = make_spool(shifted, Pass::Seams)?;
            assert_eq!(second.tiles(), shifted.len(), "chunks of a spool for this grid");
            polish_shifted(&job, shifted, &spool, &second, &clocks)?;
            (second, shifted, spool.bytes())
        }
    };
    let times = clocks.read();
    Ok(Mesh {
        spool,
        grid,
        chunks,
        geo_transform: field.geo_transform(),
        channels: field.channels().to_vec(),
        max_error: params.max_error,
        error_scale: job.end.map_or(params.max_error, |end| end.scale(&job)),
        outcome: job.end.map(|end| end.outcome),
        times,
        other_bytes: first_bytes + job.end.map_or(0, |end| end.survey_bytes),
        found,
    })
}

/// Whether any tile has a triangle.
fn has_ground(spool: &Spool, grid: TileGrid) -> Result<bool, Error> {
    let columns = grid.columns();
    for row in 0..grid.rows() {
        if spool.counts(row * columns..(row + 1) * columns)?.iter().any(|c| c.triangles > 0) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// What all tiles of a run have in common.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) field: &'a Field,
    pub(super) params: &'a Params,
    pub(super) grid: TileGrid,
    /// The grid of the second pass, if there is one.
    pub(super) shifted: Option<TileGrid>,
    pub(super) control: &'a Control<'a>,
    /// Where tiles end, under a goal.
    pub(super) end: Option<End>,
}

/// What one thread needs to take a tile from its samples to the spool; reused from tile to tile.
#[derive(Default)]
pub(super) struct Workspace {
    pub(super) tile: Tile,
    pub(super) loading: LoadScratch,
    pub(super) points: Vec<(usize, usize)>,
    min_link: MinLink,
    /// Samples that trimming has taken from the ground of the tile.
    trimmed: u64,
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
            let window = job.grid.window(job.grid.tile(index));
            check_samples(job.field, window, &self.chunk, &mut self.tile, &mut self.loading)?;
        }
        Ok(Some(self.chunk.errors.all_samples()))
    }

    /// Takes one tile from its samples to the spool. Returns how many samples the tile owns.
    fn run(&mut self, job: &Job<'_>, index: usize, spool: &Spool, clocks: &Clocks) -> Result<u64, Error> {
        let Job { field, params, grid, .. } = *job;
        let id = grid.tile(index);
        let last = (grid.is_last_column(id), grid.is_last_row(id));
        let window = grid.window(id);
        let (rim, bound) = match &job.end {
            None => {
                clocks.load.time(|| field.load_with(window, &mut self.tile, &mut self.loading))?;
                let rim = clocks.seams.time(|| self.rim(job, window, last))?;
                clocks.engine.time(|| self.cut(job, &rim))?;
                clocks.polish.time(|| self.polish(job, &rim))?;
                (rim, Bound::Within(tolerance(params)))
            }
            Some(end) => clocks.engine.time(|| self.run_to(job, index, end))?,
        };
        let errors = clocks.measure.time(|| self.measure(job, id, bound));
        let samples = errors.all_samples();
        clocks.spool.time(|| {
            self.chunk.fill(index, &rim, &self.mesh, errors, self.tile.checksum());
            let names = field.channels().iter().map(|c| c.name.as_str());
            self.chunk.set_attributes(names, |channel, vertex| self.tile.channel_at_vertex(channel, vertex));
            spool.append(&self.chunk, &mut self.encoded)
        })?;
        Ok(samples)
    }

    /// Measures the mesh, and looks at its shape. If there is a second pass, only at the shape of what it will not change:
    /// it measures every sample itself.
    fn measure(&mut self, job: &Job<'_>, id: TileId, bound: Bound) -> ErrorStats {
        let Job { params, grid, .. } = *job;
        let window = grid.window(id);
        let last = (grid.is_last_column(id), grid.is_last_row(id));
        if let Some(shifted) = job.shifted {
            let lines = Lines::new(shifted, id, window);
            let stays = |corners: [lattice::Point; 3]| lines.straddles(corners);
            let seen = shape(&self.tile, &self.mesh, tolerance(params), stays);
            if self.mesh.relaxed > 0 {
                self.mesh.relaxed = count_relaxed(&self.tile, &self.mesh, tolerance(params), stays);
            }
            let samples = (window.width - usize::from(!last.0)) as u64 * (window.height - usize::from(!last.1)) as u64;
            let (trimmed, shape) = (self.trimmed, Some(Box::new(seen)));
            return ErrorStats { samples: samples - trimmed, trimmed, shape, ..ErrorStats::default() };
        }
        let origin = (window.column as u64, window.row as u64);
        let may_be_bare = params.trim > 0 && !self.tile.validity().is_whole();
        let bare = if may_be_bare { Bare::Strip(params.trim) } else { Bare::Nothing };
        let mut errors = measure(&self.tile, &self.mesh, bound, origin, last, bare);
        errors.heights = Some(HeightStats::of(&self.tile));
        assert_eq!(errors.trimmed, self.trimmed, "bare samples of the tile at {origin:?}");
        // Whoever has no time for polishing has none for looking at it.
        if params.quality != Quality::None {
            errors.shape = Some(Box::new(shape(&self.tile, &self.mesh, tolerance(params), |_| true)));
        }
        errors
    }

    /// Triangulates one tile and returns how many samples and triangles it has.
    pub(super) fn probe(&mut self, job: &Job<'_>, index: usize) -> Result<(usize, usize), Error> {
        let id = job.grid.tile(index);
        let window = job.grid.window(id);
        job.field.load_with(window, &mut self.tile, &mut self.loading)?;
        let rim = self.rim(job, window, (true, true))?;
        self.cut(job, &rim)?;
        self.polish(job, &rim)?;
        Ok((self.tile.width() * self.tile.height(), self.mesh.triangles.len()))
    }

    /// The rim of the tile that is loaded, and the points inside it.
    fn rim(&mut self, job: &Job<'_>, window: Window, last: (bool, bool)) -> Result<Rim, Error> {
        self.find_points(job, window)?;
        let (tile, points, cancel) = (&self.tile, &self.points, &job.control.cancel);
        let (tolerance, cells) = (tolerance(job.params), job.params.trim);
        let mut rim = Rim::new(tile, tolerance, points, last, &mut self.min_link, cancel)?;
        let fixed = rim.on_sides();
        let task = boundary::Task { tile, cells, tolerance, points, cancel };
        self.trimmed = boundary::trim(&task, &mut rim.domain, fixed)?;
        Ok(rim)
    }

    /// Finds the points of the tile that is loaded.
    pub(super) fn find_points(&mut self, job: &Job<'_>, window: Window) -> Result<(), Error> {
        self.points.clear();
        if let Some(points) = &job.params.points {
            points.within(window, &mut self.points);
        }
        let validity = self.tile.validity();
        let off_ground = |&&(column, row): &&(usize, usize)| !validity.is_ground(column as i32, row as i32);
        match self.points.iter().find(off_ground).filter(|_| !validity.is_whole()) {
            Some(&(column, row)) => {
                Err(Error::PointOffGround { column: window.column + column, row: window.row + row })
            }
            None => Ok(()),
        }
    }

    fn cut(&mut self, job: &Job<'_>, rim: &Rim) -> Result<(), Cancelled> {
        if rim.domain.loops.is_empty() {
            self.mesh.clear();
            return Ok(());
        }
        let task = task(&self.tile, rim, tolerance(job.params), job);
        self.engine.triangulate(job.params.engine, &task, &mut self.mesh)
    }

    fn polish(&mut self, job: &Job<'_>, rim: &Rim) -> Result<(), Cancelled> {
        if rim.domain.loops.is_empty() {
            return Ok(());
        }
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

/// The grid of the second pass, where polishing is worth one.
pub(super) fn shifted(grid: TileGrid, params: &Params) -> Option<TileGrid> {
    match params.quality {
        Quality::None | Quality::Fast => None,
        Quality::Balanced | Quality::Best => grid.shifted(),
    }
}

/// Compares the samples of a tile with those a chunk was made from. The tile's samples are loaded.
pub(super) fn check_samples(
    field: &Field,
    window: Window,
    chunk: &Chunk,
    tile: &mut Tile,
    loading: &mut LoadScratch,
) -> Result<(), Error> {
    field.load_with(window, tile, loading)?;
    let (expected, found) = (chunk.samples_checksum, tile.checksum());
    if expected == found {
        return Ok(());
    }
    let Window { column, row, width, height } = window;
    let samples = if field.importance().is_some() { "samples and weights" } else { "samples" };
    let what = format!("{width} × {height} {samples} at column {column}, row {row} with the checksum");
    let [expected, found] = [expected, found].map(|checksum| format!("{checksum:08x}"));
    Err(RasterError::Changed { path: field.name().to_path_buf(), what, expected, found }.into())
}

#[derive(Default)]
pub(super) struct Clocks {
    pub(super) load: Clock,
    seams: Clock,
    engine: Clock,
    pub(super) polish: Clock,
    pub(super) measure: Clock,
    pub(super) spool: Clock,
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
pub(super) struct Clock(AtomicU64);

impl Clock {
    pub(super) fn time<T>(&self, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        self.0.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }

    fn seconds(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-9
    }
}
