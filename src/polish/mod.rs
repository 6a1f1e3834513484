//! Polishing: from a finished tile mesh to one with far fewer triangles, under the same guarantee.
//!
//! In comes the mesh of any engine; out goes a mesh of the same ground, whose rim is untouched and whose every triangle
//! has passed the exact test. Vertices stay on samples and keep their heights. `net` is the mesh while it changes,
//! `journal` what a move that fails takes back; `hole` and `filling` are how triangles are replaced. `removal` takes
//! vertices out where feasible triangles fill the hole.
//!
//! Nothing is random and nothing is timed: effort is counted, ties go by number. Method and figures: docs/quality.md.

mod filling;
mod hole;
mod journal;
mod judge;
mod net;
mod order;
mod removal;

#[cfg(test)]
mod tests;

use self::judge::Judge;
use self::net::Net;
use self::order::Order;
use self::removal::Removal;
use crate::control::Cancelled;
use crate::mesh::TileMesh;
use crate::triangulate::Task;

/// How much work is put into fewer triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// Vertex removal: three sweeps.
    Fast,
    /// The most triangles saved for the time.
    #[default]
    Balanced,
    /// Goes on for as long as it pays at all.
    Best,
}

/// Sweeps of removal at [`Effort::Fast`]. The second costs a third of the first, as few vertices are due, the third less.
const FAST_SWEEPS: usize = 3;

/// How to polish.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Options {
    /// How much work to put in.
    pub effort: Effort,
}

/// Memory that polishing reuses from tile to tile; it carries nothing from one to the next.
///
/// About 60 bytes per triangle and 30 per vertex of the mesh that comes in.
#[derive(Debug, Default)]
pub struct Scratch {
    net: Net,
    order: Order,
    removal: Removal,
}

/// Replaces `mesh`, a mesh of the task's ground that keeps the contract of [`TileMesh`], by one of at most as many
/// triangles that keeps it too.
///
/// The domain's vertices and loops stay as they are. Interior vertices are removed, moved to other samples and
/// renumbered; every vertex stands on a sample and has its height. Every triangle that was not there before passes
/// the exact weak test. With strong feasibility, every edge that was not there before also passes the strong test;
/// `mesh.relaxed` does not grow, and is never more than the triangles that have an edge which fails it. The same mesh and
/// task give the same result, always and everywhere.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
///
/// # Panics
/// If the mesh does not keep the contract.
pub fn polish(task: &Task<'_>, options: &Options, scratch: &mut Scratch, mesh: &mut TileMesh) -> Result<(), Cancelled> {
    let Scratch { net, order, removal } = scratch;
    let mut judge = Judge::new(task);
    net.load(task.domain, mesh);
    order.reset(net);
    match options.effort {
        Effort::Fast => removal.sweeps(FAST_SWEEPS, net, order, &mut judge, task.cancel)?,
        Effort::Balanced | Effort::Best => removal.sweeps(usize::MAX, net, order, &mut judge, task.cancel)?,
    };
    let relaxed = mesh.relaxed;
    net.store(mesh);
    if relaxed > 0 {
        mesh.relaxed = relaxed.min(count_relaxed(&judge, mesh));
    }
    Ok(())
}

/// How many triangles have an edge that fails the strong test.
fn count_relaxed(judge: &Judge<'_>, mesh: &TileMesh) -> u64 {
    let fails = |&t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(t);
        [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| !judge.may_join(p, q))
    };
    mesh.triangles.iter().filter(|t| fails(t)).count() as u64
}
