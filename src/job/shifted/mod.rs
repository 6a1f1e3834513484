//! The second pass of polishing: over the tiles of a grid shifted by half a tile, so that what was a seam lies inside.
//!
//! Tiles are polished with their rims locked, because their neighbours have the same vertices there. When all are done,
//! the same triangles are divided anew, along lines through the middle of tiles ([`TileGrid::shifted`]), and polished
//! again, seams and all. Where the new lines are, triangles lie on both sides of them, and stay: they have been polished
//! before, all but the few where a line crosses a seam. So every tile of the shifted grid is a job of its own, no two
//! change the same vertex, their order does not matter, and each takes the memory of one tile. `lines` says which
//! triangle lies where, `region` puts one job together from the chunks of four tiles and makes a chunk of it; what it
//! needs of others it names by their place ([`Foreign::At`](crate::kernel::seam::Foreign::At)).
//!
//! Where the first pass has trimmed the rim, a job measures what is bare, but may not know all that is missing around it:
//! in the end as many samples must be bare as have been trimmed.
//!
//! - Architecture invariant: a job reads the chunks of the first pass and samples, and nothing else.

mod lines;
mod region;

#[cfg(test)]
mod tests;

pub(super) use lines::Lines;

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use self::region::Region;
use super::pool::Pool;
use super::tiles::{Clocks, Job, check_samples};
use super::{Error, engine};
use crate::base::Tile;
use crate::base::control::Stage;
use crate::base::faults::{self, Point};
use crate::base::mesh::Domain;
use crate::base::tiling::{TileGrid, TileId, TilePlace};
use crate::field::LoadScratch;
use crate::job::spool::{Chunk, Spool};
use crate::kernel::measure::{Bare, Bound, HeightStats, measure, shape};
use crate::kernel::polish;
use crate::kernel::triangulate::Task;

/// Polishes what the first pass has left in `tiles` once more, by the tiles of the shifted grid, into `spool`.
///
/// Memory: a [`Region`], a tile and what polishing needs, per busy thread.
///
/// # Errors
/// [`Error`].
pub(super) fn polish_shifted(
    job: &Job<'_>,
    shifted: TileGrid,
    tiles: &Spool,
    spool: &Spool,
    clocks: &Clocks,
) -> Result<(), Error> {
    let Job { field, control, .. } = *job;
    let workspaces = Pool::default();
    let bare = BareSamples::default();
    control.progress.begin(Stage::Seams, shifted.len() as u64, field.width() as u64 * field.height() as u64);
    (0..shifted.len()).into_par_iter().try_for_each(|index| {
        control.cancel.check()?;
        faults::reach(Point::TileBegun);
        let run = Run { job, shifted, tiles, spool, clocks, bare: &bare };
        let (samples, was_there) = workspaces.with(|w: &mut Workspace| w.provide(&run, index))?;
        if was_there {
            control.progress.found(Stage::Seams, samples);
        } else {
            control.progress.step(Stage::Seams, samples);
        }
        Ok::<(), Error>(())
    })?;
    control.progress.end(Stage::Seams);
    let [trimmed, measured] = [bare.trimmed, bare.measured].map(AtomicU64::into_inner);
    assert_eq!(measured, trimmed, "bare samples, and samples that have been trimmed");
    Ok(())
}

struct Run<'a> {
    job: &'a Job<'a>,
    shifted: TileGrid,
    tiles: &'a Spool,
    spool: &'a Spool,
    clocks: &'a Clocks,
    bare: &'a BareSamples,
}

/// Samples of all jobs.
#[derive(Default)]
struct BareSamples {
    /// Those that the tiles of the first pass have trimmed.
    trimmed: AtomicU64,
    /// Those that no triangle covers.
    measured: AtomicU64,
}

/// What one thread needs for a tile of the shifted grid; reused from one to the next.
#[derive(Default)]
struct Workspace {
    tile: Tile,
    loading: LoadScratch,
    points: Vec<(usize, usize)>,
    region: Region,
    polish: polish::Scratch,
    chunk: Chunk,
    encoded: Vec<u8>,
}

impl Workspace {
    /// Sees to it that the spool has a tile's chunk. Returns how many samples the tile owns, and whether the chunk was
    /// there already.
    fn provide(&mut self, run: &Run<'_>, index: usize) -> Result<(u64, bool), Error> {
        let window = run.shifted.place(index).window;
        if run.spool.find(index, &mut self.chunk, &mut self.encoded)? {
            if run.spool.check_samples() {
                check_samples(run.job.field, window, &self.chunk, &mut self.tile, &mut self.loading)?;
            }
            let samples = self.chunk.errors.all_samples();
            self.count_bare(run, index)?;
            return Ok((samples, true));
        }
        self.work(run, index)?;
        let samples = self.chunk.errors.all_samples();
        self.count_bare(run, index)?;
        Ok((samples, false))
    }

    /// Counts what the chunk leaves bare, and what the tile of the same column and row has trimmed, if there is one. The
    /// chunk is that tile's then.
    fn count_bare(&mut self, run: &Run<'_>, index: usize) -> Result<(), Error> {
        if run.job.params.trim == 0 {
            return Ok(());
        }
        run.bare.measured.fetch_add(self.chunk.errors.trimmed, Ordering::Relaxed);
        let (grid, id) = (run.job.grid, run.shifted.tile(index));
        if id.column < grid.columns() && id.row < grid.rows() {
            run.tiles.read(grid.index(id), &mut self.chunk, &mut self.encoded)?;
            run.bare.trimmed.fetch_add(self.chunk.errors.trimmed, Ordering::Relaxed);
        }
        Ok(())
    }

    fn work(&mut self, run: &Run<'_>, index: usize) -> Result<(), Error> {
        let Run { job, shifted, clocks, .. } = *run;
        let place = shifted.place(index);
        let window = place.window;
        clocks.load.time(|| job.field.load_with(window, &mut self.tile, &mut self.loading))?;
        self.points.clear();
        if let Some(points) = &job.params.points {
            points.within(window, &mut self.points);
        }
        let stays = clocks.spool.time(|| self.gather(run, &place))?;
        let tolerance = job.params.tolerance.kept();
        clocks.polish.time(|| {
            let (feasibility, cancel) = (job.params.feasibility, &job.control.cancel);
            let task = Task { tile: &self.tile, domain: &Domain::default(), tolerance, feasibility, cancel };
            let options = engine::polishing(job.params);
            let Region { mesh, locked, seams, .. } = &mut self.region;
            options.map_or(Ok(()), |options| {
                polish::polish_around(&task, &options, *locked, seams, &mut self.polish, mesh)
            })
        })?;
        let errors = clocks.measure.time(|| {
            let bound = Bound::Within(tolerance);
            // Where nothing is missing and nothing bare, whose sample is whose is plain.
            let may_be_bare = job.params.trim > 0 && (stays.trimmed > 0 || !self.tile.validity().is_whole());
            let bare = if may_be_bare { Bare::StripOfOthers(job.params.trim) } else { Bare::Nothing };
            let mut errors = self.region.with_passing(|mesh| measure(&self.tile, mesh, bound, &place, bare));
            let mut seen = shape(&self.tile, &self.region.mesh, tolerance, |_| true);
            stays.shape.iter().for_each(|s| seen.add(s));
            errors.shape = Some(Box::new(seen));
            errors.heights = Some(HeightStats::of(&self.tile));
            errors
        });
        clocks.spool.time(|| {
            self.region.fill(index, &mut self.chunk);
            self.chunk.relaxed += stays.relaxed;
            self.chunk.errors = errors;
            self.chunk.samples_checksum = self.tile.checksum();
            run.spool.append(&self.chunk, &mut self.encoded)
        })?;
        Ok(())
    }

    /// Puts the region together. Returns what is known of the straddling triangles of the tile of the same column and row,
    /// if there is one: over all jobs, those of every tile.
    fn gather(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<Stays, Error> {
        let (grid, shifted, id) = (run.job.grid, run.shifted, place.id);
        let mut stays = Stays::default();
        self.region.begin(place);
        // Where there are as many tiles one way, the grid is not shifted that way.
        let before = |is_shifted: bool, at: usize| if is_shifted { at.saturating_sub(1) } else { at };
        let rows = before(shifted.rows() > grid.rows(), id.row)..=id.row.min(grid.rows() - 1);
        let columns = before(shifted.columns() > grid.columns(), id.column)..=id.column.min(grid.columns() - 1);
        for row in rows {
            for column in columns.clone() {
                let tile = TileId { column, row };
                run.tiles.read(grid.index(tile), &mut self.chunk, &mut self.encoded)?;
                self.region.add(grid, shifted, &self.chunk);
                stays.trimmed += self.chunk.errors.trimmed;
                if tile == id {
                    stays.relaxed = self.chunk.relaxed;
                    stays.shape = self.chunk.errors.shape.take();
                }
            }
        }
        self.region.end(&self.points);
        Ok(stays)
    }
}

/// What the first pass has found out about a tile's triangles that nobody changes any more.
#[derive(Default)]
struct Stays {
    relaxed: u64,
    /// Samples that tiles which the region overlaps have trimmed, here or elsewhere.
    trimmed: u64,
    shape: Option<Box<crate::kernel::measure::ShapeStats>>,
}
