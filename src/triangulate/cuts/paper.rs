use std::collections::{BinaryHeap, VecDeque};

use super::front::{Apex, Fresh, Front};
use super::{Edge, Strategy};
use crate::lattice::{Point, STEPS, distance2, orient};
use crate::mesh::Vertex;
use crate::triangulate::feasible::Tester;

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
    splits: BinaryHeap<(i64, Edge)>,
    hopeless: Vec<Edge>,
}

impl Strategy for PaperOrder {
    fn clear(&mut self) {
        self.ears.clear();
        self.bites.clear();
        self.splits.clear();
        self.hopeless.clear();
    }

    fn cut(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        self.look_at_fresh(front);
        self.cut_ear(front, tester) || self.bite(front, tester) || self.split_edge(front, tester)
    }

    fn take_hopeless(&mut self, into: &mut Vec<Edge>) {
        into.append(&mut self.hopeless);
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
            if !front.has_edge((p, i)) || !front.has_edge((i, q)) || !front.ear_is_visible(p, i, q) {
                continue;
            }
            let corners = [p, i, q].map(|n| front.vertex(n));
            let closing = [(corners[0], corners[2])];
            let new_edges = if front.has_edge((q, p)) { &[] } else { &closing[..] };
            if tester.feasible(corners, new_edges) {
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
                self.splits.push((distance2(front.at(edge.0), front.at(edge.1)), edge));
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

    fn split_edge(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some((_, edge)) = self.splits.pop() {
            if !front.has_edge(edge) {
                continue;
            }
            if let Some(apex) = search_along(front, tester, edge) {
                front.bite(edge, apex);
                return true;
            }
            self.hopeless.push(edge);
        }
        false
    }
}

/// Whether the triangle from an edge to a place is inside the ground and feasible, and what it meets there.
pub(super) fn feasible_apex(front: &Front, tester: &Tester<'_>, edge: Edge, vertex: Vertex) -> Option<Apex> {
    let apex = front.visible_apex(edge, vertex)?;
    let (a, b) = (front.vertex(edge.0), front.vertex(edge.1));
    tester.feasible([a, b, vertex], &[(a, vertex), (b, vertex)]).then_some(apex)
}

/// An edge as seen from its left side, in cells.
struct Base {
    middle: (f64, f64),
    along: (f64, f64),
    normal: (f64, f64),
    length: f64,
}

impl Base {
    fn of(a: Point, b: Point) -> Base {
        let cells = |steps: i32| f64::from(steps) / f64::from(STEPS);
        let (dx, dy) = (cells(b.x - a.x), cells(b.y - a.y));
        let length = (dx * dx + dy * dy).sqrt();
        let along = (dx / length, dy / length);
        let middle = (cells(a.x + b.x) / 2.0, cells(a.y + b.y) / 2.0);
        Base { middle, along, normal: (-along.1, along.0), length }
    }

    /// The sample nearest to a place, given by its distance from the middle along the edge and away from it.
    fn sample(&self, tester: &Tester<'_>, along: f64, away: f64) -> Option<Vertex> {
        let column = (self.middle.0 + self.along.0 * along + self.normal.0 * away).round();
        let row = (self.middle.1 + self.along.1 * along + self.normal.1 * away).round();
        let tile = tester.tile();
        let inside = column >= 0.0 && row >= 0.0 && column < tile.width() as f64 && row < tile.height() as f64;
        inside.then(|| Vertex {
            at: Point::of_sample(column as i32, row as i32),
            height: tile.at(column as usize, row as usize),
        })
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

/// The paper's edge split as a real, thin bite: near the edge's middle, then near its other eighths.
fn search_along(front: &Front, tester: &Tester<'_>, edge: Edge) -> Option<Apex> {
    let base = Base::of(front.at(edge.0), front.at(edge.1));
    for share in [0.0, -0.125, 0.125, -0.25, 0.25] {
        for away in [0.75, 1.25, 2.0, 0.4] {
            let vertex = base.sample(tester, share * base.length, away);
            let apex = vertex.and_then(|v| feasible_apex(front, tester, edge, v));
            if apex.is_some() {
                return apex;
            }
        }
    }
    None
}

/// The paper's split: from the edge of the front nearest to a new vertex, a second bite to it, if it is feasible.
/// Edges farther away than about twice the first bite's base (`length2`, its square in steps) are not looked for.
fn split_polygon(front: &mut Front, tester: &Tester<'_>, node: u32, length2: i64) {
    let reach = 2.0 * (length2 as f64).sqrt() + f64::from(2 * STEPS);
    let place = front.at(node);
    let mut nearest: Option<(f64, Edge)> = None;
    for a in front.grid.near(place, reach as i32) {
        let b = front.next(a);
        if a == node || b == node || orient(front.at(a), front.at(b), place) <= 0 {
            continue;
        }
        let distance = distance2_to_segment(place, front.at(a), front.at(b));
        let candidate = (distance, (a, b));
        if distance < reach * reach && nearest.is_none_or(|n| candidate < n) {
            nearest = Some(candidate);
        }
    }
    let Some((_, edge)) = nearest else { return };
    if let Some(apex @ Apex::Node(_)) = feasible_apex(front, tester, edge, front.vertex(node)) {
        front.bite(edge, apex);
    }
}

/// Square of the distance from a place to a segment, in steps.
fn distance2_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (f64::from(b.x - a.x), f64::from(b.y - a.y));
    let (px, py) = (f64::from(p.x - a.x), f64::from(p.y - a.y));
    let share = ((px * dx + py * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
    let (ex, ey) = (share * dx - px, share * dy - py);
    ex * ex + ey * ey
}
