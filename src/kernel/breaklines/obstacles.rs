//! What an edge of a chain must not touch: other lines, and edges that are there.

use std::collections::HashMap;
use std::ops::Range;

use crate::base::lattice::{Point, STEPS, dot, orient};

/// Segments of a tile by the closed cells that they touch.
#[derive(Debug, Default)]
pub(super) struct Obstacles {
    items: Vec<Item>,
    cells: HashMap<(i32, i32), Vec<u32>>,
}

#[derive(Debug, Clone, Copy)]
struct Item {
    ends: [Point; 2],
    /// Which piece of a line it is of, and its number in that.
    of: Option<(u32, u32)>,
}

impl Obstacles {
    /// Adds a segment of a piece, by its number in it; or something that is in nobody's way to itself.
    pub(super) fn add(&mut self, ends: [Point; 2], of: Option<(u32, u32)>) {
        let number = self.items.len() as u32;
        self.items.push(Item { ends, of });
        for_each_cell(ends, |cell| {
            self.cells.entry(cell).or_default().push(number);
            true
        });
    }

    /// Whether everything in a cell is a segment of this piece with a number that `is_near`.
    pub(super) fn is_own(&self, cell: (i32, i32), piece: u32, is_near: impl Fn(u32) -> bool) -> bool {
        let there = self.cells.get(&cell).map_or(&[][..], Vec::as_slice);
        let of = |&item: &u32| self.items[item as usize].of;
        there.iter().map(of).all(|of| of.is_some_and(|(of, number)| of == piece && is_near(number)))
    }

    /// Whether an edge touches nothing but at its own ends, apart from the stretch of a piece that it stands for.
    pub(super) fn let_pass(&self, edge: [Point; 2], piece: u32, stretch: Range<u32>) -> bool {
        let is_own = |item: &Item| item.of.is_some_and(|(of, number)| of == piece && stretch.contains(&number));
        for_each_cell(edge, |cell| {
            let there = self.cells.get(&cell).map_or(&[][..], Vec::as_slice);
            there.iter().map(|&i| &self.items[i as usize]).all(|item| is_own(item) || !touches(edge, item.ends))
        })
    }
}

/// Visits the closed cells that a segment touches, and perhaps some beside it, until `visit` says no; returns whether it never did.
pub(super) fn for_each_cell([a, b]: [Point; 2], mut visit: impl FnMut((i32, i32)) -> bool) -> bool {
    let (from, to) = if a.x <= b.x { (a, b) } else { (b, a) };
    let (dx, dy) = (i64::from(to.x - from.x), i64::from(to.y - from.y));
    for column in (from.x - 1).div_euclid(STEPS)..=to.x.div_euclid(STEPS) {
        let ends = [(column * STEPS).max(from.x), ((column + 1) * STEPS).min(to.x)];
        let (mut low, mut high) = (i64::from(from.y.min(to.y)), i64::from(from.y.max(to.y)));
        if dx > 0 {
            let [p, q] = ends.map(|x| i64::from(from.y) * dx + i64::from(x - from.x) * dy);
            (low, high) = (p.min(q).div_euclid(dx), (p.max(q) + dx - 1).div_euclid(dx));
        }
        let steps = i64::from(STEPS);
        for row in (low - 1).div_euclid(steps)..=high.div_euclid(steps) {
            if !visit((column, row as i32)) {
                return false;
            }
        }
    }
    true
}

/// Whether two closed segments have more in common than an end of both. Either may be a place.
pub(super) fn touches([a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let common = [c, d].into_iter().filter(|&p| p == a || p == b).count();
    if c == d {
        return common == 0 && is_on([a, b], c);
    }
    match common {
        2 => true,
        1 => {
            let (shared, other) = if c == a || c == b { (c, d) } else { (d, c) };
            let far = if shared == a { b } else { a };
            orient(shared, far, other) == 0 && dot(shared, far, other) > 0
        }
        _ => {
            let sides = |p, q, r, s| orient(p, q, r).signum() * orient(p, q, s).signum();
            let cross = sides(a, b, c, d) < 0 && sides(c, d, a, b) < 0;
            cross || is_on([a, b], c) || is_on([a, b], d) || is_on([c, d], a) || is_on([c, d], b)
        }
    }
}

/// Whether a place lies on a segment.
fn is_on([a, b]: [Point; 2], p: Point) -> bool {
    orient(a, b, p) == 0 && dot(p, a, b) <= 0
}
