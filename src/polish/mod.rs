//! Polishing: from a finished tile mesh to one with far fewer triangles, under the same guarantee.
//!
//! In comes the mesh of any engine; out goes a mesh of the same ground, whose rim is untouched and whose every triangle
//! has passed the exact test. Vertices stay on samples and keep their heights. `net` is the mesh while it changes,
//! `journal` what a move that fails takes back; `hole` and `filling` are how triangles are replaced. `removal` takes
//! vertices out where feasible triangles fill the hole.
//!
//! Nothing is random and nothing is timed: effort is counted, ties go by number. Method and figures: docs/quality.md.

mod energy;
mod fan;
mod filling;
mod hole;
mod improve;
mod journal;
mod judge;
mod net;
mod order;
mod removal;
mod repair;

#[cfg(test)]
mod tests;

use self::judge::Judge;
use self::net::Net;
use self::order::Order;
use self::removal::Removal;
use self::repair::{Patience, Repair};
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
    repair: Repair,
}

impl Scratch {
    fn fast(&mut self, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        self.removal.sweeps(FAST_SWEEPS, &mut self.net, &mut self.order, judge)?;
        Ok(())
    }

    fn balanced(&mut self, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        let Scratch { net, order, removal, repair } = self;
        removal.sweeps(usize::MAX, net, order, judge)?;
        if !judge.meter.is_of_use() {
            return Ok(());
        }
        Repair::measure(net, judge);
        let env = |k: &str, d: f32| std::env::var(k).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
        repair.rs = env("RS", 1.0) as u32;
        let start = std::time::Instant::now();
        let debug = env("DBG", 0.0) > 0.0;
        let (rounds, shrink, scales) = (env("R", 3.0) as usize, env("SH", 0.8), env("SC", 2.0) as u32);
        for _ in 0..env("PRE", 0.0) as usize {
            repair.relax(net, order, judge)?;
        }
        for pass in 0..env("N", 3.0) as usize {
            let cap = env(["C0", "C1", "C2", "C3", "C4", "C5"][pass.min(5)], 1.0);
            order.make_all_due();
            let gone = repair.sweep(net, order, judge, Patience { cap, rounds, shrink, scales })?;
            if debug {
                eprintln!("pass {pass} cap {cap}: {gone} gone, {:?}", start.elapsed());
            }
            for _ in 0..env("RELAX", 1.0) as usize {
                repair.relax(net, order, judge)?;
            }
            if debug {
                eprintln!("relaxed {:?} {:?}", start.elapsed(), repair.count);
            }
        }
        Ok(())
    }

    fn best(&mut self, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        self.balanced(judge)
    }
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
    let mut judge = Judge::new(task);
    scratch.net.load(task.domain, mesh);
    scratch.order.reset(&scratch.net);
    match options.effort {
        Effort::Fast => scratch.fast(&mut judge)?,
        Effort::Balanced => scratch.balanced(&mut judge)?,
        Effort::Best => scratch.best(&mut judge)?,
    }
    let relaxed = mesh.relaxed;
    scratch.net.store(mesh);
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
