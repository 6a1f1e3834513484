//! The rim of the ground yet untriangulated, as corner nodes, and the three cuts.

use super::Edge;
use super::edge_grid::EdgeGrid;
use super::slits::Rims;
use crate::base::handed_over::RESERVED_SAMPLES;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::{Domain, TileMesh, Vertex};

/// The rim of the untriangulated ground, and the mesh eaten so far.
///
/// The rim is kept as corner nodes. Several nodes may stand at one vertex, each with a wedge of ground of its own (a
/// pinch); the loops that the nodes form are the paper's list of polygons. The ground lies to the left of every edge.
/// Nodes are made and die and are never reused, so a corner or an edge named by its nodes is either still there or gone
/// for good.
#[derive(Debug)]
pub(super) struct Front {
    nodes: Vec<Node>,
    pub(super) grid: EdgeGrid,
    pub(super) far_corner: Point,
    /// A place on every hole's rim, by y, then by x. A triangle around a whole hole crosses nothing: only this gives it away.
    pub(super) holes: Vec<Point>,
    /// The given points, by y, then by x. Each stays uncovered until it is a corner.
    points: Vec<Vertex>,
    /// The number of the first of them in the mesh.
    first_point: u32,
    rims: Rims,
    mesh: TileMesh,
    alive: usize,
    fresh: Fresh,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    vertex: Vertex,
    /// The vertex's number in the mesh.
    index: u32,
    prev: u32,
    /// [`DEAD`] once the node is eaten.
    next: u32,
}

const DEAD: u32 = u32::MAX;

/// What cuts have left to look at: nodes whose wedge is new, and new edges.
#[derive(Debug, Default)]
pub(super) struct Fresh {
    pub(super) corners: Vec<u32>,
    pub(super) edges: Vec<Edge>,
}

/// Where a bite's third corner is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Apex {
    /// Inside the ground: it becomes a vertex.
    New(Vertex),
    /// At a node of the front whose wedge the bite reaches into.
    Node(u32),
}

impl Default for Front {
    fn default() -> Self {
        Front {
            nodes: Vec::new(),
            grid: EdgeGrid::default(),
            far_corner: Point { x: 0, y: 0 },
            holes: Vec::new(),
            points: Vec::new(),
            first_point: 0,
            rims: Rims::default(),
            mesh: TileMesh::default(),
            alive: 0,
            fresh: Fresh::default(),
        }
    }
}

impl Front {
    /// Starts anew with the rim of a domain, none of it eaten, reusing the memory. `mesh` lends its own.
    pub(super) fn reset(&mut self, domain: &Domain, far_corner: Point, mut mesh: TileMesh) {
        mesh.clear();
        // Pages that are not needed stay untouched, and lists that double take up to twice what they hold.
        let samples = ((far_corner.x / STEPS + 1) as usize * (far_corner.y / STEPS + 1) as usize).min(RESERVED_SAMPLES);
        mesh.vertices.reserve_exact(samples);
        mesh.triangles.reserve_exact(2 * samples);
        mesh.vertices.extend(domain.fixed());
        self.mesh = mesh;
        self.nodes.clear();
        self.grid.reset(far_corner);
        self.far_corner = far_corner;
        self.points.clear();
        self.points.extend_from_slice(&domain.points);
        self.first_point = domain.vertices.len() as u32;
        self.rims.find(domain);
        self.holes.clear();
        self.holes.append(&mut self.rims.holes);
        self.holes.sort_unstable_by_key(|h| (h.y, h.x));
        self.fresh.corners.clear();
        self.fresh.edges.clear();
        let vertex = |&(index, _): &(u32, u32)| (domain.vertices[index as usize], index);
        let corners = self.rims.edges.iter().map(vertex).zip(&self.rims.next);
        self.nodes.extend(corners.map(|((vertex, index), &next)| Node { vertex, index, prev: DEAD, next }));
        for node in 0..self.nodes.len() as u32 {
            let next = self.next(node);
            self.nodes[next as usize].prev = node;
        }
        self.alive = self.nodes.len();
        for node in 0..self.nodes.len() as u32 {
            self.list_edge(node);
            self.fresh.corners.push(node);
        }
    }

    /// Nodes still on the front.
    pub(super) fn alive(&self) -> usize {
        self.alive
    }

    /// The vertex a node stands at.
    #[inline(always)]
    pub(super) fn vertex(&self, node: u32) -> Vertex {
        self.nodes[node as usize].vertex
    }

    /// The place a node stands at.
    #[inline(always)]
    pub(super) fn at(&self, node: u32) -> Point {
        self.nodes[node as usize].vertex.at
    }

    /// The node before.
    #[inline(always)]
    pub(super) fn prev(&self, node: u32) -> u32 {
        self.nodes[node as usize].prev
    }

    /// The node after; meaningful while the node is alive.
    #[inline(always)]
    pub(super) fn next(&self, node: u32) -> u32 {
        self.nodes[node as usize].next
    }

    /// Whether the edge is still on the front. Nodes are not reused, so the first one's link tells.
    #[inline(always)]
    pub(super) fn has_edge(&self, (a, b): Edge) -> bool {
        self.next(a) == b
    }

    /// Whether an edge of the front leads from a node to a place, whichever node stands there.
    pub(super) fn leads_to(&self, node: u32, to: Point) -> bool {
        self.next(node) != DEAD && self.at(self.next(node)) == to
    }

    /// What the cuts since the last call have left to look at, into emptied lists.
    pub(super) fn take_fresh(&mut self, into: &mut Fresh) {
        into.corners.clear();
        into.edges.clear();
        std::mem::swap(&mut self.fresh, into);
    }

    /// The mesh, once the front is eaten up.
    pub(super) fn take_mesh(&mut self) -> TileMesh {
        std::mem::take(&mut self.mesh)
    }

    /// Counts a triangle that is not as feasible as was asked.
    pub(super) fn count_relaxed(&mut self) {
        self.mesh.relaxed += 1;
    }

    /// The places of one loop, for messages.
    pub(super) fn some_loop(&self) -> Vec<Point> {
        let Some(start) = (0..self.nodes.len() as u32).find(|&n| self.next(n) != DEAD) else { return Vec::new() };
        let walk = std::iter::successors(Some(start), |&n| Some(self.next(n)).filter(|&n| n != start));
        walk.take(64).map(|n| self.at(n)).collect()
    }

    /// Every node alive, for searches of last resort.
    pub(super) fn nodes_alive(&self) -> impl Iterator<Item = u32> {
        (0..self.nodes.len() as u32).filter(|&n| self.next(n) != DEAD)
    }

    /// Cuts the ear p–i–q off:
    ///
    /// ```text
    ///   q ◄── i          q
    ///         ▲    →      ▲
    ///         p             p
    /// ```
    ///
    /// or, where it is all that is left of its polygon, eats the polygon up.
    pub(super) fn cut_ear(&mut self, p: u32, i: u32, q: u32) {
        debug_assert!(self.next(p) == i && self.next(i) == q, "ear {p} {i} {q}");
        self.mesh.triangles.push([p, i, q].map(|n| self.nodes[n as usize].index));
        let closed = self.next(q) == p;
        self.unlist_edge(p);
        self.unlist_edge(i);
        self.kill(i);
        if closed {
            self.unlist_edge(q);
            self.kill(p);
            self.kill(q);
            return;
        }
        self.link(p, q);
        self.list_edge(p);
        self.fresh.corners.extend([p, q]);
    }

    /// Bites a triangle off the edge a–b, and returns the node at the apex before b.
    ///
    /// ```text
    ///   new vertex: the edge bends        a node k of the front: its polygon splits in two,
    ///                                     k keeps its way on, a twin n takes its way in
    ///      v
    ///     ↗ ↘                                  ──► k ──►          ──► n   k ──►
    ///    a   b                                    ▲ ╲       →          ╲  ▲
    ///                                          a ──► b              b ◄   a
    /// ```
    pub(super) fn bite(&mut self, (a, b): Edge, apex: Apex) -> u32 {
        debug_assert!(self.has_edge((a, b)), "edge {a} {b}");
        self.unlist_edge(a);
        match apex {
            Apex::New(vertex) => {
                let index = self.number_of(vertex);
                self.push_triangle(a, b, index);
                let node = self.push_node(Node { vertex, index, prev: a, next: b });
                self.link(a, node);
                self.link(node, b);
                self.list_edge(a);
                self.list_edge(node);
                self.fresh.corners.extend([a, node, b]);
                node
            }
            Apex::Node(k) => {
                let Node { vertex, index, prev, .. } = self.nodes[k as usize];
                self.push_triangle(a, b, index);
                let twin = self.push_node(Node { vertex, index, prev, next: b });
                self.link(prev, twin);
                self.link(twin, b);
                self.link(a, k);
                self.list_edge(a);
                self.list_edge(twin);
                // prev's edge is now named by the same node and leads to the same place, but to another node.
                self.fresh.edges.push((prev, twin));
                self.fresh.corners.extend([prev, a, k, twin, b]);
                twin
            }
        }
    }

    /// The number of a new vertex in the mesh; that of a given point, where it is one.
    fn number_of(&mut self, vertex: Vertex) -> u32 {
        match self.points.binary_search_by_key(&(vertex.at.y, vertex.at.x), |p| (p.at.y, p.at.x)) {
            Ok(point) => self.first_point + point as u32,
            Err(_) => {
                self.mesh.vertices.push(vertex);
                self.mesh.vertices.len() as u32 - 1
            }
        }
    }

    /// Whether a given point lies in a closed triangle, other than at a corner.
    pub(super) fn covers_point(&self, corners: [Point; 3]) -> bool {
        if self.points.is_empty() {
            return false;
        }
        let [a, b, c] = corners;
        let (left, right) = (a.x.min(b.x).min(c.x), a.x.max(b.x).max(c.x));
        let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let is_covered =
            |p: Point| orient(a, b, p) >= 0 && orient(b, c, p) >= 0 && orient(c, a, p) >= 0 && !corners.contains(&p);
        // Row by row, as others stand to the left and right.
        let mut rest = &self.points[self.points.partition_point(|p| p.at.y < top)..];
        while let Some(row) = rest.first().map(|p| p.at.y).filter(|y| *y <= bottom) {
            let (this, below) = rest.split_at(rest.partition_point(|p| p.at.y == row));
            let near = &this[this.partition_point(|p| p.at.x < left)..];
            if near.iter().take_while(|p| p.at.x <= right).any(|p| is_covered(p.at)) {
                return true;
            }
            rest = below;
        }
        false
    }

    fn push_triangle(&mut self, a: u32, b: u32, apex: u32) {
        let [a, b] = [a, b].map(|n| self.nodes[n as usize].index);
        self.mesh.triangles.push([a, b, apex]);
    }

    fn push_node(&mut self, node: Node) -> u32 {
        self.nodes.push(node);
        self.alive += 1;
        self.nodes.len() as u32 - 1
    }

    fn kill(&mut self, node: u32) {
        self.nodes[node as usize].next = DEAD;
        self.alive -= 1;
    }

    fn link(&mut self, a: u32, b: u32) {
        self.nodes[a as usize].next = b;
        self.nodes[b as usize].prev = a;
    }

    /// Puts the edge that begins at a node on the grid.
    fn list_edge(&mut self, node: u32) {
        let next = self.next(node);
        self.grid.insert(node, self.at(node), self.at(next));
        self.fresh.edges.push((node, next));
    }

    fn unlist_edge(&mut self, node: u32) {
        let (a, b) = (self.at(node), self.at(self.next(node)));
        self.grid.remove(node, a, b);
    }
}
