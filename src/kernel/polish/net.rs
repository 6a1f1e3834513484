//! The mesh while it is being changed: triangles that know their neighbours.

use super::by_rows::number_by_rows;
use super::journal::Journal;
use crate::base::RasterRim;
use crate::base::handed_over::{DENSE, clear, make_room};
use crate::base::lattice::orient;
use crate::base::mesh::{Domain, TileMesh, Vertex, locked_edges};
use crate::kernel::links::{HalfEdges, pair_sides};

/// No half-edge, no vertex, no place.
pub(super) const NONE: u32 = crate::kernel::links::NONE;

/// A triangle and what lies beyond its sides. Side i runs from corner i to the next; it is the half-edge 3t + i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Triangle {
    /// Vertices with positive orientation; all [`NONE`] where there is no triangle any more.
    pub(super) corners: [u32; 3],
    /// For every side the same edge as a side of the neighbour; [`NONE`] on a loop of the domain and on the rim.
    pub(super) twins: [u32; 3],
    /// What is known about its distance from the samples.
    pub(super) fit: Fit,
}

/// How well a triangle fits the samples under it: estimates that steer, nothing that certifies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    /// The objective (see `energy`), summed over its samples.
    pub(super) energy: f32,
    /// The largest error, as a share of the tolerance.
    pub(super) worst: f32,
    /// Where among the tile's heights that is; [`NONE`] where it is small, where nobody looked, or where it is an edge's.
    pub(super) place: u32,
}

impl Default for Fit {
    fn default() -> Fit {
        Fit { energy: 0.0, worst: 0.0, place: NONE }
    }
}

impl Triangle {
    const GONE: Triangle =
        Triangle { corners: [NONE; 3], twins: [NONE; 3], fit: Fit { energy: 0.0, worst: 0.0, place: NONE } };

    pub(super) fn alive(&self) -> bool {
        self.corners[0] != NONE
    }
}

/// Whether an edge that is no loop's may have one triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lone {
    /// No.
    Refused,
    /// Where both its ends are locked, or it runs along the raster's rim.
    OfPart(RasterRim),
}

/// The vertices that are the domain's, of its loops and its points, or that stay for other reasons: those below a number.
#[derive(Debug, Clone, Copy, Default)]
struct Locked(u32);

impl Locked {
    #[inline]
    fn has(self, v: u32) -> bool {
        v < self.0
    }
}

/// A triangulation under change. Slots of triangles and numbers of vertices stay what they are; what is removed leaves
/// its slot empty, and changes never need more slots than they empty.
///
/// Memory: 40 bytes per triangle and 24 per vertex, the journal's marks included. The vertices are the mesh's own list; its
/// triangles are there for as long as it takes to load or store them.
#[derive(Debug, Default)]
pub(super) struct Net {
    pub(super) vertices: Vec<Vertex>,
    /// Per vertex a half-edge that begins there; [`NONE`] where there is no vertex any more.
    pub(super) outgoing: Vec<u32>,
    pub(super) triangles: Vec<Triangle>,
    locked: Locked,
    /// Where a part ends because the raster does.
    pub(super) rim: RasterRim,
    pub(super) journal: Journal,
    /// Half-edges that have no twin whatever lies beyond: of the loops, and of edges that stay, both ways; sorted.
    loops: Vec<(u32, u32)>,
}

impl Net {
    /// Takes over a finished mesh over this domain, numbered by rows, and leaves it empty.
    ///
    /// # Panics
    /// If an edge is neither a loop's nor shared by two triangles in opposite directions.
    pub(super) fn load(&mut self, domain: &Domain, mesh: &mut TileMesh) {
        let locked = domain.fixed().count() as u32;
        number_by_rows(locked, mesh);
        self.take(locked, mesh);
        self.loops = locked_edges(domain);
        self.link_all(Lone::Refused);
    }

    /// Takes over a part of a mesh, whose first vertices are locked, and leaves it empty. Edges between these, and along the
    /// raster's rim, may have one triangle. `edges` between those, the lower vertex first, stay.
    ///
    /// # Panics
    /// If another edge has, or one has more than two.
    pub(super) fn load_part(&mut self, locked: u32, rim: RasterRim, edges: &[(u32, u32)], mesh: &mut TileMesh) {
        self.take(locked, mesh);
        self.rim = rim;
        self.loops.extend(edges.iter().flat_map(|&(a, b)| [(a, b), (b, a)]));
        self.loops.sort_unstable();
        self.link_all(Lone::OfPart(rim));
    }

    fn take(&mut self, locked: u32, mesh: &mut TileMesh) {
        self.locked = Locked(locked);
        std::mem::swap(&mut self.vertices, &mut mesh.vertices);
        mesh.vertices.clear();
        make_room(&mut self.triangles, mesh.triangles.len());
        self.triangles.extend(mesh.triangles.iter().map(|&corners| Triangle { corners, ..Triangle::GONE }));
        clear(&mut mesh.triangles, DENSE);
        make_room(&mut self.outgoing, self.vertices.len());
        self.outgoing.resize(self.vertices.len(), NONE);
        self.journal.reset(self.triangles.len(), self.vertices.len());
        self.loops.clear();
        self.rim = RasterRim::default();
    }

    /// Finds every side's twin. A loop's edge has none, even if another loop runs back along it.
    fn link_all(&mut self, lone: Lone) {
        let Net { loops, vertices, triangles, outgoing, locked, .. } = self;
        let count = triangles.len() as u32;
        let is_rim = |a, b| locked.has(a) && locked.has(b) && loops.binary_search(&(a, b)).is_ok();
        let at = |v: u32| vertices[v as usize].at;
        let may_be_lone = |low, high| match lone {
            Lone::Refused => false,
            Lone::OfPart(rim) => locked.has(high) || rim.joins(at(low), at(high)),
        };
        pair_sides(triangles, count, outgoing, is_rim, may_be_lone);
        for (t, triangle) in (0u32..).zip(&self.triangles) {
            for (i, &v) in (0..).zip(&triangle.corners) {
                self.outgoing[v as usize] = 3 * t + i;
            }
        }
    }

    /// Gives back what is left, as a mesh: the domain's vertices first, everything in the order it was loaded in. What a dense
    /// mesh has taken, is freed.
    pub(super) fn store(&mut self, mesh: &mut TileMesh) {
        let is_dense = self.triangles.len() > DENSE;
        if is_dense {
            self.journal = Journal::default();
        }
        // The half-edges are of no more use: their place takes the new numbers.
        let mut count = 0;
        for v in 0..self.vertices.len() {
            // Those that are locked stay even if no triangle has them: a part of a mesh may be without.
            if self.outgoing[v] != NONE || self.locked.has(count) {
                self.outgoing[v] = count;
                self.vertices[count as usize] = self.vertices[v];
                count += 1;
            }
        }
        self.vertices.truncate(count as usize);
        std::mem::swap(&mut self.vertices, &mut mesh.vertices);
        let alive = || self.triangles.iter().filter(|t| t.alive());
        make_room(&mut mesh.triangles, alive().count());
        mesh.triangles.extend(alive().map(|t| t.corners.map(|v| self.outgoing[v as usize])));
        if is_dense {
            *self = Net::default();
        }
    }

    /// Whether an edge between two vertices stays, as one of the loops or those that a part came with.
    pub(super) fn is_fixed(&self, from: u32, to: u32) -> bool {
        self.loops.binary_search(&(from, to)).is_ok()
    }

    /// Whether a vertex stays what it is.
    #[inline]
    pub(super) fn is_locked(&self, v: u32) -> bool {
        self.locked.has(v)
    }

    /// Whether there is a vertex of this number that may go or move.
    pub(super) fn is_free(&self, v: u32) -> bool {
        !self.is_locked(v) && self.outgoing[v as usize] != NONE
    }

    pub(super) fn vertex(&self, v: u32) -> Vertex {
        self.vertices[v as usize]
    }

    pub(super) fn corners(&self, t: u32) -> [Vertex; 3] {
        self.triangles[t as usize].corners.map(|v| self.vertex(v))
    }

    pub(super) fn twin(&self, half_edge: u32) -> u32 {
        self.triangles[half_edge as usize / 3].twins[half_edge as usize % 3]
    }

    /// Where a half-edge begins.
    pub(super) fn origin(&self, half_edge: u32) -> u32 {
        self.triangles[half_edge as usize / 3].corners[half_edge as usize % 3]
    }

    /// Twice the signed area of three vertices.
    pub(super) fn orient(&self, a: u32, b: u32, c: u32) -> i64 {
        orient(self.vertex(a).at, self.vertex(b).at, self.vertex(c).at)
    }
}

impl HalfEdges for Vec<Triangle> {
    fn corners(&self, t: u32) -> [u32; 3] {
        self[t as usize].corners
    }

    fn twin(&self, e: u32) -> u32 {
        self[e as usize / 3].twins[e as usize % 3]
    }

    fn set_twin(&mut self, e: u32, twin: u32) {
        self[e as usize / 3].twins[e as usize % 3] = twin;
    }
}

/// The next side of the same triangle.
pub(super) fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// The side before it.
pub(super) fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) { half_edge + 2 } else { half_edge - 1 }
}
