//! Edges that the mesh must have, as slits in the ground: each is an edge of the front on both of its sides (Silva, Mitchell &
//! Kaufman 1995, section 3, where features are part of the initial polygons).

use std::cmp::Ordering;
use std::collections::BTreeMap;

use crate::base::lattice::{Point, dot, orient};
use crate::base::mesh::{Domain, loop_edges};

/// The rim of a domain's ground as directed edges, each with the ground to its left: those of the loops in their order, then both
/// directions of every edge of the domain that no loop has.
#[derive(Debug, Default)]
pub(super) struct Rims {
    /// From which vertex each leads to which.
    pub(super) edges: Vec<(u32, u32)>,
    /// Which one follows.
    pub(super) next: Vec<u32>,
    /// A place on every rim around which there is ground: of voids, and of slits that no rim reaches.
    pub(super) holes: Vec<Point>,
}

impl Rims {
    /// Finds those of a domain, reusing the memory.
    pub(super) fn find(&mut self, domain: &Domain) {
        self.edges.clear();
        self.next.clear();
        self.holes.clear();
        for corners in &domain.loops {
            let (base, count) = (self.next.len() as u32, corners.len() as u32);
            self.edges.extend((0..corners.len()).map(|i| (corners[i], corners[(i + 1) % corners.len()])));
            self.next.extend((0..count).map(|i| base + (i + 1) % count));
        }
        let of_loops = loop_edges(domain);
        let is_of_loop = |edge: (u32, u32)| of_loops.binary_search(&edge).is_ok();
        let slits = domain.edges.iter().filter(|&&(a, b)| !is_of_loop((a, b)) && !is_of_loop((b, a)));
        let first_slit = self.edges.len();
        self.edges.extend(slits.flat_map(|&(a, b)| [(a, b), (b, a)]));
        if self.edges.len() == first_slit {
            self.holes.extend(domain.holes());
            return;
        }
        self.join(domain, first_slit);
        self.find_holes(domain);
    }

    /// Finds what follows each edge that leads to a vertex with a slit: the next one clockwise from where it came from, as the ground
    /// between two edges is to the left of the one that leads away.
    fn join(&mut self, domain: &Domain, first_slit: usize) {
        let at = |vertex: u32| domain.vertices[vertex as usize].at;
        let mut away: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &(from, _) in &self.edges[first_slit..] {
            away.entry(from).or_default();
        }
        for (&(from, _), number) in self.edges.iter().zip(0u32..) {
            away.entry(from).and_modify(|all| all.push(number));
        }
        self.next.resize(self.edges.len(), u32::MAX);
        for (&(from, to), next) in self.edges.iter().zip(&mut self.next) {
            let Some(all) = away.get(&to) else { continue };
            let (centre, back) = (at(to), at(from));
            let end = |number: u32| at(self.edges[number as usize].1);
            let first = all
                .iter()
                .copied()
                .reduce(|first, other| if is_before(centre, back, end(other), end(first)) { other } else { first });
            *next = first.expect("a slit leads away");
        }
    }

    /// A rim with ground outside goes round no area, or round one to its right.
    fn find_holes(&mut self, domain: &Domain) {
        let Rims { edges, next, holes } = self;
        let at = |edge: u32| domain.vertices[edges[edge as usize].0 as usize].at;
        let origin = Point { x: 0, y: 0 };
        let mut is_seen = vec![false; edges.len()];
        for first in 0..edges.len() as u32 {
            if is_seen[first as usize] {
                continue;
            }
            let (mut area, mut edge) = (0i128, first);
            while !std::mem::replace(&mut is_seen[edge as usize], true) {
                area += i128::from(orient(origin, at(edge), at(next[edge as usize])));
                edge = next[edge as usize];
            }
            if area <= 0 {
                holes.push(at(first));
            }
        }
    }
}

/// Whether a ray that turns clockwise about a centre, from one place on, meets `a` before `b`. It meets the place itself last.
fn is_before(centre: Point, from: Point, a: Point, b: Point) -> bool {
    let quarter = |p: Point| match orient(centre, from, p) {
        right if right < 0 => 0,
        left if left > 0 => 2,
        _ if dot(centre, from, p) < 0 => 1,
        _ => 3,
    };
    match quarter(a).cmp(&quarter(b)) {
        Ordering::Equal => orient(centre, a, b) < 0,
        other => other == Ordering::Less,
    }
}
