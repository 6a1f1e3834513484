//! The triangulation in the plane: where places are, and which edges are Delaunay.

use super::topology::{NONE, Topology, next, prev};
use crate::base::lattice::{Point, dot, in_circle, orient};
use crate::base::mesh::Vertex;

/// A triangulation with places and heights: what greedy insertion refines.
#[derive(Debug, Default)]
pub(super) struct Surface {
    pub(super) vertices: Vec<Vertex>,
    pub(super) topology: Topology,
    /// Edges to be looked at, as half-edges; empty between calls.
    suspects: Vec<u32>,
}

/// Where a place is in a triangulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Site {
    /// Inside a triangle.
    Triangle(u32),
    /// On an edge, between its ends. Of an edge's two half-edges the one that starts at the lower vertex number.
    Edge(u32),
    /// At a vertex: a half-edge that starts there.
    Vertex(u32),
    /// Not on the ground.
    Outside,
}

impl Surface {
    /// Makes room for this number of vertices, and their triangles.
    pub(super) fn reserve(&mut self, vertices: usize) {
        self.vertices.reserve_exact(vertices.saturating_sub(self.vertices.len()));
        self.topology.reserve(2 * vertices);
    }

    pub(super) fn clear(&mut self) {
        self.vertices.clear();
        self.topology.clear();
        self.suspects.clear();
    }

    #[inline(always)]
    pub(super) fn at(&self, vertex: u32) -> Point {
        self.vertices[vertex as usize].at
    }

    /// The corners of a triangle as vertices.
    #[inline(always)]
    pub(super) fn corners(&self, t: u32) -> [Vertex; 3] {
        self.topology.corners(t).map(|v| self.vertices[v as usize])
    }

    /// Where `p` lies within triangle `t`, which holds it.
    pub(super) fn site_in(&self, t: u32, p: Point) -> Site {
        if let Some(e) = (3 * t..3 * t + 3).find(|&e| self.at(self.topology.origin(e)) == p) {
            return Site::Vertex(e);
        }
        let on = |&e: &u32| orient(self.at(self.topology.origin(e)), self.at(self.topology.origin(next(e))), p) == 0;
        match [3 * t, 3 * t + 1, 3 * t + 2].iter().find(|e| on(e)) {
            Some(&e) => Site::Edge(self.canonical(e)),
            None => Site::Triangle(t),
        }
    }

    /// So that an edge is split in one way, whichever of its triangles led to it.
    fn canonical(&self, e: u32) -> u32 {
        let twin = self.topology.twin(e);
        if !self.topology.is_locked(e) && self.topology.origin(twin) < self.topology.origin(e) { twin } else { e }
    }

    /// Finds a place by walking from triangle `from` (Guibas & Stolfi's walk; section 4.1.1). Between holes, and in
    /// triangulations that are not Delaunay (section 4.5.3), the walk may not arrive: then all triangles are looked at.
    pub(super) fn locate(&self, from: u32, p: Point) -> Site {
        let mut t = from;
        let mut entered = NONE;
        // A walk in a Delaunay triangulation visits no triangle twice; one that goes on so long goes around.
        let mut steps = 64 + 4 * (self.topology.len() as f64).sqrt() as u32;
        while steps > 0 {
            let leave = (0..3).map(|i| 3 * t + i).find(|&e| e != entered && self.is_right_of(e, p));
            let Some(e) = leave else { return self.site_in(t, p) };
            if self.topology.is_locked(e) {
                break;
            }
            entered = self.topology.twin(e);
            t = entered / 3;
            steps -= 1;
        }
        let holds = |&t: &u32| (0..3).all(|i| !self.is_right_of(3 * t + i, p));
        (0..self.topology.len()).find(holds).map_or(Site::Outside, |t| self.site_in(t, p))
    }

    fn is_right_of(&self, e: u32, p: Point) -> bool {
        orient(self.at(self.topology.origin(e)), self.at(self.topology.origin(next(e))), p) < 0
    }

    /// Whether a half-edge passes a place between its ends.
    pub(super) fn passes(&self, e: u32, p: Point) -> bool {
        let (a, b) = (self.at(self.topology.origin(e)), self.at(self.topology.origin(next(e))));
        orient(a, b, p) == 0 && dot(p, a, b) < 0
    }

    /// Puts vertex number `v` where it is, by spokes to the corners around (section 4.2.1), and marks the edges
    /// around it as suspect. One of its triangles; `None` where there is a vertex already, or no ground.
    pub(super) fn connect(&mut self, v: u32, site: Site) -> Option<u32> {
        let (around, count) = match site {
            Site::Triangle(t) => {
                let [a, b, c] = self.topology.split_triangle(t, v);
                ([a, b, c, NONE], 3)
            }
            Site::Edge(e) => self.topology.split_edge(e, v),
            Site::Vertex(_) | Site::Outside => return None,
        };
        self.suspects.extend(around[..count].iter().rev().map(|t| 3 * t));
        Some(around[0])
    }

    /// The next edge marked as suspect.
    pub(super) fn take_suspect(&mut self) -> Option<u32> {
        self.suspects.pop()
    }

    /// Whether the two triangles of an edge make a strictly convex quadrilateral, so that it can be flipped.
    pub(super) fn is_convex(&self, e: u32) -> bool {
        let f = self.topology.twin(e);
        let [x, y, p, q] = self.quadrilateral(e, f).map(|v| self.at(v));
        orient(p, x, q) > 0 && orient(p, q, y) > 0
    }

    /// The ends of an edge, and the vertices opposite on its left and on its right.
    #[inline(always)]
    pub(super) fn quadrilateral(&self, e: u32, twin: u32) -> [u32; 4] {
        let t = &self.topology;
        [t.origin(e), t.origin(next(e)), t.origin(prev(e)), t.origin(prev(twin))]
    }

    /// Flips an edge and marks the two edges opposite its left vertex as suspect.
    pub(super) fn flip(&mut self, e: u32) -> [u32; 2] {
        let [t, u] = self.topology.flip(e);
        self.suspects.extend([3 * u, 3 * t]);
        [t, u]
    }

    /// Flips suspect edges until all pass the circle test (Lawson): Delaunay, but for locked edges.
    pub(super) fn legalize(&mut self) {
        while let Some(e) = self.suspects.pop() {
            if self.topology.is_locked(e) {
                continue;
            }
            let f = self.topology.twin(e);
            let [x, y, p, q] = self.quadrilateral(e, f).map(|v| self.at(v));
            if in_circle(x, y, p, q) {
                self.flip(e);
            }
        }
    }

    /// Turns suspect edges, none of them locked, where the triangles that come of it would face up and `turns` wants them.
    pub(super) fn turn_while(&mut self, turns: &mut impl FnMut([Vertex; 4]) -> bool) {
        while let Some(e) = self.suspects.pop() {
            if self.topology.is_locked(e) || !self.is_convex(e) {
                continue;
            }
            let corners = self.quadrilateral(e, self.topology.twin(e)).map(|v| self.vertices[v as usize]);
            if turns(corners) {
                self.flip(e);
            }
        }
    }

    /// Makes a whole triangulation Delaunay but for locked edges.
    pub(super) fn legalize_all(&mut self) {
        self.legalize_from((0..3 * self.topology.len()).rev().collect());
    }

    /// Makes these edges Delaunay, and those that are not because of it; returns the triangles that have changed.
    pub(super) fn legalize_from(&mut self, mut pending: Vec<u32>) -> Vec<u32> {
        let mut changed = Vec::new();
        while let Some(e) = pending.pop() {
            if self.topology.is_locked(e) {
                continue;
            }
            let f = self.topology.twin(e);
            let [x, y, p, q] = self.quadrilateral(e, f).map(|v| self.at(v));
            if in_circle(x, y, p, q) {
                let [t, u] = self.topology.flip(e);
                pending.extend([3 * t, 3 * t + 2, 3 * u, 3 * u + 1]);
                changed.extend([t, u]);
            }
        }
        changed.sort_unstable();
        changed.dedup();
        changed
    }
}
