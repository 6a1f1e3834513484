//! Mending: samples are inserted where edges stray farther than they may ([`Task::max_stray`]), whatever made the mesh.
//!
//! A mesh of all samples with Delaunay edges keeps every limit of at least one tolerance: none of its edges crosses a side of a
//! cell. So of a side that is crossed a sample is inserted, then whatever that leaves beyond the tolerance, until no edge
//! strays. Where a locked edge is in the way, an edge may be left.

use std::collections::HashSet;

use super::first::loop_edges;
use super::refine::{FreeRim, Refinement};
use super::surface::Site;
use super::topology::{next, prev};
use super::{InsertionOptions, Scratch, Task};
use crate::base::RasterRim;
use crate::base::control::Cancelled;
use crate::base::mesh::TileMesh;
use crate::kernel::triangulate::EngineScratch;
use crate::kernel::triangulate::feasible::{Stray, Tester};

/// Edges between two looks at the cancellation token.
const EDGES_BETWEEN_CHECKS: u32 = 4096;

/// Inserts samples into a mesh of the task's tile, or of a part of it, until no edge of two triangles strays farther than it may.
/// Every triangle is to be within the tolerance before, and is after. Vertices stay, new ones follow; edges of one triangle
/// stay, but for those along `rim`, which may be split. Returns how many edges stray all the same, next to edges that stay.
///
/// Where nothing strays the mesh is left as it is, for the price of a look at its edges.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
pub fn mend(
    task: &Task<'_>,
    rim: RasterRim,
    scratch: &mut EngineScratch,
    mesh: &mut TileMesh,
) -> Result<u64, Cancelled> {
    task.cancel.check()?;
    let tester = Tester::new(task.tile, task.tolerance, task.feasibility).with_max_stray(task.max_stray);
    if !tester.limits_strays() || !mesh.triangles.iter().any(|&t| strays(&tester, mesh, t)) {
        return Ok(0);
    }
    let scratch = scratch.of::<Scratch>();
    scratch.surface.clear();
    std::mem::swap(&mut scratch.surface.vertices, &mut mesh.vertices);
    scratch.surface.topology.load(&mesh.triangles, scratch.surface.vertices.len(), &loop_edges(task.domain));
    mesh.clear();
    let mut refinement = scratch.refine(InsertionOptions::default(), task);
    refinement.free_rim = FreeRim::Along(rim);
    let left = refinement.mend(&tester)?;
    refinement.finish(mesh);
    scratch.hand_over();
    Ok(left)
}

/// Whether an edge of a triangle strays. An edge between two triangles is looked at in one of them.
fn strays(tester: &Tester<'_>, mesh: &TileMesh, [a, b, c]: [u32; 3]) -> bool {
    let vertex = |i: u32| mesh.vertices[i as usize];
    [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| p < q && tester.stray(vertex(p), vertex(q)).is_some())
}

/// What can be done about an edge that strays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Way {
    /// A sample was inserted, or edges were turned.
    Done,
    /// An edge that stays is in the way.
    Blocked,
}

impl Refinement<'_> {
    /// See [`mend`].
    fn mend(&mut self, tester: &Tester<'_>) -> Result<u64, Cancelled> {
        let mut turned = HashSet::new();
        loop {
            let (mut mended, mut left) = (false, 0);
            let mut e = 0;
            while e < 3 * self.surface.topology.len() {
                if e.is_multiple_of(EDGES_BETWEEN_CHECKS) {
                    self.cancel.check()?;
                }
                if let Some(stray) = self.stray_at(tester, e) {
                    match self.mend_edge(tester, e, &stray, &mut turned) {
                        Way::Done => mended = true,
                        Way::Blocked => left += 1,
                    }
                }
                e += 1;
            }
            if !mended {
                return Ok(left);
            }
            self.run()?;
        }
    }

    /// Where an edge between two triangles strays, at that of its half-edges which is met first.
    fn stray_at(&self, tester: &Tester<'_>, e: u32) -> Option<Stray> {
        let topology = &self.surface.topology;
        if topology.is_locked(e) || topology.twin(e) < e {
            return None;
        }
        let [p, q] = [topology.origin(e), topology.origin(next(e))].map(|v| self.surface.vertices[v as usize]);
        tester.stray(p, q)
    }

    /// Inserts a sample of the side that an edge strays at. Where both are vertices turns the edge, or, as a last resort, those
    /// around it that are not Delaunay.
    fn mend_edge(&mut self, tester: &Tester<'_>, e: u32, stray: &Stray, turned: &mut HashSet<[u32; 2]>) -> Way {
        let width = self.scanner.tile.width;
        let mut are_vertices = true;
        for (column, row) in stray.side {
            let sample = (row * width + column) as u64;
            let site = self.surface.locate(e / 3, self.place(sample));
            if !self.stays(site) && self.insert_at(site, sample).is_some() {
                return Way::Done;
            }
            are_vertices &= matches!(site, Site::Vertex(_));
        }
        if are_vertices && (self.turn(tester, e, turned) || self.legalize_near(e)) { Way::Done } else { Way::Blocked }
    }

    /// Turns an edge, if its triangles are then within the tolerance and the new edge does not stray. None is turned twice.
    fn turn(&mut self, tester: &Tester<'_>, e: u32, turned: &mut HashSet<[u32; 2]>) -> bool {
        if !self.surface.is_convex(e) {
            return false;
        }
        let topology = &self.surface.topology;
        let numbers = [e, next(e), prev(e), prev(topology.twin(e))].map(|e| topology.origin(e));
        let [x, y, p, q] = numbers.map(|v| self.surface.vertices[v as usize]);
        let fits = |corners| self.scanner.candidate(corners, [false; 3]).is_none();
        if !tester.may_join(p, q) || !fits([x, q, p]) || !fits([q, y, p]) {
            return false;
        }
        if !turned.insert([numbers[0].min(numbers[1]), numbers[0].max(numbers[1])]) {
            return false;
        }
        let both = self.surface.topology.flip(e);
        both.into_iter().for_each(|t| self.rescan(t));
        true
    }

    /// Turns the nearest edges that are not Delaunay, and those that are not because of it.
    fn legalize_near(&mut self, e: u32) -> bool {
        let mut reached = vec![e / 3];
        let mut seen = vec![false; self.surface.topology.len() as usize];
        seen[e as usize / 3] = true;
        let mut ahead = 0;
        while ahead < reached.len() {
            let behind = reached.len();
            let suspects = reached[ahead..].iter().flat_map(|&t| 3 * t..3 * t + 3).collect();
            let changed = self.surface.legalize_from(suspects);
            if !changed.is_empty() {
                changed.into_iter().for_each(|t| self.rescan(t));
                return true;
            }
            for i in ahead..behind {
                for side in 3 * reached[i]..3 * reached[i] + 3 {
                    let is_locked = self.surface.topology.is_locked(side);
                    let beyond = self.surface.topology.twin(side) / 3;
                    if !is_locked && !std::mem::replace(&mut seen[beyond as usize], true) {
                        reached.push(beyond);
                    }
                }
            }
            ahead = behind;
        }
        false
    }
}
