//! The first triangulation: the loops of a domain, constrained Delaunay, nothing but the ground.
//!
//! The loops' vertices and those of the domain's edges are inserted one after the other into a quadrilateral around them, the edges are enforced by
//! flips (Sloan 1993), and what is not to the left of a loop is taken away. Holes, islands and pinches need no case of
//! their own: the ground is what can be reached from the left sides of loop edges without crossing one.

use super::surface::{Site, Surface};
use super::topology::{next, prev};
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::{Domain, Vertex, locked_edges};

/// Triangulates the ground of `domain` into `surface`, whose vertices are then those of the domain, in their order. The
/// loops' edges are locked; all others are Delaunay. Cost: O(n log n) expected for n vertices.
pub(super) fn triangulate(domain: &Domain, surface: &mut Surface) {
    surface.clear();
    let count = domain.vertices.len() as u32;
    surface.vertices.extend_from_slice(&domain.vertices);
    surface.vertices.extend(frame(domain));
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| count + i);
    let (lower, upper) = (surface.topology.add([a, b, c]), surface.topology.add([a, c, d]));
    surface.topology.pair(3 * lower + 2, 3 * upper);
    let mut near = lower;
    // In the order of the loops, so that each vertex is near the one before.
    let mut seen = vec![false; count as usize];
    let of_edges = domain.edges.iter().flat_map(|&(a, b)| [a, b]);
    for v in domain.loops.iter().flatten().copied().chain(of_edges) {
        if std::mem::replace(&mut seen[v as usize], true) {
            continue;
        }
        let site = surface.locate(near, surface.at(v));
        near = surface.connect(v, site).expect("vertices of a domain lie apart, inside their frame");
        surface.legalize();
    }
    let edges = locked_edges(domain);
    for &(a, b) in &edges {
        near = enforce(surface, near, a, b);
    }
    keep_ground(surface, &edges, count);
    drop(edges);
    surface.legalize_all();
}

/// Four corners around the domain, one cell away.
fn frame(domain: &Domain) -> [Vertex; 4] {
    let places = || domain.vertices.iter().map(|v| v.at);
    let (x0, x1) = (places().map(|p| p.x).min().unwrap_or(0), places().map(|p| p.x).max().unwrap_or(0));
    let (y0, y1) = (places().map(|p| p.y).min().unwrap_or(0), places().map(|p| p.y).max().unwrap_or(0));
    let (x0, x1, y0, y1) = (x0 - STEPS, x1 + STEPS, y0 - STEPS, y1 + STEPS);
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Vertex { at: Point { x, y }, height: 0.0 })
}

/// Flips edges that cross the segment a–b until it is an edge. A triangle at `a`.
fn enforce(surface: &mut Surface, near: u32, a: u32, b: u32) -> u32 {
    let start = half_edge_from(surface, near, a);
    let Some(first) = first_crossed(surface, start, a, b) else { return start / 3 };
    let mut crossing = std::collections::VecDeque::new();
    // Along the segment, from triangle to triangle; half-edges that leave the one before.
    let (pa, pb) = (surface.at(a), surface.at(b));
    let mut e = first;
    loop {
        crossing.push_back(ends(surface, e));
        let f = surface.topology.twin(e);
        let apex = surface.topology.origin(prev(f));
        if apex == b {
            break;
        }
        let side = orient(pa, pb, surface.at(apex));
        assert!(side != 0, "an edge of a loop passes a vertex at {:?}", surface.at(apex));
        // f runs from right to left of a–b, seen the other way around; the segment leaves where the apex is not.
        e = if side > 0 { next(f) } else { prev(f) };
    }
    while let Some((x, y)) = crossing.pop_front() {
        let e = find_edge(surface, first / 3, x, y);
        if !surface.is_convex(e) {
            crossing.push_back((x, y));
            continue;
        }
        let p = surface.topology.origin(prev(e));
        let q = surface.topology.origin(prev(surface.topology.twin(e)));
        surface.topology.flip(e);
        let sides = [p, q].map(|v| if v == a || v == b { 0 } else { orient(pa, pb, surface.at(v)).signum() });
        if sides[0] * sides[1] < 0 {
            crossing.push_back((p, q));
        }
    }
    half_edge_from(surface, first / 3, a) / 3
}

fn ends(surface: &Surface, e: u32) -> (u32, u32) {
    (surface.topology.origin(e), surface.topology.origin(next(e)))
}

/// A half-edge that starts at vertex `v`.
fn half_edge_from(surface: &Surface, near: u32, v: u32) -> u32 {
    match surface.locate(near, surface.at(v)) {
        Site::Vertex(e) => e,
        other => unreachable!("vertex {v} is in the triangulation, found {other:?}"),
    }
}

/// The half-edge opposite `a` that the segment a–b crosses first; `None` if a–b is an edge.
fn first_crossed(surface: &Surface, start: u32, a: u32, b: u32) -> Option<u32> {
    let (pa, pb) = (surface.at(a), surface.at(b));
    let mut e = start;
    loop {
        let (x, y) = (surface.topology.origin(next(e)), surface.topology.origin(prev(e)));
        if x == b || y == b {
            return None;
        }
        if orient(pa, pb, surface.at(x)) < 0 && orient(pa, pb, surface.at(y)) > 0 {
            return Some(next(e));
        }
        // All around: vertices of the domain are inside the frame.
        assert!(!surface.topology.is_locked(prev(e)), "no way from vertex {a} to {b}");
        e = surface.topology.twin(prev(e));
        assert!(e != start, "no way from vertex {a} to {b}");
    }
}

/// The half-edge between two vertices that are joined and have a triangle to their left. Either may be of the frame.
fn find_edge(surface: &Surface, near: u32, x: u32, y: u32) -> u32 {
    let topology = &surface.topology;
    let leads_to_y = |e: &u32| topology.origin(next(*e)) == y;
    let start = half_edge_from(surface, near, x);
    // One way around, then, should the rim of the frame be in the way, the other.
    let onwards = std::iter::successors(Some(start), |&e| {
        (!topology.is_locked(prev(e))).then(|| topology.twin(prev(e))).filter(|&e| e != start)
    });
    let backwards = std::iter::successors(Some(start), |&e| {
        (!topology.is_locked(e)).then(|| next(topology.twin(e))).filter(|&e| e != start)
    });
    onwards.chain(backwards).find(leads_to_y).unwrap_or_else(|| panic!("an edge from vertex {x} to {y}"))
}

/// Takes away triangles that are not ground, and the frame; locks the edges of the loops.
fn keep_ground(surface: &mut Surface, edges: &[(u32, u32)], count: u32) {
    let all = surface.topology.len();
    let is_loop = |e: u32| edges.binary_search(&ends(surface, e)).is_ok();
    let mut ground = vec![false; all as usize];
    let mut pending: Vec<u32> = (0..3 * all).filter(|&e| is_loop(e)).map(|e| e / 3).collect();
    while let Some(t) = pending.pop() {
        if std::mem::replace(&mut ground[t as usize], true) {
            continue;
        }
        for e in 3 * t..3 * t + 3 {
            let f = surface.topology.twin(e);
            if !surface.topology.is_locked(e) && !is_loop(e) && !is_loop(f) {
                pending.push(f / 3);
            }
        }
    }
    drop(pending);
    surface.topology.retain(&ground, |a, b| [(a, b), (b, a)].iter().any(|edge| edges.binary_search(edge).is_ok()));
    surface.vertices.truncate(count as usize);
}
