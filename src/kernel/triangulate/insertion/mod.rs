//! Greedy insertion (Garland & Heckbert 1995, sections 3 to 6): a coarse triangulation of the ground is refined by
//! inserting, again and again, the sample that is farthest from it.
//!
//! In come a tile and the loops around its ground; out goes a mesh within the tolerance. `topology` is triangles apart
//! from places, `surface` puts them in the plane, `first` triangulates the loops, whose edges are locked. `scan` finds a
//! triangle's candidate, by the sample that `search` says is farthest, `candidates` keeps them in a heap, `refine` inserts, `mend` inserts where edges stray, `seeded` where others have begun; `progressive` inserts in an order that
//! a whole raster can agree on. `data_dependent` swaps edges by the data
//! (algorithm IV) where [`Swap`] says so, and
//! `importance` has the other measures of section 3. The paper's algorithms I and II are oracles in the tests.

mod candidates;
mod data_dependent;
mod first;
mod importance;
mod mend;
mod options;
mod progressive;
mod refine;
mod scan;
mod search;
mod seeded;
mod squares;
mod surface;
mod topology;

use self::candidates::Candidates;
use self::data_dependent::Fits;
use self::refine::{FreeRim, Refinement};
use self::scan::{Candidate, Scanner};
use self::squares::Squares;
use self::surface::Surface;
use super::feasible::Tester;
use super::progressive::{Event, Order, Share};
use super::{Capabilities, Engine, EngineScratch, Feasibility, Progressive, Task};
use crate::base::Tile;
use crate::base::control::Cancelled;
use crate::base::features::{Feature, FeatureSet};
use crate::base::handed_over::{DENSE, RESERVED_SAMPLES};
use crate::base::mesh::{Domain, TileMesh};

pub use self::mend::{mend_part, mend_tile};
pub use self::options::{DataDependent, Fit, InsertionOptions, Measure, Selection, Shape, Swap};
pub use self::refine::{Split, Step};
pub(super) use self::seeded::refine;
pub use self::seeded::{Rim, delaunay, insert, is_not_delaunay, untangle};

#[cfg(test)]
mod tests;

/// The greedy insertion engine.
///
/// Every sample of a triangle that is farther than the tolerance, exactly, is a candidate until it is a vertex or the
/// triangle is gone. Samples on the domain's loops are none: no vertex is put on a locked edge, even if the loops were made
/// for a larger tolerance. Cost: expected O((m + n) log m) for n samples and m vertices (section 4.4.1).
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
#[serde(transparent)]
pub struct GreedyInsertion {
    /// Which variant.
    pub options: InsertionOptions,
}

/// The memory of greedy insertion: 48 bytes per triangle and 16 per vertex, so 112 per vertex.
#[derive(Debug, Default)]
pub struct Scratch {
    surface: Surface,
    candidates: Candidates,
    fits: Fits,
    squares: Squares,
    star: Vec<u32>,
    beyond: Vec<Candidate>,
}

impl Scratch {
    fn reserve(&mut self, tile: &Tile) {
        let samples = tile.validity().count_valid(tile.width(), tile.height()).min(RESERVED_SAMPLES);
        // As many vertices as samples, and the frame of the first triangulation.
        self.surface.reserve(samples + 4);
        self.candidates.reserve(2 * samples);
    }

    /// Frees what a dense tile has taken.
    fn hand_over(&mut self) {
        if self.surface.topology.len() as usize > DENSE {
            *self = Scratch::default();
        }
    }

    /// A refinement of the ground of `domain`, nothing inserted yet; `mesh` lends its memory.
    fn begin<'a>(
        &'a mut self,
        options: InsertionOptions,
        task: &Task<'a>,
        domain: &Domain,
        mesh: &mut TileMesh,
    ) -> Refinement<'a> {
        // First: it takes some memory that is free when the rest is taken.
        let measure = importance::prepare(options.measure, task.tile);
        mesh.clear();
        std::mem::swap(&mut self.surface.vertices, &mut mesh.vertices);
        self.reserve(task.tile);
        first::triangulate(domain, &mut self.surface);
        // Critical points (section 6) come before the first scan: what they leave beyond the tolerance is refined.
        domain.points.iter().fold(0, |near, &point| Refinement::preinsert(&mut self.surface, near, point));
        Refinement { measure, ..self.refine(options, task) }
    }

    /// A refinement of the surface as it is, by its errors, without candidates.
    fn refine<'a>(&'a mut self, options: InsertionOptions, task: &Task<'a>) -> Refinement<'a> {
        self.candidates.clear();
        self.fits.clear();
        self.squares.clear();
        let strong = task.feasibility == Feasibility::Strong;
        Refinement {
            surface: &mut self.surface,
            candidates: &mut self.candidates,
            fits: &mut self.fits,
            squares: &mut self.squares,
            star: &mut self.star,
            scanner: Scanner { tile: task.tile, tolerance: task.tolerance },
            strong: strong.then(|| Tester::new(task.tile, task.tolerance, Feasibility::Strong)),
            measure: None,
            beyond: &mut self.beyond,
            rim_is_loose: task.tile.channel_error.is_some(),
            free_rim: FreeRim::None,
            fixed: &task.domain.edges,
            splits: Vec::new(),
            sum: 0.0,
            most: usize::MAX,
            steps: None,
            options,
            cancel: task.cancel,
        }
    }
}

impl Engine for GreedyInsertion {
    fn name(&self) -> &'static str {
        "greedy insertion"
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { points: true, edges: true, channels: true }
    }

    /// The vertices; for a triangle 24 bytes of half-edges and 24 of its candidate, and the mesh's triangles when the
    /// candidates are gone. Data-dependent swapping keeps 8 more a triangle, curvature 8 a sample. A pass inserts up to a third
    /// of all samples, and lists them, 24 bytes for each.
    fn bytes_per_sample(&self) -> u64 {
        let InsertionOptions { swap, selection, measure } = &self.options;
        let swap = if matches!(swap, Swap::DataDependent(_)) { 2 * 8 } else { 0 };
        let selection = if matches!(selection, Selection::Sequential) { 0 } else { 2 * 24 / 3 };
        let measure = if matches!(measure, Measure::Curvature(_) | Measure::Product(_)) { 8 } else { 0 };
        16 + 2 * (24 + 24) + swap + selection + measure
    }

    fn identity(&self) -> String {
        format!("greedy insertion: {}", self.options.named())
    }

    fn features(&self) -> FeatureSet {
        let InsertionOptions { swap, selection, measure } = &self.options;
        let swap = match swap {
            Swap::Delaunay => None,
            Swap::DataDependent(_) => Some(Feature::DataDependentSwap),
        };
        let selection = match selection {
            Selection::Sequential => None,
            Selection::Fractional(_) => Some(Feature::FractionalSelection),
            Selection::Constant => Some(Feature::ConstantSelection),
        };
        let measure = match measure {
            Measure::LocalError => None,
            Measure::GlobalError => Some(Feature::GlobalErrorMeasure),
            Measure::Curvature(_) | Measure::Product(_) => Some(Feature::SmoothedMeasure),
        };
        [swap, selection, measure].into_iter().flatten().collect()
    }

    /// Where samples are inserted one at a time, the farthest first: passes that insert many cannot end at one of them, and
    /// other measures than errors are no thresholds.
    fn progressive(&self) -> Option<&dyn Progressive> {
        if self.options == self.options.in_order() { Some(self) } else { None }
    }

    fn triangulate(&self, task: &Task<'_>, scratch: &mut EngineScratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        self.triangulate_up_to(task, usize::MAX, scratch, mesh)
    }
}

impl Progressive for GreedyInsertion {
    fn triangulate_in_order(
        &self,
        task: &Task<'_>,
        order: Order<'_>,
        scratch: &mut EngineScratch,
        mesh: &mut TileMesh,
        told: &mut dyn FnMut(Event),
    ) -> Result<(), Cancelled> {
        task.cancel.check()?;
        let beginning = progressive::beginning(task.domain, order.rim);
        let mut refinement = scratch.of::<Scratch>().begin(self.options, task, &beginning, mesh);
        refinement.rim_is_loose = true;
        refinement.scan_all()?;
        refinement.run_in_order(task.domain, order, told)?;
        refinement.finish(mesh);
        scratch.of::<Scratch>().hand_over();
        Ok(())
    }
}

impl GreedyInsertion {
    /// As [`Engine::triangulate`], up to `most` vertices: where there are as many in the end, the mesh need not be within the
    /// tolerance.
    ///
    /// # Errors
    /// [`Cancelled`], with a mesh of no use.
    pub(crate) fn triangulate_up_to(
        &self,
        task: &Task<'_>,
        most: usize,
        scratch: &mut EngineScratch,
        mesh: &mut TileMesh,
    ) -> Result<(), Cancelled> {
        task.cancel.check()?;
        let mut refinement = scratch.of::<Scratch>().begin(self.options, task, task.domain, mesh);
        refinement.most = most;
        refinement.scan_all()?;
        refinement.run()?;
        refinement.finish(mesh);
        scratch.of::<Scratch>().hand_over();
        Ok(())
    }

    /// Greedy insertion just as the paper has it, for comparisons with it: from two triangles over the whole tile, the rim
    /// refined like everything else, up to `most` vertices. How it stood after every insertion, if `steps` are wanted. A mesh for one tile
    /// alone: no neighbour knows of the vertices on its rim. (Elsewhere the rim is there beforehand, see [`crate::kernel::seam`].)
    ///
    /// # Errors
    /// [`Cancelled`], with a mesh of no use.
    pub fn triangulate_alone(
        &self,
        task: &Task<'_>,
        most: usize,
        steps: bool,
        scratch: &mut Scratch,
        mesh: &mut TileMesh,
    ) -> Result<Vec<Step>, Cancelled> {
        let mut refinement = scratch.begin(self.options, task, task.domain, mesh);
        refinement.free_rim = FreeRim::All;
        refinement.most = most;
        refinement.scan_all()?;
        if steps {
            refinement.steps = Some(Vec::new());
            refinement.sum = (0..refinement.surface.topology.len()).map(|t| refinement.squares_of(t, Share::ALL)).sum();
        }
        refinement.run()?;
        let steps = refinement.steps.take();
        refinement.finish(mesh);
        Ok(steps.unwrap_or_default())
    }

    /// Franklin's top-down algorithm, for comparisons with it, as Silva, Mitchell & Kaufman 1995 (section 4) describe it: from
    /// two triangles over the whole tile, rounds in which every triangle gets its own farthest sample as a vertex, as long as
    /// one is farther than the tolerance. They do not say which local condition swaps an edge: [`InsertionOptions::swap`]
    /// does; selection and measure are of no account. A mesh for one tile alone, as that of
    /// [`GreedyInsertion::triangulate_alone`].
    ///
    /// # Errors
    /// [`Cancelled`], with a mesh of no use.
    pub fn triangulate_by_turns(
        &self,
        task: &Task<'_>,
        scratch: &mut Scratch,
        mesh: &mut TileMesh,
    ) -> Result<(), Cancelled> {
        let options = InsertionOptions { swap: self.options.swap, ..InsertionOptions::default() };
        let mut refinement = scratch.begin(options, task, task.domain, mesh);
        refinement.free_rim = FreeRim::All;
        refinement.scan_all()?;
        refinement.run_by_turns()?;
        refinement.finish(mesh);
        Ok(())
    }
}
