//! Later passes of polishing: over the tiles of grids shifted by half a tile, so that what was a seam lies inside.
//!
//! Tiles are polished with their rims locked, because their neighbours have the same vertices there. When all are done,
//! the same triangles are divided anew, along lines through the middle of tiles ([`TileGrid::shifted`]), and polished
//! again, seams and all. Where the new lines are, triangles lie on both sides of them, and stay: they have been polished
//! before, all but the few where a line crosses a seam. These have two passes more, over grids shifted one way only
//! ([`TileGrid::shifted_across`], [`TileGrid::shifted_down`]), each of which has one half of the crossings in the middle of
//! its tiles, and polishes around what is left of seams there.
//!
//! So every tile of a pass is a job of its own, no two change the same vertex, their order does not matter, and each takes
//! the memory of one tile. `lines` says which triangle lies where, `region` puts one job together from the chunks of up to
//! four tiles and makes a chunk of it.
//!
//! The last pass measures the height of every sample. A triangle's shape is looked at in the last pass that has it inside a tile:
//! in those that follow it straddles a line, so nobody changes it. So is its weighted error, where there are channels: there are
//! the channels of all of its vertices at hand.
//!
//! Where the first pass has trimmed the rim, a job measures what is bare, but may not know all that is missing around it:
//! in the end as many samples must be bare as have been trimmed ([`PassResult::check_bare`](super::PassResult::check_bare)).

mod lines;
mod part;
mod region;

#[cfg(test)]
mod tests;

pub(super) use region::Way;

use self::lines::Lines;
use self::part::Part;
use self::region::Region;
use super::{Maker, PassName, Run, Workspace};
use crate::base::control::Cancelled;
use crate::base::lattice::Point;
use crate::base::mesh::{Domain, TileMesh};
use crate::base::tiling::{TileGrid, TilePlace};
use crate::job::spool::Chunks;
use crate::job::{Error, quality};
use crate::kernel::measure::{
    Bare, Bound, ErrorStats, HeightStats, ShapeStats, WeightedStats, measure_heights, measure_weighted, shape,
};
use crate::kernel::polish::{self, count_relaxed};
use crate::kernel::triangulate::insertion::mend_part;
use crate::kernel::triangulate::{EngineScratch, Feasibility, Task};

/// How far from the vertices that passes over crossings visit triangles may change, in edges. Polishing visits what is two
/// edges away; farther than this hardly anything comes of it.
const REACH: usize = 5;

/// Which triangles of a tile no later pass changes: those that straddle lines of all of them.
pub(super) struct Final(Vec<Lines>);

impl Final {
    /// Those of a tile, by the grids of the passes that follow.
    pub(super) fn new(later: &[TileGrid], place: &TilePlace) -> Final {
        Final(later.iter().map(|&grid| Lines::new(grid, place)).collect())
    }

    /// Whether a triangle is one.
    pub(super) fn has(&self, corners: [Point; 3]) -> bool {
        self.0.iter().all(|lines| lines.straddles(corners))
    }
}

/// What one thread needs for a tile of a shifted grid: a [`Region`], a tile and what polishing needs.
#[derive(Default)]
pub(super) struct SeamMaker {
    shared: Workspace,
    region: Region,
    engine: EngineScratch,
    part: Part,
    polish: polish::Scratch,
}

impl Maker for SeamMaker {
    fn shared(&mut self) -> &mut Workspace {
        &mut self.shared
    }

    fn make(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<(), Error> {
        let Run { job, clocks, .. } = *run;
        clocks.load.time(|| self.shared.load(job.field, job.params, place.window))?;
        self.shared.find_features(job, place.window)?;
        let known = clocks.spool.time(|| self.gather(run, place))?;
        clocks.polish.time(|| self.polish(run))?;
        let errors = clocks.measure.time(|| self.measure(run, place, &known));
        clocks.spool.time(|| {
            let checksum = self.shared.checksum();
            let Workspace { tile, chunk, .. } = &mut self.shared;
            self.region.fill(place, run.pass.grid(), chunk);
            chunk.relaxed += known.relaxed;
            chunk.errors = errors;
            chunk.samples_checksum = checksum;
            run.set_attributes(chunk, tile);
        });
        Ok(())
    }

    /// Counts what a chunk of the last pass leaves bare, and what is known to have been trimmed.
    fn count_bare(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<(u64, u64), Error> {
        if run.job.params.trim == 0 || !run.later.is_empty() {
            return Ok((0, 0));
        }
        let Workspace { chunk, encoded, .. } = &mut self.shared;
        let (bare, mut trimmed) = (chunk.errors.trimmed, 0);
        for tile in run.pass.needed(place.index) {
            if run.pass.takes_over(tile) == place.id {
                needed(run).read(tile, chunk, encoded)?;
                trimmed += chunk.errors.trimmed;
            }
        }
        Ok((bare, trimmed))
    }
}

/// The chunks of the pass before.
fn needed<'a>(run: &Run<'a>) -> &'a dyn Chunks {
    run.inputs.expect("this pass was given the chunks that it needs")
}

impl SeamMaker {
    /// Puts the region together. Returns what is known of triangles that the passes before were the last to change, in
    /// those tiles that this one takes over: over all jobs, in every tile.
    fn gather(&mut self, run: &Run<'_>, place: &TilePlace) -> Result<Known, Error> {
        let way = run.pass.way(place.index, run.later.is_empty());
        let mut known = Known::default();
        self.region.begin(place);
        for tile in run.pass.needed(place.index) {
            let Workspace { chunk, encoded, .. } = &mut self.shared;
            needed(run).read(tile, chunk, encoded)?;
            self.region.add(&way, chunk);
            if run.pass.takes_over(tile) == place.id {
                known.relaxed += chunk.relaxed;
                known.trimmed += chunk.errors.trimmed;
                chunk.errors.shape.iter().for_each(|shape| known.shape.add(shape));
                known.extended = WeightedStats::larger(known.extended, chunk.errors.extended);
            }
            self.shared.hand_over();
        }
        self.region.end(&way, &self.shared.points, &self.shared.chains);
        Ok(known)
    }

    /// Mends what locked seams have left, and polishes around what is left of them and free now.
    fn polish(&mut self, run: &Run<'_>) -> Result<(), Cancelled> {
        let Run { job, pass, .. } = *run;
        let Region { mesh, locked, seams, rim, .. } = &mut self.region;
        let (feasibility, max_stray, cancel) = (job.params.feasibility, job.max_stray, &job.control.cancel);
        let (Workspace { tile, chains, .. }, tolerance, rim) = (&self.shared, job.params.tolerance.kept(), *rim);
        let edges_of = |mesh: &TileMesh, locked: u32| Domain {
            edges: chains.numbered(mesh.vertices[..locked as usize].iter().copied()),
            ..Domain::default()
        };
        let domain = edges_of(mesh, *locked);
        let task = Task { tile, domain: &domain, tolerance, feasibility, max_stray, cancel };
        mend_part(&task, rim, &mut self.engine, mesh)?;
        let options = quality::polishing_again(job.params, mesh.triangles.len());
        let Some(options) = options.filter(|_| !seams.is_empty()) else { return Ok(()) };
        if pass.name() == PassName::Seams {
            let part = polish::Part { locked: *locked, centres: seams, rim };
            return polish::polish_around(&task, &options, &part, &mut self.polish, mesh);
        }
        self.part.take(mesh, *locked, seams, REACH);
        let Part { mesh: part, locked, centres, .. } = &mut self.part;
        let near = polish::Part { locked: *locked, centres, rim };
        let domain = edges_of(part, *locked);
        let task = Task { domain: &domain, ..task };
        polish::polish_around(&task, &options, &near, &mut self.polish, part)?;
        self.part.put_back(mesh);
        Ok(())
    }

    /// Looks at the shape and the weighted error of the triangles that no later pass changes, and counts those among them that are relaxed; in the
    /// last pass measures the mesh.
    fn measure(&mut self, run: &Run<'_>, place: &TilePlace, known: &Known) -> ErrorStats {
        let (params, tile, region) = (run.job.params, &self.shared.tile, &mut self.region);
        let (tolerance, is_last) = (params.tolerance.kept(), run.later.is_empty());
        let settled = Final::new(run.later, place);
        let mut seen = shape(tile, &region.mesh, tolerance, run.job.max_stray, |corners| settled.has(corners));
        seen.add(&known.shape);
        if params.feasibility == Feasibility::Strong {
            region.mesh.relaxed = count_relaxed(tile, &region.mesh, tolerance, |corners| settled.has(corners));
        }
        let shape = Some(Box::new(seen));
        let extended = measure_weighted(tile, &region.mesh, tolerance, place, |corners| settled.has(corners));
        let extended = WeightedStats::larger(known.extended, extended);
        if !is_last {
            return ErrorStats { trimmed: known.trimmed, shape, extended, ..ErrorStats::default() };
        }
        // Where nothing is missing and nothing bare, whose sample is whose is plain.
        let may_be_bare = params.trim > 0 && run.job.field.may_have_gaps();
        let bare = if may_be_bare { Bare::StripOfOthers(params.trim) } else { Bare::Nothing };
        let errors = region.with_passing(|mesh| measure_heights(tile, mesh, Bound::Within(tolerance), place, bare));
        ErrorStats { shape, extended, heights: Some(HeightStats::of(tile)), ..errors }
    }
}

/// What passes before have found out about triangles that nobody changes any more, and about the ground.
#[derive(Default)]
struct Known {
    relaxed: u64,
    trimmed: u64,
    shape: ShapeStats,
    extended: Option<WeightedStats>,
}
