//! Mending: samples are inserted where edges stray farther than they may ([`Task::max_stray`]), whatever made the mesh.
//!
//! A mesh of all samples with Delaunay edges keeps every limit of at least one tolerance: none of its edges crosses a side of a
//! cell. So of a side that is crossed a sample is inserted, then whatever that leaves beyond the tolerance, until no edge
//! strays. Where a locked edge is in the way, an edge may be left.

use super::first::loop_edges;
use super::refine::{FreeRim, Refinement};
use super::topology::{next, prev};
use super::{InsertionOptions, Scratch, Task};
use crate::base::RasterRim;
use crate::base::control::Cancelled;
use crate::base::mesh::TileMesh;
use crate::kernel::triangulate::EngineScratch;
use crate::kernel::triangulate::feasible::{Stray, Tester};

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

impl Refinement<'_> {
    /// See [`mend`].
    fn mend(&mut self, tester: &Tester<'_>) -> Result<u64, Cancelled> {
        loop {
            let (mut mended, mut left) = (false, 0);
            let mut e = 0;
            while e < 3 * self.surface.topology.len() {
                if e.is_multiple_of(1024) {
                    self.cancel.check()?;
                }
                if let Some(stray) = self.stray_at(tester, e) {
                    if self.put_in(e, &stray) || self.turn(tester, e) {
                        mended = true;
                    } else {
                        left += 1;
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

    /// Inserts a sample of the side that an edge strays at, or else one of the edge's triangles. Returns whether there was one.
    fn put_in(&mut self, e: u32, stray: &Stray) -> bool {
        let (t, u) = (e / 3, self.surface.topology.twin(e) / 3);
        let width = self.scanner.tile.width;
        let of_side = stray.side.map(|(column, row)| Some((row * width + column) as u64));
        let of_triangle = |t: u32| self.scanner.farthest_inside(self.surface.corners(t), self.locked(t));
        let all = of_side.into_iter().chain([of_triangle(t), of_triangle(u)]);
        let samples: Vec<u64> = all.flatten().collect();
        samples.into_iter().any(|sample| {
            let site = self.surface.locate(t, self.place(sample));
            !self.stays(site) && self.insert_at(site, sample).is_some()
        })
    }

    /// Turns an edge, if its triangles are then within the tolerance and the new edge does not stray.
    fn turn(&mut self, tester: &Tester<'_>, e: u32) -> bool {
        if !self.surface.is_convex(e) {
            return false;
        }
        let ends = [prev(e), prev(self.surface.topology.twin(e))].map(|e| self.surface.topology.origin(e));
        let [p, q] = ends.map(|v| self.surface.vertices[v as usize]);
        let [x, y] = [e, next(e)].map(|e| self.surface.vertices[self.surface.topology.origin(e) as usize]);
        let fits = |corners| self.scanner.candidate(corners, [false; 3]).is_none();
        if !tester.may_join(p, q) || !fits([x, q, p]) || !fits([q, y, p]) {
            return false;
        }
        let [t, u] = self.surface.topology.flip(e);
        [t, u].into_iter().for_each(|t| self.rescan(t));
        true
    }
}
