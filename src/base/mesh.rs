//! What an engine is asked for and what it gives: vertices on a tile's lattice, triangles over them.

use crate::base::lattice::{Point, orient};

/// A vertex of a mesh: a place on the tile's lattice and a height of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// The place, tile-local.
    pub at: Point,
    /// The surface's height there, in the raster's units.
    pub height: f64,
}

/// The ground an engine is to triangulate.
///
/// Loops are closed, name vertices by index, and keep the ground to their left ([`orient`] > 0 turns left). Their edges
/// are locked: none is split, every vertex of a loop becomes a vertex of the mesh. Two corners may name one vertex
/// (a pinch); the wedge to the left of each of them must then be one wedge of ground, without edges of the domain in it:
/// a loop that comes to such a vertex leaves it by the leftmost edge, so holes that touch there are one loop. Every edge
/// of a loop is within the tolerance (their limits, where samples have weights) at the samples it passes.
///
/// Edges are edges that the mesh must have, locked like those of loops: inside the ground, where they cross no other edge, or along
/// a loop. Their ends are among the vertices; those that no loop has come after those that one has. An engine that can take them says
/// so ([`crate::kernel::triangulate::Capabilities::edges`]).
///
/// Points are vertices inside the ground that the mesh must have, too; no edge of a loop passes one. An engine that can
/// take them says so ([`crate::kernel::triangulate::Capabilities::points`]); the others are given none.
#[derive(Debug, Clone, Default)]
pub struct Domain {
    /// The vertices of the loops, then those of edges alone.
    pub vertices: Vec<Vertex>,
    /// The loops, as indices of vertices.
    pub loops: Vec<Vec<u32>>,
    /// The points: inside the ground, on no loop, no two at one place; by rows, then by columns.
    pub points: Vec<Vertex>,
    /// The edges, as indices of vertices, the lower first; in order, each once.
    pub edges: Vec<(u32, u32)>,
}

/// All directed edges of a domain's loops, sorted.
pub(crate) fn loop_edges(domain: &Domain) -> Vec<(u32, u32)> {
    let mut edges = Vec::with_capacity(domain.loops.iter().map(Vec::len).sum());
    for l in &domain.loops {
        edges.extend((0..l.len()).map(|i| (l[i], l[(i + 1) % l.len()])));
    }
    edges.sort_unstable();
    edges
}

/// The directed edges of a domain that have no triangle on their other side, or are to be as if they had none: those of the loops,
/// and its edges both ways; sorted.
pub(crate) fn locked_edges(domain: &Domain) -> Vec<(u32, u32)> {
    let mut edges = loop_edges(domain);
    let is_of_loop = |edge: &(u32, u32)| edges.binary_search(edge).is_ok();
    let both = domain.edges.iter().flat_map(|&(a, b)| [(a, b), (b, a)]);
    // What lies beyond an edge of a loop is no ground, unless another loop says so.
    let inside = both.filter(|&(a, b)| !is_of_loop(&(a, b)) && !is_of_loop(&(b, a))).collect::<Vec<_>>();
    edges.extend(inside);
    edges.sort_unstable();
    edges
}

impl Domain {
    /// The vertices that every mesh of this domain begins with: those of the loops, then the points.
    pub fn fixed(&self) -> impl Iterator<Item = Vertex> {
        self.vertices.iter().chain(&self.points).copied()
    }

    /// Twice the area inside the loops, in square lattice steps. Exact.
    pub fn area(&self) -> i128 {
        self.loops.iter().map(|l| self.loop_area(l)).sum()
    }

    /// A place on the rim of every hole: of every loop that turns the other way.
    pub fn holes(&self) -> impl Iterator<Item = Point> {
        self.loops.iter().filter(|l| self.loop_area(l) < 0).map(|l| self.vertices[l[0] as usize].at)
    }

    fn loop_area(&self, corners: &[u32]) -> i128 {
        let origin = Point { x: 0, y: 0 };
        let at = |i: usize| self.vertices[corners[i % corners.len()] as usize].at;
        (0..corners.len()).map(|i| i128::from(orient(origin, at(i), at(i + 1)))).sum()
    }
}

/// A triangulated tile.
///
/// The first vertices are the domain's vertices, then its points, both in the domain's order ([`Domain::fixed`]); then come those
/// that the engine chose. Triangles are indices with positive orientation in the lattice. Every vertex is in a triangle. Every edge is shared by two triangles in opposite directions, or is an
/// edge of one of the domain's loops.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TileMesh {
    /// The vertices.
    pub vertices: Vec<Vertex>,
    /// Indices of vertices, three to a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Triangles that keep the weak but not the strong feasibility they were asked for.
    pub relaxed: u64,
}

impl TileMesh {
    /// The three vertices of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [Vertex; 3] {
        triangle.map(|i| self.vertices[i as usize])
    }

    /// Forgets the mesh, keeps its memory.
    pub fn clear(&mut self) {
        self.vertices.clear();
        self.triangles.clear();
        self.relaxed = 0;
    }
}
