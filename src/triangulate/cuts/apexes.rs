use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Edge;
use super::frame::Frame;
use super::front::{Apex, Front};
use super::obstacles::Obstacles;
use super::ray::{RAYS, STEPS_OF_RAY, Step, Steps, step_from};
use super::sweep::{Sweep, apex, tilt};
use crate::lattice::{Point, orient};
use crate::mesh::Vertex;
use crate::triangulate::feasible::Tester;

/// The steps of an edge's rays that may still be apexes of feasible bites.
pub(super) type Prospects = [Steps; RAYS.len()];

/// Chooses the best bite from an edge, among places on its rays and vertices of the front.
///
/// The score of a bite is twice its area and that of the ears it opens at the edge's ends (feasible ones, whether or not
/// something hides them), in full if it ends at the front, and half of it if it makes a new vertex; less where its new
/// edges leave the ground ([`straight`]). Candidates are looked at in the order of the best score they can have, and the
/// exact tests are made for those alone that can still win.
#[derive(Debug, Default)]
pub(super) struct Apexes {
    obstacles: Obstacles,
    sweeps: [Sweep; RAYS.len()],
    candidates: BinaryHeap<Candidate>,
}

/// An apex, in the order of the best score it can have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    bound: i64,
    place: Reverse<Point>,
    /// Bit for bit.
    height: u64,
    /// The ray and the step that it comes from; none for a node of the front.
    from: Option<(usize, Step)>,
}

impl Candidate {
    fn vertex(&self) -> Vertex {
        Vertex { at: self.place.0, height: f64::from_bits(self.height) }
    }
}

/// How much the score counts of a bite that ends at the front, and of one that makes a new vertex.
const NODE_WEIGHT: i64 = 2;
const NEW_WEIGHT: i64 = 1;

/// How near the edge's middle vertices of the front are taken for apexes, in edge lengths.
const NODE_REACH: f64 = 1.5;

/// How near the edge's line apexes are looked for, in cells.
const NEAREST: f64 = 0.75;

impl Apexes {
    /// The best bite from an edge that has not been swept, and what the sweep leaves to be tried later.
    pub(super) fn sweep(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
    ) -> (Option<(i64, Vertex)>, Prospects) {
        let frame = Frame::new(front.vertex(edge.0), front.vertex(edge.1));
        self.look_around(front, edge, &frame);
        let first = step_from(NEAREST / frame.length());
        let mut prospects = [0; RAYS.len()];
        let last = RAYS.each_ref().map(|ray| step_from(self.obstacles.limit(ray)));
        pulp::Arch::new().dispatch(|| {
            for (i, ray) in RAYS.iter().enumerate() {
                prospects[i] =
                    self.sweeps[i].run(tester.tile(), tester.tolerance(), &frame, ray, first..last[i].max(first));
            }
        });
        self.candidates.clear();
        for (node, (along, away)) in self.obstacles.nodes() {
            let vertex = front.vertex(node);
            let tilt = tilt(&frame, vertex);
            let allowed = || self.sweeps.iter().zip(&RAYS).all(|(s, ray)| s.allows(ray, (along, away), tilt));
            if is_near(along, away) && allowed() {
                self.candidates.push(candidate(front, edge, vertex, None));
            }
        }
        (self.best(front, tester, edge, &frame, &mut prospects), prospects)
    }

    /// The best bite from an edge that has been swept, of what is left of its prospects.
    pub(super) fn next_best(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
        prospects: &mut Prospects,
    ) -> Option<(i64, Vertex)> {
        let frame = Frame::new(front.vertex(edge.0), front.vertex(edge.1));
        self.look_around(front, edge, &frame);
        for (ray, steps) in RAYS.iter().zip(&mut *prospects) {
            *steps &= steps_below(step_from(self.obstacles.limit(ray)));
        }
        self.candidates.clear();
        for (node, (along, away)) in self.obstacles.nodes() {
            if is_near(along, away) {
                self.candidates.push(candidate(front, edge, front.vertex(node), None));
            }
        }
        self.best(front, tester, edge, &frame, prospects)
    }

    fn look_around(&mut self, front: &Front, edge: Edge, frame: &Frame) {
        let reach = RAYS.iter().map(|r| r.farthest).fold(NODE_REACH, f64::max);
        self.obstacles.look_around(front, edge, frame, reach);
    }

    /// The best of the candidates and the farthest prospects of each ray. A prospect that fails gives way to the next on
    /// its ray, for good.
    fn best(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
        frame: &Frame,
        prospects: &mut Prospects,
    ) -> Option<(i64, Vertex)> {
        for ray in 0..RAYS.len() {
            self.push_farthest(front, tester, edge, frame, ray, prospects);
        }
        let mut best: Option<(i64, Vertex)> = None;
        let mut last = None;
        while let Some(candidate) = self.candidates.pop() {
            if best.is_some_and(|(score, _)| score >= candidate.bound) {
                break;
            }
            // The same node, found twice, comes out twice running.
            if last.replace(candidate) == Some(candidate) {
                continue;
            }
            let score = score(front, tester, edge, candidate.vertex(), candidate.from.is_none());
            if let (None, Some((ray, step))) = (score, candidate.from) {
                prospects[ray] &= !(1 << step);
                self.push_farthest(front, tester, edge, frame, ray, prospects);
            }
            if let Some(score) = score.filter(|&s| best.is_none_or(|(best, _)| s > best)) {
                best = Some((score, candidate.vertex()));
            }
        }
        best
    }

    fn push_farthest(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
        frame: &Frame,
        ray: usize,
        prospects: &Prospects,
    ) {
        let Some(step) = prospects[ray].checked_ilog2() else { return };
        let vertex = apex(tester.tile(), frame, &RAYS[ray], step).expect("a step that the sweep found an apex for");
        self.candidates.push(candidate(front, edge, vertex, Some((ray, step))));
    }
}

fn is_near(along: f64, away: f64) -> bool {
    (along - 0.5) * (along - 0.5) + away * away < NODE_REACH * NODE_REACH
}

/// The steps before one.
fn steps_below(step: Step) -> Steps {
    if step < STEPS_OF_RAY { (1 << step) - 1 } else { Steps::MAX }
}

fn candidate(front: &Front, edge: Edge, v: Vertex, from: Option<(usize, Step)>) -> Candidate {
    let [before, a, b, after] = around(front, edge).map(|v| v.at);
    let area = orient(a, b, v.at) + orient(before, a, v.at).max(0) + orient(b, after, v.at).max(0);
    // A place on a ray may be a vertex of the front, too.
    Candidate { bound: NODE_WEIGHT * area, place: Reverse(v.at), height: v.height.to_bits(), from }
}

/// The edge's ends, and the vertices before and after.
fn around(front: &Front, (a, b): Edge) -> [Vertex; 4] {
    [front.prev(a), a, b, front.next(b)].map(|n| front.vertex(n))
}

/// The score of a bite; `None` if it is hidden or not feasible.
fn score(front: &Front, tester: &Tester<'_>, edge: Edge, v: Vertex, is_node: bool) -> Option<i64> {
    let [before, a, b, after] = around(front, edge);
    let feasible = || tester.feasible([a, b, v], &[(a, v), (b, v)]);
    let weight = match front.visible_apex(edge, v).filter(|_| feasible())? {
        Apex::Node(_) => NODE_WEIGHT,
        Apex::New(_) => NEW_WEIGHT,
    };
    debug_assert!(weight == NODE_WEIGHT || !is_node, "no node of the front at {v:?}");
    let ear = |p: Vertex, i: Vertex, q: Vertex, new_edge: (Vertex, Vertex)| {
        let area = orient(p.at, i.at, q.at);
        if area > 0 && tester.feasible([p, i, q], &[new_edge]) { area } else { 0 }
    };
    let area = orient(a.at, b.at, v.at) + ear(before, a, v, (before, v)) + ear(b, after, v, (v, after));
    Some(((weight * area) as f64 * straight(tester, [(a, v), (b, v)])) as i64)
}

/// A share of the score that is left to edges which stray from the ground between samples: 1 up to half the tolerance,
/// then falling to ⅕. The neighbours of an edge that leaves the ground pay for it, with a small triangle each.
fn straight(tester: &Tester<'_>, edges: [(Vertex, Vertex); 2]) -> f64 {
    let tolerance = tester.tolerance();
    let farthest = edges.iter().map(|&(p, q)| tester.edge_deviation(p, q)).fold(0.0, f64::max);
    match farthest {
        d if d <= 0.5 * tolerance => 1.0,
        d if d >= 4.5 * tolerance => 0.2,
        d => tolerance / (d + 0.5 * tolerance),
    }
}
