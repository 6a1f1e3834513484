//! Triangulating a hole: the triangulation of least weight over its ring, by dynamic programming (Klincsek 1980;
//! Barequet & Sharir 1995, who fill holes with it).
//!
//! Only triangles with positive orientation are used. That is enough: their areas' winding numbers add up to that of the
//! ring, which is 1 inside and 0 outside if the ring is simple, so they cover the inside once and nothing else.

use std::collections::VecDeque;

use crate::base::lattice::orient;
use crate::base::mesh::Vertex;

/// Says what triangles and chords weigh.
pub(super) trait Weigher {
    /// What becomes known of a triangle as it is weighed.
    type Known: Copy + Default;
    /// The weight of a triangle with positive orientation, not negative; infinite, or anything not below `budget`, where
    /// it cannot be used.
    fn triangle(&mut self, corners: [Vertex; 3], budget: f64) -> f64;
    /// What is known of the last triangle that could be used.
    fn known(&self) -> Self::Known;
    /// Whether two vertices of the ring may be joined across the hole.
    fn chord(&mut self, p: Vertex, q: Vertex) -> bool;
}

/// The table of the dynamic program: 12 bytes for every pair of vertices of the ring.
#[derive(Debug, Default)]
pub(super) struct Filler<K> {
    ring: Vec<Vertex>,
    /// Per pair i < j the least weight of the polygon i, i+1, …, j, and the corner of its triangle at the edge j–i.
    best: Vec<(f64, u32)>,
    /// What is known of these triangles.
    known: Vec<K>,
    stack: Vec<(u32, u32)>,
    /// The answer: positions on the ring.
    pub(super) triangles: Vec<[u32; 3]>,
    /// What is known of each, unless it was cut off as an ear.
    pub(super) found: Vec<K>,
}

impl<K: Copy + Default> Filler<K> {
    /// Finds the triangles of least weight. Returns their weight, or `None` if no triangulation is below `limit`.
    pub(super) fn fill(
        &mut self,
        ring: impl Iterator<Item = Vertex>,
        limit: f64,
        weigher: &mut impl Weigher<Known = K>,
    ) -> Option<f64> {
        self.ring.clear();
        self.ring.extend(ring);
        let k = self.ring.len();
        self.best.clear();
        self.best.resize(k * k, (f64::INFINITY, 0));
        self.known.clear();
        self.known.resize(k * k, K::default());
        for i in 0..k - 1 {
            self.best[i * k + i + 1].0 = 0.0;
        }
        for gap in 2..k {
            for i in 0..k - gap {
                (self.best[i * k + i + gap], self.known[i * k + i + gap]) = self.cell(i, i + gap, limit, weigher);
            }
        }
        let weight = self.best[k - 1].0;
        if weight.is_finite() {
            self.trace(k);
            return Some(weight);
        }
        None
    }

    fn cell(&self, i: usize, j: usize, limit: f64, weigher: &mut impl Weigher<Known = K>) -> ((f64, u32), K) {
        let (k, ring) = (self.ring.len(), &self.ring);
        let (mut best, mut known) = ((f64::INFINITY, 0), K::default());
        let mut allowed = j - i == k - 1;
        for m in i + 1..j {
            let parts = self.best[i * k + m].0 + self.best[m * k + j].0;
            let budget = f64::min(best.0, limit) - parts;
            if budget.is_nan() || budget <= 0.0 || orient(ring[i].at, ring[m].at, ring[j].at) <= 0 {
                continue;
            }
            let weight = weigher.triangle([ring[i], ring[m], ring[j]], budget);
            if weight < budget {
                // Asked only if something hangs on it: few chords may not be, many triangles.
                allowed = allowed || weigher.chord(ring[i], ring[j]);
                if !allowed {
                    return (best, known);
                }
                (best, known) = ((parts + weight, m as u32), weigher.known());
            }
        }
        (best, known)
    }

    /// Finds some triangulation by cutting off ears, or none: for rings too long for [`Filler::fill`]. A simple
    /// ring always has an ear (Meisters 1975), so only triangles that may not be used stand against it.
    pub(super) fn clip(&mut self, ring: impl Iterator<Item = Vertex>, weigher: &mut impl Weigher<Known = K>) -> bool {
        self.ring.clear();
        self.ring.extend(ring);
        self.triangles.clear();
        // What is left of the ring, from the corner on that is looked at.
        let mut left: VecDeque<u32> = (0..self.ring.len() as u32).collect();
        let mut in_vain = 0;
        while left.len() > 3 && in_vain < left.len() {
            if self.is_ear(&left, weigher) {
                self.triangles.push([left[0], left[1], left[2]]);
                left.remove(1);
                in_vain = 0;
            } else {
                in_vain += 1;
            }
            left.rotate_left(1);
        }
        let [a, b, c] = [0, 1, 2].map(|i| self.ring[left[i] as usize]);
        if left.len() > 3 || orient(a.at, b.at, c.at) <= 0 || !weigher.triangle([a, b, c], f64::INFINITY).is_finite() {
            return false;
        }
        self.triangles.push([left[0], left[1], left[2]]);
        true
    }

    /// Whether the second corner can be cut off: no other one lies in its triangle, and the triangle may be used.
    fn is_ear(&self, left: &VecDeque<u32>, weigher: &mut impl Weigher<Known = K>) -> bool {
        let at = |i: usize| self.ring[left[i] as usize];
        let [a, b, c] = [0, 1, 2].map(at);
        let outside = |p: Vertex| [(a, b), (b, c), (c, a)].iter().any(|&(p1, p2)| orient(p1.at, p2.at, p.at) < 0);
        orient(a.at, b.at, c.at) > 0
            && (3..left.len()).all(|i| outside(at(i)))
            && weigher.chord(a, c)
            && weigher.triangle([a, b, c], f64::INFINITY).is_finite()
    }

    fn trace(&mut self, k: usize) {
        self.triangles.clear();
        self.found.clear();
        self.stack.clear();
        self.stack.push((0, k as u32 - 1));
        while let Some((i, j)) = self.stack.pop() {
            if j - i >= 2 {
                let m = self.best[i as usize * k + j as usize].1;
                self.triangles.push([i, m, j]);
                self.found.push(self.known[i as usize * k + j as usize]);
                self.stack.extend([(i, m), (m, j)]);
            }
        }
    }
}
