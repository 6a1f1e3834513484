//! What is left when no ear, bite or split is feasible: a complete search (section 3, Termination).
//!
//! Weak feasibility never gets stuck. From any edge of the front some vertex of the front is visible; in the triangle
//! between, the sample of least positive distance from the edge's line makes a triangle that holds no sample but on the
//! edge itself (so no given point, either), and every edge of the front is within the tolerance at the samples it passes. Samples on the triangle's
//! other sides count only where these sides are new: a vertex on an edge of the front would be a T-junction.
//!
//! Strong feasibility can get stuck. Then, of all the ears that are weakly feasible, the one that strays least from the
//! grid surface is taken; where there is none, the complete search's bite that strays least.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Edge;
use super::front::{Apex, Front};
use super::places::feasible_apex;
use crate::base::lattice::{Point, STEPS, distance2, orient};
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::{Spans, Tester};

/// How far around an edge's bounding box, in cells, strong feasibility looks at every sample before it is relaxed.
const STRONG_REACH: i32 = 4;

/// The edges that nothing else helps, and for the strong test the triangles that relax it least.
#[derive(Debug, Default)]
pub(super) struct LastResort {
    edges: Vec<Edge>,
    shortest: BinaryHeap<Reverse<(i64, Edge)>>,
    stuck: Vec<Edge>,
    relaxed_ears: BinaryHeap<Reverse<(Deviation, [u32; 3])>>,
}

/// A distance from the grid surface, in an order for heaps: of non-negative doubles the bits ascend with the value.
type Deviation = u64;

/// A triangle that ends on the front.
#[derive(Debug, Clone, Copy)]
enum Cut {
    Ear([u32; 3]),
    Bite(Edge, Apex),
}

impl LastResort {
    /// Forgets the tile before.
    pub(super) fn clear(&mut self) {
        self.edges.clear();
        self.shortest.clear();
        self.stuck.clear();
        self.relaxed_ears.clear();
    }

    /// Where edges without hope are put.
    pub(super) fn edges(&mut self) -> &mut Vec<Edge> {
        &mut self.edges
    }

    /// Makes a weakly feasible cut from the shortest of the edges.
    pub(super) fn cut_weak(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some(edge) = self.next_shortest(front) {
            if let Some(cut) = complete_search(front, tester, edge) {
                make(front, cut);
                return true;
            }
        }
        false
    }

    /// Makes a strongly feasible cut near one of the edges, or else the weakly feasible one that strays least.
    pub(super) fn cut_strong(&mut self, front: &mut Front, tester: &Tester<'_>) -> bool {
        while let Some(edge) = self.next_shortest(front) {
            if let Some(apex) = search_around(front, tester, edge) {
                front.bite(edge, apex);
                return true;
            }
            self.stuck.push(edge);
            self.remember_ears(front, tester, edge);
        }
        let cut = self.least_ear(front).or_else(|| self.least_bite(front, tester));
        if let Some(cut) = cut {
            front.count_relaxed();
            make(front, cut);
        }
        cut.is_some()
    }

    fn next_shortest(&mut self, front: &Front) -> Option<Edge> {
        for edge in self.edges.drain(..) {
            if front.has_edge(edge) {
                self.shortest.push(Reverse((distance2(front.at(edge.0), front.at(edge.1)), edge)));
            }
        }
        loop {
            let Reverse((_, edge)) = self.shortest.pop()?;
            if front.has_edge(edge) {
                return Some(edge);
            }
        }
    }

    /// Notes the ears at both ends of an edge that are weakly feasible, once for each of their edges that gets stuck.
    fn remember_ears(&mut self, front: &Front, tester: &Tester<'_>, (a, b): Edge) {
        for [p, i, q] in [[front.prev(a), a, b], [a, b, front.next(b)]] {
            let corners = [p, i, q].map(|n| front.vertex(n));
            if front.ear_is_visible(p, i, q) && tester.weakly_feasible(corners) {
                let deviation = tester.edge_deviation(corners[0], corners[2]);
                self.relaxed_ears.push(Reverse((deviation.to_bits(), [p, i, q])));
            }
        }
    }

    fn least_ear(&mut self, front: &Front) -> Option<Cut> {
        loop {
            let Reverse((_, [p, i, q])) = self.relaxed_ears.pop()?;
            if front.has_edge((p, i)) && front.has_edge((i, q)) && front.ear_is_visible(p, i, q) {
                return Some(Cut::Ear([p, i, q]));
            }
        }
    }

    /// Only reached when no ear at a stuck edge is weakly feasible, so it may look at all of them anew.
    fn least_bite(&mut self, front: &Front, tester: &Tester<'_>) -> Option<Cut> {
        self.stuck.retain(|&edge| front.has_edge(edge));
        let cuts = self.stuck.iter().filter_map(|&edge| complete_search(front, tester, edge));
        cuts.min_by_key(|&cut| deviation(front, tester, cut))
    }
}

fn make(front: &mut Front, cut: Cut) {
    match cut {
        Cut::Ear([p, i, q]) => front.cut_ear(p, i, q),
        Cut::Bite(edge, apex) => {
            front.bite(edge, apex);
        }
    }
}

/// How far the new edges of a cut stray from the grid surface.
fn deviation(front: &Front, tester: &Tester<'_>, cut: Cut) -> Deviation {
    let farthest = match cut {
        Cut::Ear([p, _, q]) => tester.edge_deviation(front.vertex(p), front.vertex(q)),
        Cut::Bite((a, b), apex) => {
            let v = match apex {
                Apex::New(v) => v,
                Apex::Node(k) => front.vertex(k),
            };
            tester.edge_deviation(front.vertex(a), v).max(tester.edge_deviation(front.vertex(b), v))
        }
    };
    farthest.to_bits()
}

/// A feasible bite to any sample near the edge: closest to its line first, then closest to its middle.
fn search_around(front: &Front, tester: &Tester<'_>, edge: Edge) -> Option<Apex> {
    let (a, b) = (front.at(edge.0), front.at(edge.1));
    let cell = |v: i32| v.div_euclid(STEPS);
    let (left, right) = (cell(a.x.min(b.x)) - STRONG_REACH, cell(a.x.max(b.x)) + STRONG_REACH);
    let (top, bottom) = (cell(a.y.min(b.y)) - STRONG_REACH, cell(a.y.max(b.y)) + STRONG_REACH);
    let (columns, rows) = (cell(front.far_corner.x), cell(front.far_corner.y));
    let mut candidates = Vec::new();
    for row in top.max(0)..=bottom.min(rows) {
        for column in left.max(0)..=right.min(columns) {
            let p = Point::of_sample(column, row);
            let away = orient(a, b, p);
            if away > 0 {
                candidates.push((away, distance2(a, p) + distance2(b, p), p));
            }
        }
    }
    candidates.sort_unstable();
    candidates.into_iter().find_map(|(_, _, p)| feasible_apex(front, tester, edge, sample(tester, p)))
}

/// A weakly feasible cut from this edge; there always is one.
fn complete_search(front: &Front, tester: &Tester<'_>, edge: Edge) -> Option<Cut> {
    let cut = visible_vertex(front, edge)?;
    let (a, b) = (front.vertex(edge.0), front.vertex(edge.1));
    let (third, locked) = match cut {
        Cut::Ear([p, i, q]) => {
            // The ear's other side is an edge of the front, and its third side is one too where it closes a polygon.
            let third = if i == edge.0 { p } else { q };
            let closes = front.has_edge((q, p));
            (front.vertex(third), [closes || i == edge.0, closes || i == edge.1])
        }
        Cut::Bite(_, Apex::Node(k)) => (front.vertex(k), [false, false]),
        Cut::Bite(_, Apex::New(_)) => unreachable!("a visible vertex is on the front"),
    };
    let cut = match least_sample([a.at, b.at, third.at], locked) {
        Some(place) => Cut::Bite(edge, front.visible_apex(edge, sample(tester, place))?),
        None => cut,
    };
    debug_assert!(
        matches!(cut, Cut::Ear(_)) || {
            let v = match cut {
                Cut::Bite(_, Apex::New(v)) => v,
                _ => third,
            };
            tester.weakly_feasible([a, b, v])
        },
        "the emptiest triangle over {a:?} {b:?} is not feasible"
    );
    Some(cut)
}

/// A vertex of the front that the whole edge sees, near the edge's middle rather than far: as an ear where it is beside
/// the edge, else as a bite.
fn visible_vertex(front: &Front, edge: Edge) -> Option<Cut> {
    let (a, b) = (front.at(edge.0), front.at(edge.1));
    let middle = Point { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 };
    let mut nodes = Vec::new();
    let mut reach = 16 * STEPS;
    let everywhere = front.far_corner.x.max(front.far_corner.y);
    loop {
        nodes.clear();
        if reach < everywhere {
            nodes.extend(front.grid.near(middle, reach));
        } else {
            nodes.extend(front.nodes_alive());
        }
        nodes.sort_unstable_by_key(|&n| (distance2(middle, front.at(n)), n));
        nodes.dedup();
        let cut = nodes.iter().find_map(|&n| sees(front, edge, n));
        if cut.is_some() || reach >= everywhere {
            return cut;
        }
        reach *= 4;
    }
}

fn sees(front: &Front, (a, b): Edge, node: u32) -> Option<Cut> {
    if node == front.prev(a) {
        return front.ear_is_inside(node, a, b).then_some(Cut::Ear([node, a, b]));
    }
    if node == front.next(b) {
        return front.ear_is_inside(a, b, node).then_some(Cut::Ear([a, b, node]));
    }
    if orient(front.at(a), front.at(b), front.at(node)) <= 0 {
        return None;
    }
    let apex = front.apex_inside((a, b), front.vertex(node))?;
    matches!(apex, Apex::Node(_)).then_some(Cut::Bite((a, b), apex))
}

/// The sample in the closed triangle a–b–c that is nearest to the line a–b, but neither on it, nor c, nor on one of the
/// sides a–c and b–c if that one is locked.
fn least_sample([a, b, c]: [Point; 3], [ac_locked, bc_locked]: [bool; 2]) -> Option<Point> {
    let spans = Spans::new(a, b, c);
    let mut least: Option<(i64, Point)> = None;
    for row in spans.rows() {
        let (first, last) = spans.columns(row);
        for column in first..=last {
            let p = Point::of_sample(column, row);
            let away = orient(a, b, p);
            let excluded =
                away == 0 || p == c || ac_locked && orient(a, c, p) == 0 || bc_locked && orient(b, c, p) == 0;
            if !excluded && least.is_none_or(|l| (away, p) < l) {
                least = Some((away, p));
            }
        }
    }
    least.map(|(_, p)| p)
}

fn sample(tester: &Tester<'_>, place: Point) -> Vertex {
    let (column, row) = ((place.x / STEPS) as usize, (place.y / STEPS) as usize);
    Vertex { at: place, height: tester.tile().at(column, row) }
}
