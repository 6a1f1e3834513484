//! A grid of buckets that finds the front's edges near a place.

use std::ops::ControlFlow;

use crate::base::lattice::{Point, STEPS};

/// A uniform grid over a tile that lists, per square, the front's edges that touch it. Edges are named by their first
/// node. Lists are chains in one pool, so that nothing is allocated while the front moves.
#[derive(Debug)]
pub(super) struct EdgeGrid {
    across: i32,
    down: i32,
    heads: Vec<u32>,
    links: Vec<Link>,
    free: u32,
}

#[derive(Debug, Clone, Copy)]
struct Link {
    edge: u32,
    next: u32,
}

const NONE: u32 = u32::MAX;

/// A square's side in steps, as a power of two: 16 cells.
const SHIFT: i32 = 4 + STEPS.ilog2() as i32;

/// How far, in steps, an edge is thought to reach to either side: it covers the rounding of [`EdgeGrid::walk`].
const MARGIN: f64 = 0.01;

impl Default for EdgeGrid {
    fn default() -> Self {
        EdgeGrid { across: 0, down: 0, heads: Vec::new(), links: Vec::new(), free: NONE }
    }
}

impl EdgeGrid {
    /// Empties the grid and lays it over a tile, reusing its memory.
    pub(super) fn reset(&mut self, far_corner: Point) {
        (self.across, self.down) = ((far_corner.x >> SHIFT) + 1, (far_corner.y >> SHIFT) + 1);
        self.heads.clear();
        self.heads.resize((self.across * self.down) as usize, NONE);
        self.links.clear();
        self.free = NONE;
    }

    /// Lists the edge from `a` to `b`.
    pub(super) fn insert(&mut self, edge: u32, a: Point, b: Point) {
        let EdgeGrid { heads, links, free, .. } = self;
        let _ = walk(self.across, self.down, a, b, |square| {
            let link = Link { edge, next: heads[square] };
            heads[square] = match *free {
                NONE => {
                    links.push(link);
                    links.len() as u32 - 1
                }
                reused => {
                    *free = std::mem::replace(&mut links[reused as usize], link).next;
                    reused
                }
            };
            ControlFlow::Continue(())
        });
    }

    /// Takes the edge from `a` to `b` off the lists it was put on by [`EdgeGrid::insert`] with the same places.
    pub(super) fn remove(&mut self, edge: u32, a: Point, b: Point) {
        let EdgeGrid { heads, links, free, .. } = self;
        let _ = walk(self.across, self.down, a, b, |square| {
            let (mut before, mut at) = (NONE, heads[square]);
            while links[at as usize].edge != edge {
                before = at;
                at = links[at as usize].next;
            }
            let next = std::mem::replace(&mut links[at as usize].next, *free);
            *free = at;
            match before {
                NONE => heads[square] = next,
                before => links[before as usize].next = next,
            }
            ControlFlow::Continue(())
        });
    }

    /// Visits the edges listed in the squares that the line from `a` to `b` touches, some of them more than once, until
    /// `visit` breaks.
    pub(super) fn along(&self, a: Point, b: Point, mut visit: impl FnMut(u32) -> ControlFlow<()>) -> ControlFlow<()> {
        walk(self.across, self.down, a, b, |square| self.list(square).try_for_each(&mut visit))
    }

    /// The edges listed in the square of a place.
    pub(super) fn at(&self, p: Point) -> impl Iterator<Item = u32> {
        self.list(((p.y >> SHIFT) * self.across + (p.x >> SHIFT)) as usize)
    }

    /// The edges listed in the squares within `reach` steps of a place (as a box), some of them more than once.
    pub(super) fn near(&self, p: Point, reach: i32) -> impl Iterator<Item = u32> {
        let square = |v: i32, count: i32| (v >> SHIFT).clamp(0, count - 1);
        let columns = square(p.x.saturating_sub(reach), self.across)..=square(p.x.saturating_add(reach), self.across);
        let rows = square(p.y.saturating_sub(reach), self.down)..=square(p.y.saturating_add(reach), self.down);
        rows.flat_map(move |row| {
            columns.clone().flat_map(move |column| self.list((row * self.across + column) as usize))
        })
    }

    fn list(&self, square: usize) -> impl Iterator<Item = u32> {
        let mut at = self.heads[square];
        std::iter::from_fn(move || {
            let link = self.links.get(at as usize)?;
            at = link.next;
            Some(link.edge)
        })
    }
}

/// Visits every square that the segment a–b touches, and perhaps one beside it, row by row. The same places give the
/// same squares, in either direction.
fn walk(
    across: i32,
    down: i32,
    a: Point,
    b: Point,
    mut visit: impl FnMut(usize) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let (a, b) = if (a.y, a.x) <= (b.y, b.x) { (a, b) } else { (b, a) };
    let slope = if a.y == b.y { 0.0 } else { f64::from(b.x - a.x) / f64::from(b.y - a.y) };
    let (first, last) = (a.y >> SHIFT, (b.y >> SHIFT).min(down - 1));
    for row in first..=last {
        let (from, to) = if a.y == b.y {
            (f64::from(a.x), f64::from(b.x))
        } else {
            let top = (row << SHIFT).max(a.y) - a.y;
            let bottom = ((row + 1) << SHIFT).min(b.y) - a.y;
            (f64::from(a.x) + slope * f64::from(top), f64::from(a.x) + slope * f64::from(bottom))
        };
        let square = |x: f64| ((x as i32) >> SHIFT).clamp(0, across - 1);
        for column in square(from.min(to) - MARGIN)..=square(from.max(to) + MARGIN) {
            visit((row * across + column) as usize)?;
        }
    }
    ControlFlow::Continue(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::orient;
    use proptest::prelude::*;

    fn crosses(a: Point, b: Point, c: Point, d: Point) -> bool {
        let sign = |p, q, r| orient(p, q, r).signum();
        sign(a, b, c) * sign(a, b, d) < 0 && sign(c, d, a) * sign(c, d, b) < 0
    }

    proptest! {
        #[test]
        fn a_line_meets_every_edge_it_crosses(
            edges in prop::collection::vec(prop::array::uniform4(0i32..2000), 1..20),
            removed in prop::collection::vec(any::<bool>(), 20), line in prop::array::uniform4(0i32..2000),
        ) {
            let mut grid = EdgeGrid::default();
            grid.reset(Point { x: 1999, y: 1999 });
            let ends = |v: &[i32; 4]| (Point { x: v[0], y: v[1] }, Point { x: v[2], y: v[3] });
            for (i, e) in edges.iter().enumerate() { grid.insert(i as u32, ends(e).0, ends(e).1); }
            for (i, e) in edges.iter().enumerate() { if removed[i] { grid.remove(i as u32, ends(e).0, ends(e).1); } }
            let (p, q) = ends(&line);
            let mut met = vec![false; edges.len()];
            let _ = grid.along(p, q, |e| { met[e as usize] = true; ControlFlow::Continue(()) });
            for (i, e) in edges.iter().enumerate() {
                let (a, b) = ends(e);
                if removed[i] { prop_assert!(!met[i]) }
                else if crosses(a, b, p, q) { prop_assert!(met[i], "edge {:?} line {:?}", e, line) }
            }
        }
    }
}
