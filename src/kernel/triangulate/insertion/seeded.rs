//! Triangulations that others have begun: a domain with further vertices inside, and a mesh that is refined as it is.

use super::first;
use super::refine::{FreeRim, Refinement};
use super::surface::{Site, Surface};
use super::{InsertionOptions, Scratch, Task};
use crate::base::control::Cancelled;
use crate::base::handed_over::{DENSE, clear, make_room};
use crate::base::lattice::{in_circle, orient};
use crate::base::mesh::{Domain, TileMesh, Vertex, locked_edges};

/// Triangulates the ground of a domain with further vertices inside it: Delaunay but for the edges of loops. Vertices
/// off the ground, on an edge of a loop or where there is a vertex are left out. Neighbours in the list should be near
/// one another. Nothing is said of errors.
pub fn delaunay(domain: &Domain, inside: impl Iterator<Item = Vertex>, scratch: &mut Scratch, mesh: &mut TileMesh) {
    mesh.clear();
    let surface = &mut scratch.surface;
    std::mem::swap(&mut surface.vertices, &mut mesh.vertices);
    first::triangulate(domain, surface);
    let near = domain.points.iter().fold(0, |near, &point| Refinement::preinsert(surface, near, point));
    surface.insert_all(near, inside, Rim::Locked, Surface::legalize);
    surface.give_back(mesh);
}

/// Inserts vertices into a mesh as it is, one after the other: the triangle or the edge that a vertex lies on is split, and edges opposite the
/// vertex are turned while `turns` wants them. It is given the ends of the edge, then the vertex, then the one beyond. All other edges
/// stay; with [`is_not_delaunay`] a Delaunay mesh remains one. Vertices off the ground, where there is a vertex, or on an edge of one
/// triangle that is locked are left out. Neighbours in the list should be near one another. Nothing is said of errors.
pub fn insert(
    more: impl Iterator<Item = Vertex>,
    rim: Rim,
    mut turns: impl FnMut([Vertex; 4]) -> bool,
    scratch: &mut Scratch,
    mesh: &mut TileMesh,
) {
    let surface = &mut scratch.surface;
    surface.take(mesh, &[]);
    surface.insert_all(0, more, rim, |surface| surface.turn_while(&mut turns));
    surface.give_back(mesh);
}

/// Whether an edge is to be turned for Delaunay's sake, given its ends and the vertices opposite on its left and on its right.
pub fn is_not_delaunay([x, y, p, q]: [Vertex; 4]) -> bool {
    in_circle(x.at, y.at, p.at, q.at)
}

/// Turns edges of a mesh of which vertices have been moved, until no triangle is turned over or without area; `false` if some stay. Each turn
/// puts one right at least, and turns none over.
pub fn untangle(scratch: &mut Scratch, mesh: &mut TileMesh) -> bool {
    let surface = &mut scratch.surface;
    surface.take(mesh, &[]);
    let is_straight = surface.untangle();
    surface.give_back(mesh);
    is_straight
}

impl Surface {
    /// Becomes a mesh, and leaves it empty. Half-edges that are listed, sorted, are locked.
    fn take(&mut self, mesh: &mut TileMesh, locked: &[(u32, u32)]) {
        self.clear();
        std::mem::swap(&mut self.vertices, &mut mesh.vertices);
        self.topology.load(&mesh.triangles, self.vertices.len(), locked);
        clear(&mut mesh.triangles, DENSE);
        mesh.clear();
    }

    fn give_back(&mut self, mesh: &mut TileMesh) {
        std::mem::swap(&mut self.vertices, &mut mesh.vertices);
        make_room(&mut mesh.triangles, self.topology.len() as usize);
        mesh.triangles.extend((0..self.topology.len()).map(|t| self.topology.corners(t)));
    }

    fn untangle(&mut self) -> bool {
        let is_straight = |surface: &Surface, t: u32| {
            let [a, b, c] = surface.corners(t).map(|v| v.at);
            orient(a, b, c) > 0
        };
        let mut turned: Vec<u32> = (0..self.topology.len()).filter(|&t| !is_straight(self, t)).collect();
        loop {
            let before = turned.len();
            turned.retain(|&t| {
                let can_turn = |e: &u32| !self.topology.is_locked(*e) && self.is_convex(*e);
                if is_straight(self, t) {
                    return false;
                }
                let edge = (3 * t..3 * t + 3).find(can_turn);
                edge.map(|e| self.topology.flip(e)).is_none()
            });
            if turned.is_empty() || turned.len() == before {
                return turned.is_empty();
            }
        }
    }

    /// Inserts vertices, the first of them near a triangle; `settle` then looks at the edges marked as suspect.
    fn insert_all(
        &mut self,
        mut near: u32,
        vertices: impl Iterator<Item = Vertex>,
        rim: Rim,
        mut settle: impl FnMut(&mut Surface),
    ) {
        for vertex in vertices {
            let site = self.locate(near, vertex.at);
            if rim == Rim::Locked && matches!(site, Site::Edge(e) if self.topology.is_locked(e)) {
                continue;
            }
            let number = self.vertices.len() as u32;
            self.vertices.push(vertex);
            match self.connect(number, site) {
                Some(t) => near = t,
                None => {
                    self.vertices.pop();
                }
            }
            settle(self);
        }
    }
}

/// What becomes of edges with one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rim {
    /// They stay as they are.
    Locked,
    /// They are split like others.
    Free,
}

/// Inserts samples into the mesh of a task's ground until every triangle is within the tolerance, the farthest first.
/// Vertices stay, new ones follow. Those at samples are to be within the samples' limits already.
///
/// # Errors
/// [`Cancelled`], with a mesh of no use.
pub(in crate::kernel::triangulate) fn refine(
    task: &Task<'_>,
    rim: Rim,
    scratch: &mut Scratch,
    mesh: &mut TileMesh,
) -> Result<(), Cancelled> {
    let mut refinement = scratch.refine_mesh(InsertionOptions::default(), task, mesh);
    if rim == Rim::Free {
        refinement.free_rim = FreeRim::All;
    }
    refinement.scan_all()?;
    refinement.run()?;
    refinement.finish(mesh);
    scratch.hand_over();
    Ok(())
}

impl Scratch {
    /// A refinement of a mesh of the task's ground, without candidates; `mesh` lends its memory.
    pub(super) fn refine_mesh<'a>(
        &'a mut self,
        options: InsertionOptions,
        task: &Task<'a>,
        mesh: &mut TileMesh,
    ) -> Refinement<'a> {
        self.surface.take(mesh, &locked_edges(task.domain));
        self.refine(options, task)
    }
}
