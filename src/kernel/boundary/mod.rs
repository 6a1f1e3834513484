//! Trimming: the rim of the ground is simplified sideways, inward only, before anything is triangulated.
//!
//! In come a tile, the loops around its ground, and how many cells may be lost; out go loops with fewer vertices, and the
//! number of samples that are no longer on the ground. A vertex goes by cutting the *ear* off that it makes with its
//! neighbours. `strip` says which samples and cells may be lost, `ear` what an ear takes with it, `loops` are the loops
//! while they change.
//!
//! - Architecture invariant: what is cut off are ears of the ground before, so loops stay loops of a [`Domain`], and what
//!   is bare borders on what is no ground.
//! - Architecture invariant: vertices on the sides of the tile stay, and with them all of the sides: neighbours, who trim
//!   by themselves, have the same.

mod ear;
mod loops;
mod strip;

#[cfg(test)]
mod tests;

pub use strip::Strip;

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use self::loops::Loops;
use crate::base::Tile;
use crate::base::control::Cancelled;
use crate::base::exact;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::{Domain, Vertex};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::feasible::Tester;

/// The most cells that may be asked for.
pub const MAX_CELLS: u32 = 1000;

/// What is trimmed, and by how much.
#[derive(Debug, Clone, Copy)]
pub struct Task<'a> {
    /// The samples.
    pub tile: &'a Tile,
    /// How far from a sample without a height what is lost may be, in columns and rows.
    pub cells: u32,
    /// The largest vertical distance allowed, as for engines.
    pub tolerance: f64,
    /// Samples that stay, by rows, then by columns.
    pub points: &'a [(usize, usize)],
    /// Asked now and then whether to go on.
    pub cancel: &'a crate::base::control::CancelToken,
}

/// Cuts ears off the loops of `domain`, the smallest first, until none is left that may go. The first `fixed` vertices
/// stay and keep their numbers; those that go leave no gap. Returns how many samples with heights are not on the ground any
/// more.
///
/// An ear may be cut off if
/// - its tip is not among the first `fixed` vertices, at one corner only, and no point;
/// - the closed triangle holds no other vertex of a loop, and no point;
/// - all samples of it are in the strip, and so are all cells that it meets; samples on the new edge are not lost;
/// - the new edge is within the limits at the samples it passes, and between samples where it crosses the grid
///   ([`Feasibility::Strong`]), whatever triangles are held to;
/// - its loop has more than three corners.
///
/// Without the test between samples, edges that nobody can move any more run far above or below the ground: on steep
/// coasts that costs more triangles than the vertices saved, and twice the samples are lost for the same saving.
///
/// What is refused once, stays so: ground is only lost. So each ear is looked at once. Cost: two passes over the tile,
/// O(n log n) for n vertices, and the samples of 3n ears, of each as far as they are in the strip. Memory: 3 bytes per
/// sample and 72 per corner of a loop, while it runs.
///
/// # Errors
/// [`Cancelled`], with loops of no use.
pub fn trim(task: &Task<'_>, domain: &mut Domain, fixed: usize) -> Result<u64, Cancelled> {
    if task.cells == 0 || task.tile.validity().is_whole() {
        return Ok(0);
    }
    let strip = Strip::new(task.tile, task.cells);
    let mut loops = Loops::new(domain, task, fixed);
    let mut lost = 0;
    let mut queue: BinaryHeap<Reverse<(i64, u32, [u32; 2])>> = BinaryHeap::new();
    let wanted = |loops: &Loops, tip: u32| loops.ear(tip).map(|ear| Reverse((ear.area(), tip, loops.beside(tip))));
    queue.extend((0..loops.len()).filter_map(|tip| wanted(&loops, tip)));
    while let Some(Reverse((_, tip, beside))) = queue.pop() {
        task.cancel.check()?;
        let Some(ear) = loops.ear(tip).filter(|_| loops.beside(tip) == beside) else { continue };
        let Some(samples) = loops.samples_lost(&ear, &strip) else { continue };
        let [before, after] = beside.map(|node| loops.vertex(node));
        if !may_be_an_edge(task, before, after) {
            continue;
        }
        lost += samples;
        loops.cut(tip);
        queue.extend(beside.into_iter().filter_map(|node| wanted(&loops, node)));
    }
    loops.store(domain, fixed);
    Ok(lost)
}

/// Whether the line between two vertices keeps what is promised of a loop's edges.
fn may_be_an_edge(task: &Task<'_>, p: Vertex, q: Vertex) -> bool {
    let tile = task.tile;
    let [a, b] = [p, q].map(|v| (v.at.x / STEPS, v.at.y / STEPS));
    let links = gcd(a.0.abs_diff(b.0), a.1.abs_diff(b.1)) as i32;
    let place = |i: i32| ((a.0 + (b.0 - a.0) / links * i) as usize, (a.1 + (b.1 - a.1) / links * i) as usize);
    let heights_kept = (1..links).all(|i| {
        let (column, row) = place(i);
        let [before, after] = [links - i, i].map(i64::from);
        let terms = [(before, p.height), (after, q.height), (-before - after, tile.at(column, row))];
        exact::within(&terms, before + after, tile.limit(column, row, task.tolerance))
    });
    heights_kept
        && (1..links).all(|i| channels_kept(task, place(0), place(links), place(i), f64::from(i) / f64::from(links)))
        && Tester::new(tile, task.tolerance, Feasibility::Strong).strong_edge(p, q)
}

/// Whether the weighted error at a sample is within its limit, a share of the way from one vertex to the other.
fn channels_kept(task: &Task<'_>, from: (usize, usize), to: (usize, usize), at: (usize, usize), share: f64) -> bool {
    let tile = task.tile;
    let Some(error) = &tile.channel_error else { return true };
    let off = |value: &dyn Fn((usize, usize)) -> f64| value(from) + (value(to) - value(from)) * share - value(at);
    let channels = (0..tile.channels.len()).map(|c| off(&|(column, row)| tile.channel_at(c, column, row)));
    error.weighted(off(&|(column, row)| tile.at(column, row)), channels) <= error.limit(task.tolerance)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Column and row of a vertex on a sample.
fn sample(at: Point) -> (i32, i32) {
    (at.x / STEPS, at.y / STEPS)
}
