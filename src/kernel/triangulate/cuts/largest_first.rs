//! The improved order: the largest ear first, then the best bite.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::apexes::{Apexes, Prospects};
use super::front::{Fresh, Front};
use super::thin::Splits;
use super::{Edge, Strategy};
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::Tester;

/// The improved order: the largest ear first; where there is none, the best bite; where there is none, the longest edge
/// is split.
///
/// An ear is tried once. An edge is swept once ([`Apexes`]); the bite it offers waits in a heap until it is the best.
/// If something has come in its way by then, the edge offers the next best of what its sweep had found.
#[derive(Debug, Default)]
pub(super) struct LargestFirst {
    fresh: Fresh,
    ears: BinaryHeap<Ear>,
    bites: BinaryHeap<Bite>,
    splits: Splits,
    apexes: Apexes,
    /// By the edge's first node.
    swept: BTreeMap<u32, Swept>,
    /// New edges. They are not looked at before the ears are cut: most are gone by then.
    pending: Vec<Edge>,
    /// All edges ever swept.
    #[cfg(test)]
    pub(super) seen: std::collections::HashSet<(Point, Point)>,
}

/// A corner that turns left: twice its area, and its nodes.
type Ear = (i64, Reverse<[u32; 3]>);

/// The best bite an edge has to offer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Bite {
    score: i64,
    place: Reverse<Point>,
    edge: Reverse<Edge>,
    /// The apex's height, bit for bit.
    height: u64,
}

/// What is left of an edge's sweep.
#[derive(Debug, Clone, Copy)]
struct Swept {
    /// Where the edge leads. The node it leads to may change, when a bite splits the polygon there.
    to: Point,
    prospects: Prospects,
}

impl Strategy for LargestFirst {
    fn clear(&mut self) {
        self.ears.clear();
        self.bites.clear();
        self.splits.clear();
        self.swept.clear();
        self.pending.clear();
        #[cfg(test)]
        self.seen.clear();
    }

    fn cut(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        self.look_at_fresh(front);
        if self.cut_ear(front, tester) {
            return true;
        }
        while let Some(edge) = self.pending.pop() {
            if front.has_edge(edge) {
                self.offer(front, tester, edge);
            }
        }
        self.bite(front, tester) || self.splits.cut(front, tester)
    }

    fn take_hopeless(&mut self, into: &mut Vec<Edge>) {
        self.splits.take_hopeless(into);
    }
}

impl LargestFirst {
    fn look_at_fresh(&mut self, front: &mut Front) {
        front.take_fresh(&mut self.fresh);
        for &i in &self.fresh.corners {
            let (p, q) = (front.prev(i), front.next(i));
            if !front.has_edge((p, i)) {
                continue;
            }
            let area = orient(front.at(p), front.at(i), front.at(q));
            if area > 0 {
                self.ears.push((area, Reverse([p, i, q])));
            }
        }
        self.pending.append(&mut self.fresh.edges);
    }

    fn cut_ear(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some((_, Reverse([p, i, q]))) = self.ears.pop() {
            if !front.has_edge((p, i)) || !front.has_edge((i, q)) {
                continue;
            }
            let corners = [p, i, q].map(|n| front.vertex(n));
            let closing = [(corners[0], corners[2])];
            let new_edges = if front.has_edge((q, p)) { &[] } else { &closing[..] };
            if tester.feasible(corners, new_edges) && front.ear_is_visible(p, i, q) {
                front.cut_ear(p, i, q);
                return true;
            }
        }
        false
    }

    /// Puts the best bite from an edge on the heap.
    fn offer(&mut self, front: &Front, tester: &Tester<'_>, edge: Edge) {
        let to = front.at(edge.1);
        let best = match self.swept.get_mut(&edge.0).filter(|swept| swept.to == to) {
            Some(swept) => self.apexes.next_best(front, tester, edge, &mut swept.prospects),
            None => {
                #[cfg(test)]
                assert!(self.seen.insert((front.at(edge.0), to)), "edge {edge:?} is swept twice");
                let (best, prospects) = self.apexes.sweep(front, tester, edge);
                self.swept.insert(edge.0, Swept { to, prospects });
                best
            }
        };
        match best {
            Some((score, apex)) => {
                let (place, height) = (Reverse(apex.at), apex.height.to_bits());
                self.bites.push(Bite { score, place, edge: Reverse(edge), height });
            }
            None => self.splits.push(front, edge),
        }
        self.forget_the_dead(front);
    }

    /// Keeps what is remembered of edges as small as the front.
    fn forget_the_dead(&mut self, front: &Front) {
        let enough = 1024 + 2 * front.alive();
        if self.bites.len() > enough {
            self.bites.retain(|bite| front.has_edge(bite.edge.0));
        }
        if self.swept.len() > enough {
            self.swept.retain(|&node, swept| front.leads_to(node, swept.to));
        }
    }

    fn bite(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some(Bite { place: Reverse(at), edge: Reverse(edge), height, .. }) = self.bites.pop() {
            if !front.has_edge(edge) {
                continue;
            }
            match front.visible_apex(edge, Vertex { at, height: f64::from_bits(height) }) {
                Some(apex) => {
                    front.bite(edge, apex);
                    return true;
                }
                None => self.offer(front, tester, edge),
            }
        }
        false
    }
}
