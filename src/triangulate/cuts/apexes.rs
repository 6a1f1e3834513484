use std::collections::BinaryHeap;

use super::Edge;
use super::frame::Frame;
use super::front::{Apex, Front};
use super::sweep::{CANDIDATES, Candidates, Ray, candidate_at, sweep};
use crate::lattice::{Point, STEPS, orient};
use crate::mesh::Vertex;
use crate::triangulate::feasible::Tester;

/// How far the rays lean.
const LEANS: [f64; RAYS] = [0.0, 0.42, -0.42, 1.03, -1.03];
/// The farthest candidates.
const FARTHEST: [f64; RAYS] = [2.0, 1.84, 1.84, 1.39, 1.39];
const RAYS: usize = 5;

/// The candidates left on each of an edge's rays.
pub(super) type Rays = [Candidates; RAYS];

/// Finds the best bite from an edge.
#[derive(Debug, Default)]
pub(super) struct Apexes {
    obstacles: Vec<Obstacle>,
    nodes: Vec<u32>,
    heap: BinaryHeap<Candidate>,
}

/// An edge of the front, in the frame of the edge that is bitten from.
#[derive(Debug, Clone, Copy)]
struct Obstacle {
    from: (f64, f64),
    to: (f64, f64),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    bound: i64,
    at: Point,
    source: Source,
    height: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Source {
    Node,
    Ray(u32, u32),
}

const NEW_WEIGHT: i64 = 7;
const NODE_WEIGHT: i64 = 10;

impl Apexes {
    pub(super) fn best(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
        known: &mut Option<Rays>,
    ) -> Option<(i64, Vertex)> {
        let frame = Frame::new(front.vertex(edge.0), front.vertex(edge.1));
        self.look_around(front, edge, &frame);
        let first = candidate_at((0.75 * f64::from(STEPS)) / frame.length2.sqrt());
        let rays = self.candidates(tester, &frame, first, known);
        self.heap.clear();
        for i in 0..RAYS {
            self.push_ray(front, tester, edge, &frame, rays, i, None);
        }
        self.nodes.sort_unstable();
        self.nodes.dedup();
        let (a, b) = (frame.a.at, frame.b.at);
        for &node in &self.nodes {
            let v = front.vertex(node);
            let (along, away) = frame.coordinates(v.at);
            if away > 0.0 && (along - 0.5) * (along - 0.5) + away * away < 1.5 * 1.5 && v.at != a && v.at != b {
                let bound = NODE_WEIGHT * bound(front, edge, v.at);
                self.heap.push(Candidate { bound, at: v.at, source: Source::Node, height: v.height.to_bits() });
            }
        }
        let mut best: Option<(i64, Candidate)> = None;
        while let Some(candidate) = self.heap.pop() {
            if best.is_some_and(|(score, _)| score >= candidate.bound) {
                break;
            }
            let v = Vertex { at: candidate.at, height: f64::from_bits(candidate.height) };
            let edges = [(frame.a, v), (frame.b, v)];
            let apex = front.visible_apex(edge, v).filter(|_| tester.feasible([frame.a, frame.b, v], &edges));
            let weight = match (apex, candidate.source) {
                (None | Some(Apex::New(_)), Source::Node) => continue,
                (None, Source::Ray(i, k)) => {
                    rays[i as usize] &= !(1 << k);
                    self.push_ray(front, tester, edge, &frame, rays, i as usize, Some(v.at));
                    continue;
                }
                (Some(Apex::New(_)), _) => NEW_WEIGHT,
                (Some(Apex::Node(_)), _) => NODE_WEIGHT,
            };
            let score = weight * (orient(a, b, v.at) + ears(front, tester, edge, v));
            if best.is_none_or(|(s, _)| score > s) {
                best = Some((score, candidate));
            }
        }
        best.map(|(score, c)| (score, Vertex { at: c.at, height: f64::from_bits(c.height) }))
    }

    fn push_ray(
        &mut self,
        front: &Front,
        tester: &Tester<'_>,
        edge: Edge,
        frame: &Frame,
        rays: &mut Rays,
        i: usize,
        failed: Option<Point>,
    ) {
        while rays[i] != 0 {
            let k = CANDIDATES - 1 - rays[i].leading_zeros();
            let ray = Ray { lean: LEANS[i], last: k };
            let apex = ray.apex(frame, tester, k).filter(|v| Some(v.at) != failed);
            if let Some(v) = apex.filter(|v| orient(frame.a.at, frame.b.at, v.at) > 0) {
                let bound = NODE_WEIGHT * bound(front, edge, v.at);
                let source = Source::Ray(i as u32, k);
                self.heap.push(Candidate { bound, at: v.at, source, height: v.height.to_bits() });
                return;
            }
            rays[i] &= !(1 << k);
        }
    }

    fn look_around(&mut self, front: &Front, (a, b): Edge, frame: &Frame) {
        let (from, to) = (frame.a.at, frame.b.at);
        let middle = Point { x: (from.x + to.x) / 2, y: (from.y + to.y) / 2 };
        let reach = 2.0 * frame.length2.sqrt();
        self.obstacles.clear();
        self.nodes.clear();
        for e in front.grid.near(middle, reach as i32) {
            if e == a {
                continue;
            }
            let (p, q) = (front.at(e), front.at(front.next(e)));
            let (from, to) = (frame.coordinates(p), frame.coordinates(q));
            if from.1 <= 0.0 && to.1 <= 0.0 {
                continue;
            }
            self.obstacles.push(Obstacle { from, to });
            if e != b {
                self.nodes.push(e);
            }
        }
    }

    fn candidates<'r>(
        &self,
        tester: &Tester<'_>,
        frame: &Frame,
        first: u32,
        known: &'r mut Option<Rays>,
    ) -> &'r mut Rays {
        let mut rays = [0; RAYS];
        for (i, (&lean, &farthest)) in LEANS.iter().zip(&FARTHEST).enumerate() {
            let limit = self.limit(lean, farthest);
            let Some(last) = candidate_at(limit).checked_sub(1) else { continue };
            rays[i] = match known {
                Some(rays) => rays[i] & (u32::MAX >> (CANDIDATES - 1 - last)),
                None => sweep(tester, frame, &Ray { lean, last }, first),
            };
        }
        known.insert(rays)
    }

    /// How far the triangle grows along a ray until the front is in the way.
    fn limit(&self, lean: f64, farthest: f64) -> f64 {
        let ray = Ray { lean, last: 0 };
        let mut limit = farthest;
        for o in &self.obstacles {
            let aside = |p: (f64, f64)| p.0 - lean * p.1 - 0.5;
            let arrival = ray.arrival(o.from.0, o.from.1);
            if o.from.1 > 0.0 && arrival > 0.0 && arrival < limit {
                limit = arrival;
            }
            let (s, t) = (aside(o.from), aside(o.to));
            if s * t < 0.0 {
                let away = o.from.1 + (o.to.1 - o.from.1) * (s / (s - t));
                if away > 0.0 && away < limit {
                    limit = away;
                }
            }
        }
        limit
    }
}

/// Twice the area of a bite and of the ears that it may open.
fn bound(front: &Front, (a, b): Edge, v: Point) -> i64 {
    let (ap, bp) = (front.at(a), front.at(b));
    let (before, after) = (front.at(front.prev(a)), front.at(front.next(b)));
    orient(ap, bp, v) + orient(before, ap, v).max(0) + orient(bp, after, v).max(0)
}

/// Twice the area of the feasible ears that a bite opens at both of its ends.
fn ears(front: &Front, tester: &Tester<'_>, (a, b): Edge, v: Vertex) -> i64 {
    let ear = |p: Vertex, i: Vertex, q: Vertex, closing: (Vertex, Vertex)| {
        let area = orient(p.at, i.at, q.at);
        if area > 0 && tester.feasible([p, i, q], &[closing]) { area } else { 0 }
    };
    let (before, after) = (front.vertex(front.prev(a)), front.vertex(front.next(b)));
    ear(before, front.vertex(a), v, (before, v)) + ear(front.vertex(b), after, v, (v, after))
}
