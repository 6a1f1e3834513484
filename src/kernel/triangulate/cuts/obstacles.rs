//! Vertices of the front that bites may grow to or run into.

use super::Edge;
use super::frame::Frame;
use super::front::Front;
use super::ray::Ray;
use crate::base::lattice::{Point, STEPS};

/// The front near an edge, in the edge's own frame.
#[derive(Debug, Default)]
pub(super) struct Obstacles {
    edges: Vec<Obstacle>,
}

/// An edge of the front: its first node, and along and away of both ends.
#[derive(Debug, Clone, Copy)]
struct Obstacle {
    node: u32,
    from: (f64, f64),
    to: (f64, f64),
}

impl Obstacles {
    /// Looks for what is in front of an edge and not farther than `reach` edge lengths from its middle, as a box. What
    /// is found may be found more than once.
    pub(super) fn look_around(&mut self, front: &Front, (a, b): Edge, frame: &Frame, reach: f64) {
        let (pa, pb) = (frame.a.at, frame.b.at);
        let middle = Point { x: (pa.x + pb.x) / 2, y: (pa.y + pb.y) / 2 };
        let reach = (reach * frame.length() * f64::from(STEPS)) as i32 + 1;
        self.edges.clear();
        for node in front.grid.near(middle, reach) {
            let (p, q) = (front.at(node), front.at(front.next(node)));
            let outside = |p: i32, q: i32, m: i32| p.max(q) < m - reach || p.min(q) > m + reach;
            if node == a || outside(p.x, q.x, middle.x) || outside(p.y, q.y, middle.y) {
                continue;
            }
            let (from, to) = (frame.coordinates(p), frame.coordinates(q));
            if from.1 > 0.0 || to.1 > 0.0 {
                self.edges.push(Obstacle { node, from, to });
            }
        }
        debug_assert!(front.has_edge((a, b)), "edge {a} {b}");
    }

    /// Nodes in front of the edge, with along and away.
    pub(super) fn nodes(&self) -> impl Iterator<Item = (u32, (f64, f64))> {
        self.edges.iter().filter(|o| o.from.1 > 0.0).map(|o| (o.node, o.from))
    }

    /// How far the triangle over the edge can grow along a ray before the front is in its way: before it reaches a
    /// node, or before its apex meets an edge. Rounded.
    pub(super) fn limit(&self, ray: &Ray) -> f64 {
        let mut limit = ray.farthest;
        for o in &self.edges {
            let (from, to) = (ray.aside(o.from.0, o.from.1), ray.aside(o.to.0, o.to.1));
            // The node's arrival is below the limit; by its definition, without a division.
            if o.from.1 > 0.0 && o.from.1 < limit * (1.0 - from.abs()) {
                limit = ray.arrival(o.from.0, o.from.1);
            }
            if from * to < 0.0 {
                let away = o.from.1 + (o.to.1 - o.from.1) * (from / (from - to));
                if away > 0.0 && away < limit {
                    limit = away;
                }
            }
        }
        limit
    }
}
