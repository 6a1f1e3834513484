//! Which cuts stay inside the untriangulated ground. All tests are exact.

use std::ops::ControlFlow;

use super::Edge;
use super::front::{Apex, Front};
use crate::base::lattice::{Point, dot, orient};
use crate::base::mesh::Vertex;

impl Front {
    /// Whether a line from `node` to `target` sets out strictly inside the node's wedge of ground.
    pub(super) fn wedge_contains(&self, node: u32, target: Point) -> bool {
        let (p, v, q) = (self.at(self.prev(node)), self.at(node), self.at(self.next(node)));
        if p == q {
            // The end of a slit has ground all around.
            return orient(v, q, target) != 0 || dot(v, q, target) < 0;
        }
        let (left_of_out, left_of_in) = (orient(v, q, target) > 0, orient(p, v, target) > 0);
        match orient(p, v, q) {
            turn if turn > 0 => left_of_out && left_of_in,
            turn if turn < 0 => left_of_out || left_of_in,
            _ => left_of_out,
        }
    }

    /// Whether the open segment between two places touches no edge of the front, and overlaps none that ends at a or b.
    pub(super) fn segment_is_free(&self, a: Point, b: Point) -> bool {
        self.grid
            .along(a, b, |edge| {
                let (p, q) = (self.at(edge), self.at(self.next(edge)));
                if blocks(a, b, p, q) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })
            .is_continue()
    }

    /// Whether the corner p–i–q can be cut off as an ear: a positive turn, the new edge p–q inside the ground, and no given point
    /// covered.
    pub(super) fn ear_is_visible(&self, p: u32, i: u32, q: u32) -> bool {
        self.ear_is_inside(p, i, q) && !self.covers_point([p, i, q].map(|node| self.at(node)))
    }

    /// The same whatever given points it covers.
    pub(super) fn ear_is_inside(&self, p: u32, i: u32, q: u32) -> bool {
        let (pp, ip, qp) = (self.at(p), self.at(i), self.at(q));
        if orient(pp, ip, qp) <= 0 {
            return false;
        }
        // The last three nodes of a polygon need no new edge.
        let inside = self.next(q) == p
            || pp != qp && self.wedge_contains(p, qp) && self.wedge_contains(q, pp) && self.segment_is_free(pp, qp);
        inside && !self.surrounds_hole([pp, ip, qp])
    }

    /// Only holes in the rows of the triangle are asked about.
    fn surrounds_hole(&self, [a, b, c]: [Point; 3]) -> bool {
        let (top, bottom) = (a.y.min(b.y).min(c.y), a.y.max(b.y).max(c.y));
        let below = &self.holes[self.holes.partition_point(|h| h.y <= top)..];
        let inside = |h: Point| orient(a, b, h) > 0 && orient(b, c, h) > 0 && orient(c, a, h) > 0;
        below.iter().take_while(|h| h.y < bottom).any(|&h| inside(h))
    }

    /// What a bite from the edge a–b to a place would meet, or `None` if the triangle is not inside the ground, or covers a given
    /// point. An apex next to the edge on the front makes an ear, not a bite, and is not found here.
    pub(super) fn visible_apex(&self, (a, b): Edge, v: Vertex) -> Option<Apex> {
        self.apex_inside((a, b), v).filter(|_| !self.covers_point([self.at(a), self.at(b), v.at]))
    }

    /// The same whatever given points it covers.
    pub(super) fn apex_inside(&self, (a, b): Edge, v: Vertex) -> Option<Apex> {
        let (ap, bp) = (self.at(a), self.at(b));
        let inside = v.at.x >= 0 && v.at.y >= 0 && v.at.x <= self.far_corner.x && v.at.y <= self.far_corner.y;
        if !inside || orient(ap, bp, v.at) <= 0 || !self.wedge_contains(a, v.at) || !self.wedge_contains(b, v.at) {
            return None;
        }
        let apex = self.node_facing((a, b), v)?;
        let inside = self.segment_is_free(ap, v.at) && self.segment_is_free(bp, v.at);
        (inside && !self.surrounds_hole([ap, bp, v.at])).then_some(apex)
    }

    /// The node at a place whose wedge the triangle over a–b reaches into; a new vertex where no node stands there.
    fn node_facing(&self, (a, b): Edge, v: Vertex) -> Option<Apex> {
        let (ap, bp) = (self.at(a), self.at(b));
        let mut occupied = false;
        for node in self.grid.at(v.at) {
            if self.at(node) != v.at {
                continue;
            }
            occupied = true;
            if self.wedge_contains(node, ap) && self.wedge_contains(node, bp) {
                let beside = self.next(node) == a || self.prev(node) == b;
                // Both ends may lie in the wedge, and a hole that begins at this very node between them.
                let between = |p: Point| orient(v.at, ap, p) > 0 && orient(bp, v.at, p) > 0;
                let reaches_in = between(self.at(self.next(node))) || between(self.at(self.prev(node)));
                return (!beside && !reaches_in).then_some(Apex::Node(node));
            }
        }
        (!occupied).then_some(Apex::New(v))
    }
}

/// Whether the edge p–q is in the way of a new edge a–b: they cross, touch, or overlap. Sharing an end is allowed.
fn blocks(a: Point, b: Point, p: Point, q: Point) -> bool {
    let apart = p.x.max(q.x) < a.x.min(b.x)
        || p.x.min(q.x) > a.x.max(b.x)
        || p.y.max(q.y) < a.y.min(b.y)
        || p.y.min(q.y) > a.y.max(b.y);
    if apart {
        return false;
    }
    let (op, oq) = (orient(a, b, p), orient(a, b, q));
    if op > 0 && oq > 0 || op < 0 && oq < 0 {
        return false;
    }
    let (p_shared, q_shared) = (p == a || p == b, q == a || q == b);
    match (p_shared, q_shared) {
        (true, true) => true,
        (true, false) => oq == 0 && dot(p, q, other_end(a, b, p)) > 0,
        (false, true) => op == 0 && dot(q, p, other_end(a, b, q)) > 0,
        (false, false) => {
            let (oa, ob) = (orient(p, q, a), orient(p, q, b));
            !(oa > 0 && ob > 0 || oa < 0 && ob < 0)
        }
    }
}

fn other_end(a: Point, b: Point, end: Point) -> Point {
    if end == a { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(x: i32, y: i32) -> Point {
        Point { x, y }
    }

    #[test]
    fn edges_in_the_way() {
        let (a, b) = (p(0, 0), p(8, 8));
        assert!(blocks(a, b, p(0, 8), p(8, 0)), "crossing");
        assert!(blocks(a, b, p(4, 4), p(8, 0)), "an end on the open segment");
        assert!(blocks(p(8, 0), p(4, 4), a, b), "ending on an edge");
        assert!(blocks(a, b, p(2, 2), p(4, 4)), "inside it");
        assert!(blocks(a, b, p(0, 0), p(4, 4)), "overlapping from an end");
        assert!(blocks(a, b, p(-4, -4), p(12, 12)), "covering it");
        assert!(blocks(a, b, b, a), "the same edge, the other way round");
        assert!(!blocks(a, b, p(0, 0), p(-4, -4)), "going on from an end");
        assert!(!blocks(a, b, p(0, 0), p(0, 8)), "fanning out from an end");
        assert!(!blocks(a, b, p(9, 9), p(12, 12)), "beyond, on the same line");
        assert!(!blocks(a, b, p(0, 1), p(7, 8)), "beside it");
    }
}
