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
//! in the end as many samples must be bare as have been trimmed ([`PassResult::check_bare`](super::PassResult::check_bare)).

mod lines;
mod region;

#[cfg(test)]
mod tests;

pub(super) use lines::Lines;

use self::region::Region;
use super::{Maker, Run, Workspace};
use crate::base::RasterRim;
use crate::base::mesh::Domain;
use crate::base::tiling::TilePlace;
use crate::job::spool::Chunks;
use crate::job::{Error, quality};
use crate::kernel::measure::{Bare, Bound, HeightStats, ShapeStats, measure, shape};
use crate::kernel::polish::{self, Part};
use crate::kernel::triangulate::insertion::mend;
use crate::kernel::triangulate::{EngineScratch, Task};

/// What one thread needs for a tile of the shifted grid: a [`Region`], a tile and what polishing needs.
#[derive(Default)]
pub(super) struct SeamMaker {
    shared: Workspace,
    region: Region,
    engine: EngineScratch,
    polish: polish::Scratch,
}

impl Maker for SeamMaker {
    fn shared(&mut self) -> &mut Workspace {
        &mut self.shared
    }

    fn make(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<(), Error> {
        let Run { job, clocks, .. } = *run;
        clocks.load.time(|| self.shared.load(job.field, place.window))?;
        self.shared.find_points(job.params, place.window);
        let stays = clocks.spool.time(|| self.gather(run, place))?;
        let tile = &self.shared.tile;
        let tolerance = job.params.tolerance.kept();
        clocks.polish.time(|| {
            let (feasibility, cancel) = (job.params.feasibility, &job.control.cancel);
            let max_stray = job.max_stray;
            let task = Task { tile, domain: &Domain::default(), tolerance, feasibility, max_stray, cancel };
            let options = quality::polishing(job.params);
            let Region { mesh, locked, seams, .. } = &mut self.region;
            mend(&task, RasterRim::default(), &mut self.engine, mesh)?;
            options.map_or(Ok(()), |options| {
                let part = Part { locked: *locked, centres: seams, rim: RasterRim::default() };
                polish::polish_around(&task, &options, &part, &mut self.polish, mesh)
            })
        })?;
        let errors = clocks.measure.time(|| {
            let bound = Bound::Within(tolerance);
            // Where nothing is missing and nothing bare, whose sample is whose is plain.
            let may_be_bare = job.params.trim > 0 && (stays.trimmed > 0 || !tile.validity().is_whole());
            let bare = if may_be_bare { Bare::StripOfOthers(job.params.trim) } else { Bare::Nothing };
            let mut errors = self.region.with_passing(|mesh| measure(tile, mesh, bound, place, bare));
            let mut seen = shape(tile, &self.region.mesh, tolerance, |_| true);
            stays.shape.iter().for_each(|s| seen.add(s));
            errors.shape = Some(Box::new(seen));
            errors.heights = Some(HeightStats::of(tile));
            errors
        });
        clocks.spool.time(|| {
            let Workspace { tile, chunk, .. } = &mut self.shared;
            self.region.fill(place.index, chunk);
            chunk.relaxed += stays.relaxed;
            chunk.errors = errors;
            chunk.samples_checksum = tile.checksum();
        });
        Ok(())
    }

    /// Counts what the chunk leaves bare, and what the tile of the same column and row has trimmed, if there is one. The
    /// chunk is that tile's then.
    fn count_bare(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<(u64, u64), Error> {
        if run.job.params.trim == 0 {
            return Ok((0, 0));
        }
        let Workspace { chunk, encoded, .. } = &mut self.shared;
        let (bare, grid) = (chunk.errors.trimmed, run.job.grid);
        if place.id.column < grid.columns() && place.id.row < grid.rows() {
            needed(run).read(grid.index(place.id), chunk, encoded)?;
            return Ok((bare, chunk.errors.trimmed));
        }
        Ok((bare, 0))
    }
}

/// The chunks of the first pass.
fn needed<'a>(run: &Run<'a>) -> &'a dyn Chunks {
    run.inputs.expect("this pass was given the chunks that it needs")
}

impl SeamMaker {
    /// Puts the region together. Returns what is known of the straddling triangles of the tile of the same column and row,
    /// if there is one: over all jobs, those of every tile.
    fn gather(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<Stays, Error> {
        let (grid, shifted) = (run.job.grid, run.pass.grid());
        let mut stays = Stays::default();
        self.region.begin(place);
        for tile in run.pass.needed(place.index) {
            let Workspace { chunk, encoded, .. } = &mut self.shared;
            needed(run).read(tile, chunk, encoded)?;
            self.region.add(grid, shifted, chunk);
            stays.trimmed += chunk.errors.trimmed;
            if grid.tile(tile) == place.id {
                stays.relaxed = chunk.relaxed;
                stays.shape = chunk.errors.shape.take();
            }
            self.shared.hand_over();
        }
        self.region.end(&self.shared.points);
        Ok(stays)
    }
}

/// What the first pass has found out about a tile's triangles that nobody changes any more.
#[derive(Default)]
struct Stays {
    relaxed: u64,
    /// Samples that tiles which the region overlaps have trimmed, here or elsewhere.
    trimmed: u64,
    shape: Option<Box<ShapeStats>>,
}
