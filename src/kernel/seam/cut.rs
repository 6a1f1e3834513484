//! The loops around the ground of a tile, cut at outlines that the mesh ends at.
//!
//! What is left of the ground is bounded by those edges of its loops that have the inside to their left, and by the edges of the outlines
//! in its midst. Every vertex of either that lies on the other is a vertex of both, so nothing is left but to lead loops anew.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use crate::base::Window;
use crate::base::lattice::{Point, dot, orient};
use crate::kernel::breaklines::{Inside, TileChains};

/// The loops around what of the ground is inside. `loops` go around the ground of a tile with this window and last place, from sample to
/// sample and through the ends of `chains` that lie on them.
pub(super) fn cut(
    loops: &[Vec<Point>],
    chains: &TileChains,
    inside: &Inside,
    (window, far): (Window, Point),
) -> Vec<Vec<Point>> {
    let around = |l: &'_ Vec<Point>| (0..l.len()).map(|i| [l[i], l[(i + 1) % l.len()]]).collect::<Vec<_>>();
    let kept = loops.iter().flat_map(around).filter(|&edge| inside.is_left_of(window, edge));
    // What is on a side of the tile is of a loop, or has its ground in the next tile.
    let on_side =
        |p: Point, q: Point| p.x == q.x && (p.x == 0 || p.x == far.x) || p.y == q.y && (p.y == 0 || p.y == far.y);
    let border = chains.border().iter().map(|edge| edge.map(|v| v.at)).filter(|&[p, q]| !on_side(p, q));
    let edges: BTreeSet<[(i32, i32); 2]> = kept.chain(border).map(|edge| edge.map(|at| (at.y, at.x))).collect();
    lead(edges.into_iter().map(|edge| edge.map(|(y, x)| Point { x, y })))
}

/// Loops along all of these edges, which come in the order of their first ends. Each turns as far left as it can, so that the ground to the
/// left of every corner is one wedge.
fn lead(edges: impl Iterator<Item = [Point; 2]>) -> Vec<Vec<Point>> {
    let mut ways: BTreeMap<(i32, i32), Vec<Point>> = BTreeMap::new();
    edges.for_each(|[from, to]| ways.entry((from.y, from.x)).or_default().push(to));
    let mut loops = Vec::new();
    while let Some(mut first) = ways.first_entry() {
        let &(y, x) = first.key();
        let (start, mut at) = (Point { x, y }, first.get_mut().swap_remove(0));
        if first.get().is_empty() {
            first.remove();
        }
        let mut way = vec![start];
        let first_step = at;
        loop {
            let before = way[way.len() - 1];
            let key = (at.y, at.x);
            let next = ways.get(&key).and_then(|ways| {
                ways.iter().copied().enumerate().max_by(|a, b| by_turn(before, at, a.1, b.1)).map(|(i, _)| i)
            });
            // A way that comes back to its start goes on as it began where that is the leftmost turn.
            if at == start {
                let on = next.map(|i| ways[&key][i]);
                if on.is_none_or(|on| by_turn(before, at, first_step, on).is_ge()) {
                    break;
                }
            }
            let next = next.unwrap_or_else(|| panic!("the ground's border ends at {at:?}"));
            let all = ways.get_mut(&key).expect("there is one");
            way.push(at);
            at = all.swap_remove(next);
            if all.is_empty() {
                ways.remove(&key);
            }
        }
        loops.push(way);
    }
    loops
}

/// Which of two ways on from a place turns farther to the left, for somebody who comes from another: the greater.
fn by_turn(from: Point, at: Point, a: Point, b: Point) -> Ordering {
    // To the left or straight on, then to the right: within either half a cross product tells.
    let half = |p: Point| match orient(from, at, p).signum() {
        1 => 2,
        0 if forward(from, at, p) => 1,
        -1 => 0,
        _ => -1,
    };
    half(a).cmp(&half(b)).then_with(|| orient(at, b, a).cmp(&0))
}

/// Whether a place on a line is ahead of somebody who comes along it.
fn forward(from: Point, at: Point, p: Point) -> bool {
    dot(at, p, Point { x: 2 * at.x - from.x, y: 2 * at.y - from.y }) > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lead_all(edges: &[[(i32, i32); 2]]) -> Vec<Vec<(i32, i32)>> {
        let mut sorted: Vec<[Point; 2]> = edges.iter().map(|edge| edge.map(|(x, y)| Point { x, y })).collect();
        sorted.sort_unstable_by_key(|edge| edge.map(|at| (at.y, at.x)));
        lead(sorted.into_iter()).into_iter().map(|l| l.into_iter().map(|at| (at.x, at.y)).collect()).collect()
    }

    #[test]
    fn loops_turn_as_far_left_as_they_can() {
        let ring = |places: &[(i32, i32)]| -> Vec<[(i32, i32); 2]> {
            places.iter().zip(places.iter().cycle().skip(1)).map(|(p, q)| [*p, *q]).collect()
        };
        // Two squares that touch at a corner, ground inside: each is a loop, wherever one begins.
        let (a, b) = ([(0, 0), (4, 0), (4, 4), (0, 4)], [(4, 4), (8, 4), (8, 8), (4, 8)]);
        let found = lead_all(&[ring(&a), ring(&b)].concat());
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
        // Two holes that touch, in a square: they are one loop around.
        let outer = [(-9, -9), (20, -9), (20, 20), (-9, 20)];
        let (a, b) = ([(0, 0), (0, 4), (4, 4), (4, 0)], [(4, 4), (4, 8), (8, 8), (8, 4)]);
        let found = lead_all(&[ring(&outer), ring(&a), ring(&b)].concat());
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [4, 8]);
    }
}
