//! Greedy insertion (Garland & Heckbert 1995, sections 3 to 6): a coarse triangulation of the ground is refined by
//! inserting, again and again, the sample that is farthest from it.
//!
//! In come a tile and the loops around its ground; out goes a mesh within the tolerance. `topology` is triangles apart
//! from places, `surface` puts them in the plane, `first` triangulates the loops, whose edges are locked. `scan` finds a
//! triangle's candidate, `candidates` keeps them in a heap, `refine` inserts; `data_dependent` swaps edges by the data
//! (algorithm IV) where [`Swap`] says so, and
//! `importance` has the other measures of section 3. The paper's algorithms I and II are oracles in the tests.

mod candidates;
mod data_dependent;
mod first;
mod importance;
mod options;
mod refine;
mod scan;
mod surface;
mod topology;

use self::candidates::Candidates;
use self::data_dependent::Fits;
use self::refine::Refinement;
use self::scan::{Candidate, Scanner};
use self::surface::Surface;
use super::feasible::Tester;
use super::{Engine, Feasibility, Task};
use crate::control::Cancelled;
use crate::mesh::TileMesh;

pub use self::options::{DataDependent, Fit, InsertionOptions, Measure, Selection, Shape, Swap};

#[cfg(test)]
mod tests;

/// The greedy insertion engine.
///
/// Every sample of a triangle that is farther than the tolerance, exactly, is a candidate until it is a vertex or the
/// triangle is gone; no vertex is put on a locked edge, because the domain's loops are within the tolerance at the
/// samples they pass. Cost: expected O((m + n) log m) for n samples and m vertices (section 4.4.1).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct GreedyInsertion {
    /// Which variant.
    pub options: InsertionOptions,
}

/// The memory of greedy insertion: about 140 bytes per vertex.
#[derive(Debug, Default)]
pub struct Scratch {
    surface: Surface,
    candidates: Candidates,
    fits: Fits,
    star: Vec<u32>,
    beyond: Vec<Candidate>,
}

impl Engine for GreedyInsertion {
    type Scratch = Scratch;

    fn preinserts(&self) -> bool {
        true
    }

    fn triangulate(&self, task: &Task<'_>, scratch: &mut Scratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        task.cancel.check()?;
        let Scratch { surface, candidates, fits, star, beyond } = scratch;
        mesh.clear();
        std::mem::swap(&mut surface.vertices, &mut mesh.vertices);
        first::triangulate(task.domain, surface);
        // Critical points (section 6) come before the first scan: what they leave beyond the tolerance is refined.
        task.domain.points.iter().fold(0, |near, &point| Refinement::preinsert(surface, near, point));
        candidates.clear();
        fits.clear();
        let strong = (task.feasibility == Feasibility::Strong)
            .then(|| Tester::new(task.tile, task.tolerance, Feasibility::Strong));
        let mut refinement = Refinement {
            surface,
            candidates,
            fits,
            star,
            scanner: Scanner { tile: task.tile, tolerance: task.tolerance },
            strong,
            measure: importance::prepare(self.options.measure, task.tile),
            beyond,
            options: self.options,
            cancel: task.cancel,
        };
        refinement.scan_all()?;
        refinement.run()?;
        mesh.relaxed = refinement.count_relaxed();
        std::mem::swap(&mut surface.vertices, &mut mesh.vertices);
        let topology = &surface.topology;
        mesh.triangles.extend((0..topology.len()).map(|t| topology.corners(t)));
        Ok(())
    }
}
