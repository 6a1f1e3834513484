//! What a bite is worth.

use super::Edge;
use super::frame::Frame;
use super::front::Front;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::Tester;

/// An edge that is to be bitten from, and what is known of its surroundings: everything a bite is judged by.
///
/// The score of a bite is twice its area and that of the ears it opens at the edge's ends (feasible ones, whether or not
/// something hides them); in full if it ends at the front, half of it if it makes a new vertex; and less if its new
/// edges leave the ground ([`Setting::straight`]).
#[derive(Clone, Copy)]
pub(super) struct Setting<'a> {
    pub(super) front: &'a Front,
    pub(super) tester: &'a Tester<'a>,
    pub(super) edge: Edge,
    pub(super) frame: Frame,
    /// The vertices before and after the edge.
    before: Vertex,
    after: Vertex,
}

/// What a bite ends at, by how much its area counts: one that ends at the front leaves less behind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Ending {
    NewVertex = 1,
    Node = 2,
}

impl<'a> Setting<'a> {
    pub(super) fn new(front: &'a Front, tester: &'a Tester<'a>, edge: Edge) -> Setting<'a> {
        let [before, a, b, after] = [front.prev(edge.0), edge.0, edge.1, front.next(edge.1)].map(|n| front.vertex(n));
        Setting { front, tester, edge, frame: Frame::new(a, b), before, after }
    }

    /// No bite to this place has a higher score.
    pub(super) fn bound(&self, v: Point, ending: Ending) -> i64 {
        let (a, b) = (self.frame.a.at, self.frame.b.at);
        let ears = orient(self.before.at, a, v).max(0) + orient(b, self.after.at, v).max(0);
        ending as i64 * (orient(a, b, v) + ears)
    }

    /// Whether the bite is inside the ground.
    pub(super) fn is_visible(&self, v: Vertex) -> bool {
        self.front.visible_apex(self.edge, v).is_some()
    }

    /// Whether the bite may be used.
    pub(super) fn is_feasible(&self, v: Vertex) -> bool {
        let Frame { a, b, .. } = self.frame;
        self.tester.feasible([a, b, v], &[(a, v), (b, v)])
    }

    /// The score of a feasible bite; perhaps less than that, but not more than `least`, if it is not more than `least`.
    pub(super) fn score(&self, v: Vertex, ending: Ending, least: i64) -> i64 {
        let Frame { a, b, .. } = self.frame;
        let ears = self.ear([self.before, a, v], (self.before, v)) + self.ear([b, self.after, v], (v, self.after));
        let score = ending as i64 * (orient(a.at, b.at, v.at) + ears);
        if score <= least { score } else { (score as f64 * self.straight(v)) as i64 }
    }

    /// Twice the area of an ear that a bite opens; 0 if it opens none.
    fn ear(&self, corners: [Vertex; 3], new_edge: (Vertex, Vertex)) -> i64 {
        let area = orient(corners[0].at, corners[1].at, corners[2].at);
        if area > 0 && self.tester.feasible(corners, &[new_edge]) { area } else { 0 }
    }

    /// The share of the score that is left to a bite whose edges stray from the ground between samples: 1 up to half the
    /// tolerance, then falling to ⅕. The neighbours of an edge that leaves the ground pay for it with small triangles.
    fn straight(&self, v: Vertex) -> f64 {
        let tolerance = self.tester.tolerance();
        let Frame { a, b, .. } = self.frame;
        match self.tester.edge_deviation(a, v).max(self.tester.edge_deviation(b, v)) {
            d if d <= 0.5 * tolerance => 1.0,
            d if d >= 4.5 * tolerance => 0.2,
            d => tolerance / (d + 0.5 * tolerance),
        }
    }
}
