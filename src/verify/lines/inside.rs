//! Outlines that the mesh is to end at: what lies inside of them.
//!
//! In every quarter row, each polygon is what lies between an odd side of it and the next; the inside is what any polygon covers. Sides
//! neither begin nor end there, nor do they cross each other, so they are in one order all the way down.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use super::Spot;
use crate::verify::crossing::{Crossing, Side, Span};

/// A side of an outline, the upper end first.
type Edge = [Spot; 2];

/// The inside of all polygons. Memory: some 100 bytes for each quarter row that a side passes.
#[derive(Debug)]
pub(in crate::verify) struct Inside {
    /// By quarter rows, from the left to the right, none of which touch each other along a side.
    spans: BTreeMap<i64, Vec<(Edge, Edge)>>,
    /// Cells that the border comes into, by column and row; none of the raster's rim.
    crossed: BTreeSet<(i64, i64)>,
    /// The last column and row.
    last: (i64, i64),
}

/// In the middle of a quarter row, twice as far from the first column as it is.
fn middle([(ax, ay), (bx, by)]: Edge, row: i64) -> Crossing {
    Crossing::of((2 * ax, 2 * ay), (2 * bx, 2 * by), 2 * row + 1)
}

/// Within a quarter row.
fn side([a, b]: Edge, row: i64) -> Side {
    let at = |line: i64| Crossing::of(a, b, line);
    Side { top: at(row), bottom: at(row + 1) }
}

impl Inside {
    /// Of sides that are odd, each with the number of its polygon, over a raster with this last column and row.
    pub(super) fn new(sides: &[(Edge, usize)], last: (i64, i64)) -> Inside {
        let mut by_polygon: BTreeMap<(i64, usize), Vec<Edge>> = BTreeMap::new();
        for &(edge, polygon) in sides {
            for row in edge[0].1..edge[1].1 {
                by_polygon.entry((row, polygon)).or_default().push(edge);
            }
        }
        let mut all: BTreeMap<i64, Vec<(Edge, Edge)>> = BTreeMap::new();
        for ((row, _), mut edges) in by_polygon {
            edges.sort_by_key(|&edge| middle(edge, row));
            all.entry(row).or_default().extend(edges.chunks_exact(2).map(|pair| (pair[0], pair[1])));
        }
        let union = |(row, mut spans): (i64, Vec<(Edge, Edge)>)| {
            spans.sort_by_key(|(left, _)| middle(*left, row));
            let mut joined: Vec<(Edge, Edge)> = Vec::new();
            for (left, right) in spans {
                match joined.last_mut() {
                    Some((_, end)) if middle(left, row) <= middle(*end, row) => {
                        if middle(*end, row) < middle(right, row) {
                            *end = right;
                        }
                    }
                    _ => joined.push((left, right)),
                }
            }
            (row, joined)
        };
        let spans = all.into_iter().map(union).collect();
        let mut inside = Inside { spans, crossed: BTreeSet::new(), last };
        let border = sides.iter().map(|(edge, _)| *edge).filter(|&edge| inside.is_border(edge));
        inside.crossed = border.flat_map(super::heights::cells).collect();
        inside
    }

    fn of_row(&self, row: i64) -> &[(Edge, Edge)] {
        self.spans.get(&row).map_or(&[], Vec::as_slice)
    }

    /// Whether a segment is where the mesh is to end, other than at the raster's rim.
    pub(super) fn is_border(&self, edge: Edge) -> bool {
        let [a, b] = edge;
        let is_on_rim =
            a.0 == b.0 && [0, 4 * self.last.0].contains(&a.0) || a.1 == b.1 && [0, 4 * self.last.1].contains(&a.1);
        let [before, after] = self.beside(edge);
        before != after && !is_on_rim
    }

    /// Whether it is inside before and after a segment: to the left and right of it, or above and below where it is level.
    fn beside(&self, [a, b]: Edge) -> [bool; 2] {
        if a.1 == b.1 {
            let x = Crossing::of((a.0, 0), (b.0, 2), 1);
            let covers = |row: i64, line: fn(&Side) -> Crossing| {
                let covers =
                    |&(left, right): &(Edge, Edge)| line(&side(left, row)) <= x && x <= line(&side(right, row));
                // What ends in a point on the line covers none of the segment.
                self.of_row(row).iter().any(|part| covers(part) && line(&side(part.0, row)) < line(&side(part.1, row)))
            };
            return [covers(a.1 - 1, |side| side.bottom), covers(a.1, |side| side.top)];
        }
        let x = middle([a, b], a.1);
        let mut found = [false; 2];
        for &(left, right) in self.of_row(a.1) {
            let (from, to) = (middle(left, a.1), middle(right, a.1));
            found[0] |= from < x && x <= to;
            found[1] |= from <= x && x < to;
        }
        found
    }

    /// Whether a segment asks for an edge by the ground in one of the cells that hold it: there it is inside beside the segment.
    pub(super) fn asks(&self, edge: Edge, (column, row): (i64, i64)) -> bool {
        let [before, after] = self.beside(edge);
        let [a, b] = edge;
        // Twice a cell's middle against a segment along a side of it.
        let is_after = match (a.0 == b.0 && a.0 % 4 == 0, a.1 == b.1 && a.1 % 4 == 0) {
            (true, _) => 4 * column >= a.0,
            (_, true) => 4 * row >= a.1,
            _ => return before || after,
        };
        if is_after { after } else { before }
    }

    /// Whether the border comes into a cell, so that half of it is no ground.
    pub(in crate::verify) fn crosses(&self, cell: (i64, i64)) -> bool {
        self.crossed.contains(&cell)
    }

    /// What of some spans of ground is inside, in a quarter row.
    pub(in crate::verify) fn clip(&self, row: i64, ground: &[Span]) -> Vec<Span> {
        let mut clipped = Vec::new();
        let mut ground = ground.iter().peekable();
        for &(left, right) in self.of_row(row) {
            let (left, right) = (side(left, row), side(right, row));
            while ground.next_if(|span| span.right.is_left_of(&left)).is_some() {}
            while let Some(span) = ground.peek().filter(|span| !right.is_left_of(&span.left)) {
                let part = Span { left: left.max(span.left), right: right.min(span.right) };
                clipped.push(part);
                if !span.right.is_left_of(&right) {
                    break;
                }
                ground.next();
            }
        }
        clipped
    }

    /// The samples of some rows that are inside or on the border: row, columns. Some may be there twice.
    pub(in crate::verify) fn samples(&self, rows: Range<i64>) -> impl Iterator<Item = (i64, Range<i64>)> {
        let lines = rows.flat_map(|row| [(row, 4 * row - 1), (row, 4 * row)]);
        lines.flat_map(move |(row, quarter)| {
            let at = move |edge: Edge| Crossing::of(edge[0], edge[1], 4 * row);
            let columns = move |&(left, right): &(Edge, Edge)| {
                let (from, to) = (at(left), at(right));
                let first = (from.whole + i64::from(from > Crossing::at(from.whole)) + 3).div_euclid(4);
                (row, first..to.whole.div_euclid(4) + 1)
            };
            self.of_row(quarter).iter().map(columns)
        })
    }
}
