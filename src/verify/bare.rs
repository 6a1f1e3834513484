//! Ground that no face covers, and what it borders on.

use super::crossing::{Crossing, Side, Span};
use super::finding::{Finding, MapPlace};
use super::grid::{Grid, STEPS};
use super::joins::Joins;

/// A piece of bare ground within a quarter row, and its region's number.
#[derive(Debug, Clone, Copy)]
struct Piece {
    span: Span,
    region: usize,
}

/// A region of bare ground, as far as the quarter rows have passed.
#[derive(Debug)]
struct Region {
    /// Where it is met first: row, column in lattice steps.
    first: (i64, i64),
    /// Whether it borders on what is no ground.
    is_open: bool,
}

impl Region {
    fn absorb(&mut self, other: Region) {
        self.first = self.first.min(other.first);
        self.is_open |= other.is_open;
    }
}

/// Regions of bare ground from the first quarter row to the last: each is to border on what is no ground, along a side.
///
/// Memory use is that of the pieces of two quarter rows, 150 bytes each.
#[derive(Debug)]
pub(super) struct Bare {
    grid: Grid,
    pieces: Vec<Piece>,
    regions: Vec<Region>,
    /// Where there is no ground just above, or nothing where that is not asked.
    beyond: Vec<(Crossing, Crossing)>,
    /// Whether the quarter row above was found faulty: what bordered on it is not judged.
    is_unknown: bool,
    enclosed: u64,
    first: Option<(i64, i64)>,
}

impl Bare {
    pub(super) fn new(grid: Grid) -> Bare {
        let beyond = beyond(&grid, &[], |side| side.bottom);
        let (pieces, regions) = (Vec::new(), Vec::new());
        Bare { grid, pieces, regions, beyond, is_unknown: false, enclosed: 0, first: None }
    }

    /// The regions that faces enclose.
    pub(super) fn enclosed(&self) -> Finding<MapPlace> {
        Finding { count: self.enclosed, first: self.first.map(|(y, x)| self.grid.map((x, y))) }
    }

    /// Takes the next quarter row, whose faces are within its ground.
    pub(super) fn pass(&mut self, y: i64, ground: &[Span], mesh: &[Span]) {
        let mut joins = Joins::new(std::mem::take(&mut self.regions));
        let mut pieces = Vec::new();
        let mut mesh = mesh.iter().peekable();
        for span in ground {
            let mut left = span.left;
            let mut add = |left: Side, right: Side| {
                if left != right {
                    let is_open = left == span.left || right == span.right || self.is_unknown;
                    let region = joins.add(Region { first: (y, left.top.whole), is_open });
                    pieces.push(Piece { span: Span { left, right }, region });
                }
            };
            while let Some(covered) = mesh.next_if(|covered| covered.right.is_left_of(&span.right)) {
                add(left, covered.left);
                left = covered.right;
            }
            add(left, span.right);
        }
        self.join(y, &mut joins, &pieces, ground);
        self.end(joins, pieces);
        // Within a row of cells the ground's sides go on: nothing borders on what is beyond across a line.
        self.beyond = match (y + 1) % STEPS {
            0 => beyond(&self.grid, ground, |side| side.bottom),
            _ => Vec::new(),
        };
        self.is_unknown = false;
    }

    /// The next quarter row is faulty.
    pub(super) fn pass_unknown(&mut self) {
        (self.pieces, self.regions, self.beyond) = (Vec::new(), Vec::new(), Vec::new());
        self.is_unknown = true;
    }

    /// Nothing comes any more.
    pub(super) fn finish(&mut self, y: i64) {
        let mut joins = Joins::new(std::mem::take(&mut self.regions));
        self.join(y, &mut joins, &[], &[]);
        self.end(joins, Vec::new());
    }

    /// Joins the pieces to those above them, and finds those that border, above or below, on what is no ground.
    fn join(&mut self, y: i64, joins: &mut Joins<Region>, pieces: &[Piece], ground: &[Span]) {
        let above: Vec<_> = self.pieces.iter().map(|p| (p.span.left.bottom, p.span.right.bottom)).collect();
        let below: Vec<_> = pieces.iter().map(|p| (p.span.left.top, p.span.right.top)).collect();
        for (a, b) in overlaps(&above, &below) {
            joins.join(self.pieces[a].region, pieces[b].region, Region::absorb);
        }
        if y % STEPS == 0 {
            for (a, _) in overlaps(&above, &beyond(&self.grid, ground, |side| side.top)) {
                joins.group(self.pieces[a].region).is_open = true;
            }
            for (_, b) in overlaps(&self.beyond, &below) {
                joins.group(pieces[b].region).is_open = true;
            }
        }
    }

    fn end(&mut self, joins: Joins<Region>, mut pieces: Vec<Piece>) {
        let (going_on, ended) = joins.end(pieces.iter_mut().map(|p| &mut p.region));
        for region in ended.into_iter().filter(|region| !region.is_open) {
            self.enclosed += 1;
            self.first = Some(self.first.map_or(region.first, |first| first.min(region.first)));
        }
        (self.pieces, self.regions) = (pieces, going_on);
    }
}

/// Where a line runs through no ground.
fn beyond(grid: &Grid, ground: &[Span], line: impl Fn(&Side) -> Crossing) -> Vec<(Crossing, Crossing)> {
    let lefts = std::iter::once(Crossing::at(-1)).chain(ground.iter().map(|span| line(&span.right)));
    let outside = Crossing::at(grid.far_corner().0 + 1);
    let rights = ground.iter().map(|span| line(&span.left)).chain([outside]);
    lefts.zip(rights).collect()
}

/// Pairs of intervals of two rows of them that have more than a point in common.
fn overlaps(above: &[(Crossing, Crossing)], below: &[(Crossing, Crossing)]) -> Vec<(usize, usize)> {
    let (mut a, mut b, mut pairs) = (0, 0, Vec::new());
    while a < above.len() && b < below.len() {
        if above[a].0.max(below[b].0) < above[a].1.min(below[b].1) {
            pairs.push((a, b));
        }
        if above[a].1 <= below[b].1 { a += 1 } else { b += 1 }
    }
    pairs
}
