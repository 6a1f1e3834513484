//! Holes: rings of vertices whose inside is to be triangulated anew.

use super::net::{NONE, Net, Triangle, next, previous};
use crate::base::mesh::Vertex;

/// A ring of vertices, the triangles inside it, and what lies beyond its edges. Edge i runs from vertex i of the ring to
/// the next, with the inside to its left.
#[derive(Debug, Default)]
pub(super) struct Hole {
    pub(super) ring: Vec<u32>,
    /// For every edge of the ring the neighbour's side along it; [`NONE`] on a loop of the domain or the rim.
    pub(super) outer: Vec<u32>,
    /// Slots of the triangles inside. Around a vertex, triangle i has edge i of the ring; around one on the rim the last edge
    /// has none, as it runs along the rim.
    pub(super) triangles: Vec<u32>,
}

impl Hole {
    /// The triangles inside, by their corners.
    pub(super) fn corners(&self, net: &Net) -> impl Iterator<Item = [Vertex; 3]> {
        self.triangles.iter().map(|&t| net.corners(t))
    }

    fn clear(&mut self) {
        self.ring.clear();
        self.outer.clear();
        self.triangles.clear();
    }

    /// Becomes the star of a vertex that is inside, or free to move along the raster's rim; `false` if its ring is longer than
    /// `longest`.
    pub(super) fn around(&mut self, net: &Net, v: u32, longest: usize) -> bool {
        self.clear();
        let mut start = net.outgoing[v as usize];
        let mut spoke = start;
        loop {
            debug_assert_eq!(net.origin(spoke), v, "half-edge {spoke}");
            let rim = next(spoke);
            self.ring.push(net.origin(rim));
            self.outer.push(net.twin(rim));
            self.triangles.push(spoke / 3);
            let last = previous(spoke);
            spoke = net.twin(last);
            if spoke == start {
                return true;
            }
            if self.ring.len() == longest {
                return false;
            }
            if spoke == NONE {
                let first = net.first_spoke(v);
                if start == first {
                    self.ring.push(net.origin(last));
                    self.outer.push(NONE);
                    return true;
                }
                self.clear();
                (start, spoke) = (first, first);
            }
        }
    }
}

impl Net {
    /// The half-edge along the rim that begins at a vertex on it.
    fn first_spoke(&self, v: u32) -> u32 {
        let mut spoke = self.outgoing[v as usize];
        while self.twin(spoke) != NONE {
            spoke = next(self.twin(spoke));
        }
        spoke
    }

    /// Replaces the triangles of a hole by `filling`: corners as positions on the ring, where the ring's length stands
    /// for the vertex `apex` inside. Together they are to cover the ring's inside once; fits are left to the caller.
    pub(super) fn refill(&mut self, hole: &Hole, filling: &[[u32; 3]], apex: u32, open: &mut Vec<(u32, u32, u32)>) {
        let k = hole.ring.len() as u32;
        let vertex = |position: u32| if position == k { apex } else { hole.ring[position as usize] };
        open.clear();
        for (&slot, &positions) in hole.triangles.iter().zip(filling) {
            self.triangle_mut(slot).corners = positions.map(vertex);
            for i in 0..3 {
                let (a, b) = (positions[i as usize], positions[(i as usize + 1) % 3]);
                let side = 3 * slot + i;
                *self.vertex_mut(vertex(a)).1 = side;
                if a < k && b == (a + 1) % k {
                    self.link(side, hole.outer[a as usize]);
                } else if let Some(other) = open.iter().position(|&(from, to, _)| (from, to) == (b, a)) {
                    let (.., other) = open.swap_remove(other);
                    self.link(side, other);
                } else {
                    open.push((a, b, side));
                }
            }
        }
        debug_assert!(open.is_empty(), "{open:?} left of {filling:?} in a ring of {k}");
        for &slot in &hole.triangles[filling.len()..] {
            self.triangle_mut(slot).corners = [NONE; 3];
        }
    }

    /// Makes two sides twins of one another; the second may be [`NONE`].
    fn link(&mut self, side: u32, other: u32) {
        self.triangle_mut(side / 3).twins[side as usize % 3] = other;
        if other != NONE {
            self.triangle_mut(other / 3).twins[other as usize % 3] = side;
        }
    }

    /// Turns the edge between two triangles within their quadrilateral, which is to be strictly convex:
    ///
    /// ```text
    ///      r              r
    ///     / \            /|\
    ///    p───q    ->    p | q
    ///     \ /            \|/
    ///      s              s
    /// ```
    ///
    /// `side` is p→q; afterwards its triangle is p, s, r and the other one s, q, r.
    pub(super) fn flip(&mut self, side: u32) {
        let twin = self.twin(side);
        let (t, u) = (side / 3, twin / 3);
        let [p, q, r, s] = [side, twin, previous(side), previous(twin)].map(|e| self.origin(e));
        let [qr, rp, ps, sq] = [next(side), previous(side), next(twin), previous(twin)].map(|e| self.twin(e));
        self.triangle_mut(t).corners = [p, s, r];
        self.triangle_mut(u).corners = [s, q, r];
        for (side, other) in [(3 * t, ps), (3 * t + 2, rp), (3 * u, sq), (3 * u + 1, qr), (3 * t + 1, 3 * u + 2)] {
            self.link(side, other);
        }
        for (v, outgoing) in [(p, 3 * t), (s, 3 * u), (q, 3 * u + 1), (r, 3 * t + 2)] {
            *self.vertex_mut(v).1 = outgoing;
        }
    }

    /// Takes out a triangle that has no area any more, as one of its vertices is on its edge along the rim: the other two edges
    /// are on the rim then.
    pub(super) fn drop_rim_triangle(&mut self, t: u32) {
        let Triangle { corners, twins, .. } = self.triangles[t as usize];
        self.triangle_mut(t).corners = [NONE; 3];
        for twin in twins.into_iter().filter(|&twin| twin != NONE) {
            self.link(twin, NONE);
        }
        // Whichever half-edge was known to begin at a corner may have been one of these.
        for twin in twins.into_iter().filter(|&twin| twin != NONE) {
            for side in [twin, next(twin)] {
                let v = self.origin(side);
                if corners.contains(&v) {
                    *self.vertex_mut(v).1 = side;
                }
            }
        }
    }

    /// Forgets a vertex that no triangle has any more.
    pub(super) fn drop_vertex(&mut self, v: u32) {
        debug_assert!(!self.is_locked(v), "vertex {v} is the domain's");
        *self.vertex_mut(v).1 = NONE;
    }
}
