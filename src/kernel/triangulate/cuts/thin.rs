//! Cuts at edges that no bite fits: the thinnest of triangles.

use std::collections::BinaryHeap;

use super::Edge;
use super::front::{Apex, Front};
use super::places::{Base, feasible_apex};
use crate::base::lattice::distance2;
use crate::kernel::triangulate::feasible::Tester;

/// Edges that no bite was found for, to be split: the longest first, each tried once. What cannot be split either is
/// left to the last resort.
#[derive(Debug, Default)]
pub(super) struct Splits {
    longest: BinaryHeap<(i64, Edge)>,
    hopeless: Vec<Edge>,
}

impl Splits {
    pub(super) fn clear(&mut self) {
        self.longest.clear();
        self.hopeless.clear();
    }

    /// Remembers an edge of the front.
    pub(super) fn push(&mut self, front: &Front, edge: Edge) {
        self.longest.push((distance2(front.at(edge.0), front.at(edge.1)), edge));
    }

    /// Splits one edge; `false` if none can be.
    pub(super) fn cut(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some((_, edge)) = self.longest.pop() {
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

    /// Hands over the edges that could not be split.
    pub(super) fn take_hopeless(&mut self, into: &mut Vec<Edge>) {
        into.append(&mut self.hopeless);
    }
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
