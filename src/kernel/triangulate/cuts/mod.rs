//! Greedy cuts (Silva, Mitchell & Kaufman 1995, section 2): the ground yet untriangulated is eaten from its rim inward.
//!
//! `slits` finds the rim of a domain: its loops, and its edges as slits. `front` keeps it as corner nodes and knows the three cuts: an ear, a bite to a new vertex, a
//! bite to a vertex of the front itself, which splits a polygon. `edge_grid` finds the front's edges near a place,
//! `visible` says which cuts stay inside, `places` what a bite to a place would be. Which cut comes next is a `Strategy`:
//! `paper` is the paper's own, `largest_first` the improved one. Both leave edges without a bite to `thin`, and
//! `last_resort` ends what no strategy can.
//!
//! The improved order looks for bites in `apexes`, which weighs (`score`) places on rays (`ray`) and vertices of the
//! front (`obstacles`), in the coordinates of the edge (`frame`). `sweep` tells for a whole ray at once which triangles
//! are feasible; `outline` has the samples it reads.

mod apexes;
mod edge_grid;
mod frame;
mod front;
mod largest_first;
mod last_resort;
mod obstacles;
mod outline;
mod paper;
mod places;
mod ray;
mod score;
mod slits;
mod sweep;
mod thin;
mod visible;

use self::front::Front;
use self::largest_first::LargestFirst;
use self::last_resort::LastResort;
use self::paper::PaperOrder;
use super::feasible::Tester;
use super::{Capabilities, Engine, EngineScratch, Feasibility, Task};
use crate::base::control::Cancelled;
use crate::base::features::{Feature, FeatureSet};
use crate::base::handed_over::DENSE;
use crate::base::mesh::TileMesh;

#[cfg(test)]
mod tests;

/// Which cut comes next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Cuts {
    /// The paper's own order: ears and bites as they appear, a bite's apex on the perpendicular through its edge.
    Plain,
    /// The largest ear first, then the best of bites grown along several rays: fewer triangles, in more time.
    #[default]
    Improved,
}

/// The greedy cuts engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(transparent)]
pub struct GreedyCuts {
    /// Which cut comes next.
    pub cuts: Cuts,
}

impl GreedyCuts {
    /// The engine in the paper's own order.
    pub const PLAIN: GreedyCuts = GreedyCuts { cuts: Cuts::Plain };
    /// The engine in the improved order.
    pub const IMPROVED: GreedyCuts = GreedyCuts { cuts: Cuts::Improved };
}

/// Chooses cuts until none it knows of is left.
trait Strategy {
    /// Forgets the tile before.
    fn clear(&mut self);

    /// Makes one cut; `false` if it found none. What the cut left to look at is in [`Front::take_fresh`].
    fn cut(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool;

    /// Hands over the edges that it has given up on since the last call.
    fn take_hopeless(&mut self, into: &mut Vec<Edge>);
}

/// An edge of the front, by its two nodes; the ground lies to the left of the way from the first to the second.
type Edge = (u32, u32);

/// Cuts between two looks at the cancellation token.
const CUTS_BETWEEN_CHECKS: u32 = 1024;

/// The memory of greedy cuts: the front and the queues of those who choose cuts.
#[derive(Debug, Default)]
pub struct Scratch {
    front: Front,
    plain: PaperOrder,
    improved: LargestFirst,
    last_resort: LastResort,
}

impl Engine for GreedyCuts {
    fn name(&self) -> &'static str {
        "greedy cuts"
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities { points: true, edges: true, channels: false }
    }

    /// Beside the mesh 32 bytes for each node that the front ever had, about as many as samples, in a list that doubles; and
    /// queues. Where every sample is a vertex, 85 and 108 were counted.
    fn bytes_per_sample(&self) -> u64 {
        match self.cuts {
            Cuts::Plain => 100,
            Cuts::Improved => 124,
        }
    }

    fn identity(&self) -> String {
        match self.cuts {
            Cuts::Plain => "greedy cuts, plain".to_string(),
            Cuts::Improved => "greedy cuts, improved".to_string(),
        }
    }

    fn features(&self) -> FeatureSet {
        let engine = FeatureSet::default().with(Feature::GreedyCuts);
        match self.cuts {
            Cuts::Plain => engine,
            Cuts::Improved => engine.with(Feature::CutOrder),
        }
    }

    fn triangulate(&self, task: &Task<'_>, scratch: &mut EngineScratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        let memory = scratch.of::<Scratch>();
        self.cut(task, memory, mesh)?;
        if mesh.triangles.len() > DENSE {
            *memory = Scratch::default();
        }
        Ok(())
    }
}

impl GreedyCuts {
    fn cut(&self, task: &Task<'_>, scratch: &mut Scratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
        let Scratch { front, plain, improved, last_resort } = scratch;
        front.reset(task.domain, task.tile.far_corner(), std::mem::take(mesh));
        match self.cuts {
            Cuts::Plain => eat(task, front, plain, last_resort),
            Cuts::Improved => eat(task, front, improved, last_resort),
        }?;
        *mesh = front.take_mesh();
        Ok(())
    }
}

/// Makes cuts until nothing is left of the ground.
fn eat(
    task: &Task<'_>,
    front: &mut Front,
    order: &mut impl Strategy,
    last_resort: &mut LastResort,
) -> Result<(), Cancelled> {
    let tester = Tester::new(task.tile, task.tolerance, task.feasibility);
    order.clear();
    last_resort.clear();
    let mut cuts = 0u32;
    while front.alive() > 0 {
        if cuts.is_multiple_of(CUTS_BETWEEN_CHECKS) {
            task.cancel.check()?;
        }
        cuts = cuts.wrapping_add(1);
        if order.cut(front, &tester) {
            continue;
        }
        order.take_hopeless(last_resort.edges());
        let cut = match task.feasibility {
            Feasibility::Weak => last_resort.cut_weak(front, &tester),
            Feasibility::Strong => last_resort.cut_strong(front, &tester),
        };
        assert!(cut, "no cut left with {} nodes on the front: {:?}", front.alive(), front.some_loop());
    }
    Ok(())
}
