//! The order of cuts of the paper (Silva, Mitchell & Kaufman 1995, section 2).

use std::collections::VecDeque;

use super::front::{Apex, Fresh, Front};
use super::places::{Base, feasible_apex};
use super::thin::Splits;
use super::{Edge, Strategy};
use crate::base::lattice::{Point, STEPS, distance2, orient};
use crate::kernel::triangulate::feasible::Tester;

/// The paper's own order (section 2): ears first, in the order in which corners appear; then bites, likewise, to a
/// point on the perpendicular through the edge's middle; then edge splits, longest edge first.
///
/// Every corner is tried once as an ear, every edge once as the base of a bite and once as one to split: what is
/// infeasible stays so, and so does what is hidden, since the ground only shrinks.
#[derive(Debug, Default)]
pub(super) struct PaperOrder {
    fresh: Fresh,
    ears: VecDeque<[u32; 3]>,
    bites: VecDeque<Edge>,
    splits: Splits,
}

impl Strategy for PaperOrder {
    fn clear(&mut self) {
        self.ears.clear();
        self.bites.clear();
        self.splits.clear();
    }

    fn cut(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        self.look_at_fresh(front);
        self.cut_ear(front, tester) || self.bite(front, tester) || self.splits.cut(front, tester)
    }

    fn take_hopeless(&mut self, into: &mut Vec<Edge>) {
        self.splits.take_hopeless(into);
    }
}

impl PaperOrder {
    fn look_at_fresh(&mut self, front: &mut Front) {
        front.take_fresh(&mut self.fresh);
        for &i in &self.fresh.corners {
            let (p, q) = (front.prev(i), front.next(i));
            if front.has_edge((p, i)) && orient(front.at(p), front.at(i), front.at(q)) > 0 {
                self.ears.push_back([p, i, q]);
            }
        }
        self.bites.extend(&self.fresh.edges);
    }

    fn cut_ear(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some([p, i, q]) = self.ears.pop_front() {
            if !front.has_edge((p, i)) || !front.has_edge((i, q)) {
                continue;
            }
            let corners = [p, i, q].map(|n| front.vertex(n));
            let closing = [(corners[0], corners[2])];
            let new_edges = if front.has_edge((q, p)) { &[] } else { &closing[..] };
            // Most corners fail here, and a feasible triangle is found out sooner than a hidden one.
            if tester.feasible(corners, new_edges) && front.ear_is_visible(p, i, q) {
                front.cut_ear(p, i, q);
                return true;
            }
        }
        false
    }

    /// Greedy biting: a bite to a new vertex is followed by one from the edge nearest to it, which splits the polygon.
    fn bite(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some(edge) = self.bites.pop_front() {
            if !front.has_edge(edge) {
                continue;
            }
            let Some(apex) = search_perpendicular(front, tester, edge) else {
                self.splits.push(front, edge);
                continue;
            };
            let length = distance2(front.at(edge.0), front.at(edge.1));
            let node = front.bite(edge, apex);
            if matches!(apex, Apex::New(_)) {
                split_polygon(front, tester, node, length);
            }
            return true;
        }
        false
    }
}

/// The paper's search for a bite: on the perpendicular through the edge's middle, at the edge's own length, then at
/// half the distance, and so on.
fn search_perpendicular(front: &Front, tester: &Tester<'_>, edge: Edge) -> Option<Apex> {
    let base = Base::of(front.at(edge.0), front.at(edge.1));
    let mut away = base.length;
    while away >= 0.5 {
        let apex = base.sample(tester, 0.0, away).and_then(|v| feasible_apex(front, tester, edge, v));
        if apex.is_some() {
            return apex;
        }
        away /= 2.0;
    }
    None
}

/// The paper's split: from the edge of the front nearest to a new vertex, a second bite to it, if it is feasible.
/// Edges farther away than about twice the first bite's base (`length2`, its square in steps) are not looked for.
fn split_polygon(front: &mut Front, tester: &Tester<'_>, node: u32, length2: i64) {
    let reach = 2.0 * (length2 as f64).sqrt() + f64::from(2 * STEPS);
    let place = front.at(node);
    let mut nearest: Option<(f64, Edge)> = None;
    let mut bound = reach * reach;
    for a in front.grid.near(place, reach as i32) {
        let b = front.next(a);
        let (from, to) = (front.at(a), front.at(b));
        let too_far = distance2_to_box(place, from, to) as f64 > bound;
        if too_far || a == node || b == node || orient(from, to, place) <= 0 {
            continue;
        }
        let distance = distance2_to_segment(place, from, to);
        let candidate = (distance, (a, b));
        if distance < reach * reach && nearest.is_none_or(|n| candidate < n) {
            nearest = Some(candidate);
            // The distance to the segment is rounded, the one to its box is not.
            bound = distance * (1.0 + 1e-9);
        }
    }
    let Some((_, edge)) = nearest else { return };
    if let Some(apex @ Apex::Node(_)) = feasible_apex(front, tester, edge, front.vertex(node)) {
        front.bite(edge, apex);
    }
}

/// Square of the distance from a place to the box around a segment, in steps: the segment is no nearer.
fn distance2_to_box(p: Point, a: Point, b: Point) -> i64 {
    let outside = |v: i32, m: i32, n: i32| i64::from((m.min(n) - v).max(v - m.max(n)).max(0));
    let (x, y) = (outside(p.x, a.x, b.x), outside(p.y, a.y, b.y));
    x * x + y * y
}

/// Square of the distance from a place to a segment, in steps.
fn distance2_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (f64::from(b.x - a.x), f64::from(b.y - a.y));
    let (px, py) = (f64::from(p.x - a.x), f64::from(p.y - a.y));
    let share = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    let (ex, ey) = (share * dx - px, share * dy - py);
    ex * ex + ey * ey
}
