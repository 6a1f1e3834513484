//! Triangles and how they hang together, apart from where they are.

use crate::kernel::links::{self, HalfEdges, pair_sides};

/// No half-edge: the other side of a locked edge.
pub(super) const NONE: u32 = links::NONE;

/// A triangulation as half-edges. Half-edge 3t + i runs from corner i of triangle t to its next corner; corners go
/// around with the triangle to the left. Every half-edge has its twin in the neighbour, or [`NONE`] where the edge is
/// locked (the rim of the ground).
///
/// Every operation leaves the vertex it is about at corner 2 of the triangles around it, so their half-edge 0 is the
/// one opposite.
#[derive(Debug, Default, Clone)]
pub(super) struct Topology {
    origins: Vec<u32>,
    twins: Vec<u32>,
    /// By vertex, a locked half-edge that leaves it; empty where nobody asks.
    leaving: Vec<u32>,
}

/// The next half-edge of the same triangle.
#[inline(always)]
pub(super) fn next(e: u32) -> u32 {
    if e % 3 == 2 { e - 2 } else { e + 1 }
}

/// The half-edge before in the same triangle.
#[inline(always)]
pub(super) fn prev(e: u32) -> u32 {
    if e.is_multiple_of(3) { e + 2 } else { e - 1 }
}

impl Topology {
    pub(super) fn clear(&mut self) {
        self.origins.clear();
        self.twins.clear();
        self.leaving.clear();
    }

    /// Keeps in mind from now on where the locked half-edges of the first `vertices` are.
    pub(super) fn track_locked(&mut self, vertices: usize) {
        self.leaving.clear();
        self.leaving.resize(vertices, NONE);
        for e in 0..3 * self.len() {
            if self.is_locked(e) {
                self.leaving[self.origins[e as usize] as usize] = e;
            }
        }
    }

    /// The locked half-edge that leaves a vertex; of several any.
    pub(super) fn locked_from(&self, v: u32) -> Option<u32> {
        self.leaving.get(v as usize).copied().filter(|&e| e != NONE)
    }

    /// Becomes these triangles over `vertices` vertices. Edges of one triangle are locked, and half-edges that are listed, sorted.
    ///
    /// # Panics
    /// If an edge has more than two triangles, or two that run along it in the same direction.
    pub(super) fn load(&mut self, triangles: &[[u32; 3]], vertices: usize, locked: &[(u32, u32)]) {
        self.clear();
        self.reserve(triangles.len());
        self.origins.extend(triangles.as_flattened());
        self.twins.resize(self.origins.len(), NONE);
        let count = self.len();
        pair_sides(self, count, &mut vec![NONE; vertices], |a, b| locked.binary_search(&(a, b)).is_ok(), |_, _| true);
    }

    /// Makes room for this number of triangles.
    pub(super) fn reserve(&mut self, triangles: usize) {
        self.origins.reserve_exact((3 * triangles).saturating_sub(self.origins.len()));
        self.twins.reserve_exact((3 * triangles).saturating_sub(self.twins.len()));
    }

    /// How many triangles there are; they are numbered from 0.
    pub(super) fn len(&self) -> u32 {
        self.origins.len() as u32 / 3
    }

    /// The corners of triangle `t`.
    #[inline(always)]
    pub(super) fn corners(&self, t: u32) -> [u32; 3] {
        let i = 3 * t as usize;
        [self.origins[i], self.origins[i + 1], self.origins[i + 2]]
    }

    /// The vertex a half-edge starts at.
    #[inline(always)]
    pub(super) fn origin(&self, e: u32) -> u32 {
        self.origins[e as usize]
    }

    /// The same edge as a half-edge of the neighbour; [`NONE`] where it is locked.
    #[inline(always)]
    pub(super) fn twin(&self, e: u32) -> u32 {
        self.twins[e as usize]
    }

    /// Whether an edge has a triangle on one side only, so that it stays what it is.
    #[inline(always)]
    pub(super) fn is_locked(&self, e: u32) -> bool {
        self.twin(e) == NONE
    }

    /// Keeps some triangles, in their order. Their edges with the others are locked, and those between two vertices for which
    /// `is_locked` says so.
    pub(super) fn retain(&mut self, kept: &[bool], is_locked: impl Fn(u32, u32) -> bool) {
        let mut count = 0;
        let mut number = |&is_kept: &bool| {
            count += u32::from(is_kept);
            if is_kept { count - 1 } else { NONE }
        };
        let numbers: Vec<u32> = kept.iter().map(&mut number).collect();
        for (t, &number) in (0..).zip(&numbers).filter(|(_, number)| **number != NONE) {
            let corners = self.corners(t);
            let twins = [0, 1, 2].map(|i| {
                let f = self.twin(3 * t + i as u32);
                let stays = f != NONE && kept[f as usize / 3] && !is_locked(corners[i], corners[(i + 1) % 3]);
                if stays { 3 * numbers[f as usize / 3] + f % 3 } else { NONE }
            });
            // Never behind the triangle that is looked at.
            self.set(number, corners);
            self.twins[3 * number as usize..3 * number as usize + 3].copy_from_slice(&twins);
        }
        self.origins.truncate(3 * count as usize);
        self.twins.truncate(3 * count as usize);
    }

    /// A triangle of its own, all edges locked so far.
    pub(super) fn add(&mut self, corners: [u32; 3]) -> u32 {
        self.origins.extend(corners);
        self.twins.extend([NONE; 3]);
        self.len() - 1
    }

    /// Makes two half-edges twins; the second may be [`NONE`].
    #[inline(always)]
    pub(super) fn pair(&mut self, e: u32, f: u32) {
        self.twins[e as usize] = f;
        if f != NONE {
            self.twins[f as usize] = e;
        } else if let Some(leaving) = self.leaving.get_mut(self.origins[e as usize] as usize) {
            *leaving = e;
        }
    }

    #[inline(always)]
    fn set(&mut self, t: u32, corners: [u32; 3]) {
        self.origins[3 * t as usize..3 * t as usize + 3].copy_from_slice(&corners);
    }

    /// Puts vertex `v` into triangle `t`; the three triangles around it.
    ///
    /// ```text
    ///      c                 c
    ///     ╱ ╲              ╱ │ ╲
    ///    ╱ t ╲      →     ╱ ·v· ╲
    ///   a─────b          a───────b
    /// ```
    pub(super) fn split_triangle(&mut self, t: u32, v: u32) -> [u32; 3] {
        let [a, b, c] = self.corners(t);
        let [_, bc, ca] = [0, 1, 2].map(|i| self.twin(3 * t + i));
        self.set(t, [a, b, v]);
        let (t1, t2) = (self.add([b, c, v]), self.add([c, a, v]));
        self.pair(3 * t1, bc);
        self.pair(3 * t2, ca);
        self.pair(3 * t + 1, 3 * t1 + 2);
        self.pair(3 * t1 + 1, 3 * t2 + 2);
        self.pair(3 * t2 + 1, 3 * t + 2);
        [t, t1, t2]
    }

    /// Puts vertex `v` onto edge `e`, which may be locked; the triangles around it, two or four.
    ///
    /// ```text
    ///        c                 c
    ///      ╱   ╲             ╱ │ ╲
    ///    a ──e──► b    →   a───v───b
    ///      ╲   ╱             ╲ │ ╱
    ///        d                 d
    /// ```
    pub(super) fn split_edge(&mut self, e: u32, v: u32) -> ([u32; 4], usize) {
        let (f, is_locked) = (self.twin(e), self.is_locked(e));
        let (a, b, c) = (self.origin(e), self.origin(next(e)), self.origin(prev(e)));
        let (bc, ca) = (self.twin(next(e)), self.twin(prev(e)));
        let t = e / 3;
        self.set(t, [c, a, v]);
        let t1 = self.add([b, c, v]);
        self.pair(3 * t, ca);
        self.pair(3 * t1, bc);
        self.pair(3 * t + 2, 3 * t1 + 1);
        if is_locked {
            self.pair(3 * t + 1, NONE);
            self.pair(3 * t1 + 2, NONE);
            return ([t, t1, NONE, NONE], 2);
        }
        let d = self.origin(prev(f));
        let (ad, db) = (self.twin(next(f)), self.twin(prev(f)));
        let u = f / 3;
        self.set(u, [d, b, v]);
        let u1 = self.add([a, d, v]);
        self.pair(3 * u, db);
        self.pair(3 * u1, ad);
        self.pair(3 * u + 2, 3 * u1 + 1);
        self.pair(3 * t + 1, 3 * u1 + 2);
        self.pair(3 * t1 + 2, 3 * u + 1);
        ([t, t1, u, u1], 4)
    }

    /// Turns the edge `e`, not locked, in the quadrilateral of its two triangles; p, the vertex opposite `e`, comes to
    /// corner 2 of both. The two triangles.
    ///
    /// ```text
    ///        p                 p
    ///      ╱   ╲             ╱ │ ╲
    ///    x ──e──► y    →   x t │ u y
    ///      ╲   ╱             ╲ │ ╱
    ///        q                 q
    /// ```
    pub(super) fn flip(&mut self, e: u32) -> [u32; 2] {
        let f = self.twin(e);
        let (x, y, p) = (self.origin(e), self.origin(next(e)), self.origin(prev(e)));
        let q = self.origin(prev(f));
        let (yp, px) = (self.twin(next(e)), self.twin(prev(e)));
        let (xq, qy) = (self.twin(next(f)), self.twin(prev(f)));
        let (t, u) = (e / 3, f / 3);
        self.set(t, [x, q, p]);
        self.set(u, [q, y, p]);
        self.pair(3 * t, xq);
        self.pair(3 * t + 2, px);
        self.pair(3 * u, qy);
        self.pair(3 * u + 1, yp);
        self.pair(3 * t + 1, 3 * u + 2);
        [t, u]
    }

    /// The triangles around the vertex at corner 2 of triangle `t`, which is at corner 2 of all of them; where it lies
    /// on a locked edge, those from one of its locked edges to the other.
    pub(super) fn star(&self, t: u32, into: &mut Vec<u32>) {
        into.clear();
        let mut at = t;
        loop {
            into.push(at);
            if self.is_locked(3 * at + 2) {
                break;
            }
            at = self.twin(3 * at + 2) / 3;
            if at == t {
                return;
            }
        }
        at = t;
        loop {
            if self.is_locked(3 * at + 1) {
                return;
            }
            at = self.twin(3 * at + 1) / 3;
            into.push(at);
        }
    }

    /// Checks that twins are each other's and join the same vertices.
    #[cfg(test)]
    pub(super) fn check(&self) {
        for e in 0..self.origins.len() as u32 {
            let f = self.twin(e);
            if !self.is_locked(e) {
                assert_eq!(self.twin(f), e, "twin of the twin of {e}");
                assert_eq!((self.origin(e), self.origin(next(e))), (self.origin(next(f)), self.origin(f)), "edge {e}");
            }
        }
    }
}

impl HalfEdges for Topology {
    fn corners(&self, t: u32) -> [u32; 3] {
        Topology::corners(self, t)
    }

    fn twin(&self, e: u32) -> u32 {
        Topology::twin(self, e)
    }

    fn set_twin(&mut self, e: u32, twin: u32) {
        self.twins[e as usize] = twin;
    }
}
