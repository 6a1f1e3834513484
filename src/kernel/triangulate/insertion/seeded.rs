//! Triangulations that others have begun: a domain with further vertices inside, and a mesh that is refined as it is.

use super::first;
use super::refine::{FreeRim, Refinement};
use super::surface::Site;
use super::{InsertionOptions, Scratch, Task};
use crate::base::control::Cancelled;
use crate::base::handed_over::{DENSE, clear, make_room};
use crate::base::mesh::{Domain, TileMesh, Vertex, locked_edges};

/// Triangulates the ground of a domain with further vertices inside it: Delaunay but for the edges of loops. Vertices
/// off the ground, on an edge of a loop or where there is a vertex are left out. Neighbours in the list should be near
/// one another. Nothing is said of errors.
pub fn delaunay(domain: &Domain, inside: impl Iterator<Item = Vertex>, scratch: &mut Scratch, mesh: &mut TileMesh) {
    mesh.clear();
    let surface = &mut scratch.surface;
    std::mem::swap(&mut surface.vertices, &mut mesh.vertices);
    first::triangulate(domain, surface);
    let mut near = domain.points.iter().fold(0, |near, &point| Refinement::preinsert(surface, near, point));
    for vertex in inside {
        let site = surface.locate(near, vertex.at);
        if matches!(site, Site::Edge(e) if surface.topology.is_locked(e)) {
            continue;
        }
        let number = surface.vertices.len() as u32;
        surface.vertices.push(vertex);
        match surface.connect(number, site) {
            Some(t) => near = t,
            None => {
                surface.vertices.pop();
            }
        }
        surface.legalize();
    }
    std::mem::swap(&mut surface.vertices, &mut mesh.vertices);
    make_room(&mut mesh.triangles, surface.topology.len() as usize);
    mesh.triangles.extend((0..surface.topology.len()).map(|t| surface.topology.corners(t)));
}

/// What becomes of edges with one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::kernel::triangulate) enum Rim {
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
        self.surface.clear();
        std::mem::swap(&mut self.surface.vertices, &mut mesh.vertices);
        let edges = locked_edges(task.domain);
        self.surface.topology.load(&mesh.triangles, self.surface.vertices.len(), &edges);
        clear(&mut mesh.triangles, DENSE);
        mesh.clear();
        self.refine(options, task)
    }
}
