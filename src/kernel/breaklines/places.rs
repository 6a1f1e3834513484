//! Lines cut at rows and columns of samples, every place rounded to the lattice.
//!
//! Vertices are read to 1/65536 of a cell, so all that follows is exact in whole numbers. Where a line crosses a column, its place is
//! rounded along the column, and so for rows: both ends of a piece lie in the closed cell that the piece is in.
//!
//! Where lines have heights of their own, those between two vertices are on a straight line, in double precision: h + (k − h) · t from
//! the vertex that comes first by rows, then by columns, with t the share of the way, a quotient of whole numbers. Of several that
//! a line has at one place one after the other, the first counts.

use super::pieces::{Piece, part_way};
use super::{FINE, LineCounts, LinesError, Place};
use crate::base::exact::MAX_HEIGHT;
use crate::base::lattice::STEPS;
use crate::base::{LineKind, Polylines};

/// Parts of a lattice step that vertices are read in.
const FINE_STEP: i64 = FINE / STEPS as i64;

/// A place in parts of a cell.
type Fine = (i64, i64);

/// Pieces handed on at a time.
const AT_A_TIME: usize = 1 << 12;

/// Hands on the pieces of lines of a set that lie in the rectangle of this many samples, in no order, and adds what became of the lines.
/// They are told with the number of the first, and with the features of all by number. `take` empties what it is given.
pub(super) fn cut<E: From<LinesError>>(
    (number, kind): (u8, LineKind),
    lines: &Polylines,
    (first, feature): (usize, &dyn Fn(usize) -> u64),
    (width, height): (usize, usize),
    counts: &mut LineCounts,
    take: &mut dyn FnMut(&mut Vec<Piece>) -> Result<(), E>,
) -> Result<(), E> {
    let mut walk = Walk {
        last: (width as i64 - 1, height as i64 - 1),
        largest: 0.0,
        of: (number, 0),
        pieces: Vec::new(),
        found: 0,
        before: None,
        is_closed: kind.has_inside(),
    };
    for (i, line) in lines.lines().iter().enumerate() {
        let found = walk.found;
        let heights = lines.heights().map(|heights| heights[i].as_slice());
        // Lines without heights are as one, but for what they bound.
        walk.of.1 = if heights.is_some() || kind == LineKind::Cutline { (first + i) as u32 } else { 0 };
        walk.before = None;
        let mut last: Option<Corner> = None;
        // What has an inside ends where it begins.
        let closing = line.first().filter(|first| kind.has_inside() && line.last() != Some(first));
        for (j, &vertex) in line.iter().chain(closing).enumerate() {
            let height = heights.map_or(0.0, |heights| heights[j % line.len()]);
            if height.is_nan() || height.abs() > MAX_HEIGHT {
                return Err(LinesError::Height { feature: feature(first + i), height }.into());
            }
            let b = Corner { at: fine(vertex)?, height };
            if let Some(a) = last.replace(b) {
                walk.cross(a, b);
            }
            walk.visit(b);
            if walk.pieces.len() > AT_A_TIME {
                take(&mut walk.pieces)?;
            }
        }
        counts.left_out += u64::from(walk.found == found);
    }
    counts.largest_rounding = counts.largest_rounding.max(walk.largest / FINE as f64);
    take(&mut walk.pieces)
}

/// A vertex of a line.
#[derive(Clone, Copy)]
struct Corner {
    at: Fine,
    height: f64,
}

fn fine((column, row): (f64, f64)) -> Result<Fine, LinesError> {
    let is_near = column.abs() <= Polylines::FARTHEST && row.abs() <= Polylines::FARTHEST;
    let part = |v: f64| (v * FINE as f64).round() as i64;
    if is_near { Ok((part(column), part(row))) } else { Err(LinesError::TooFar { column, row }) }
}

/// Walks along a line from place to place.
struct Walk {
    /// The last column and row.
    last: (i64, i64),
    /// The largest distance from a place to the lattice, in parts of a cell.
    largest: f64,
    /// The number of the set, and that of the line in it.
    of: (u8, u32),
    pieces: Vec<Piece>,
    /// How many pieces were found.
    found: u64,
    before: Option<(Place, f64)>,
    /// Whether what lies outside of the raster is drawn to its rim, so that it is known what is inside of outlines.
    is_closed: bool,
}

/// A crossing with a line of one family: its share of the way as a fraction, the line and the place along it in lattice steps, and
/// how far that is rounded.
#[derive(Clone, Copy)]
struct Crossing {
    done: i128,
    all: i128,
    line: i64,
    along: i64,
    rounding: f64,
}

impl Walk {
    /// A vertex.
    fn visit(&mut self, Corner { at: (x, y), height }: Corner) {
        let step = |v: i64| (v + FINE_STEP / 2).div_euclid(FINE_STEP);
        let place = Place { y: step(y), x: step(x) };
        if self.has(place) {
            let (dx, dy) = (place.x * FINE_STEP - x, place.y * FINE_STEP - y);
            self.largest = self.largest.max((dx as f64).hypot(dy as f64));
        }
        self.go(place, height);
    }

    fn has(&self, place: Place) -> bool {
        let steps = i64::from(STEPS);
        (0..=self.last.0 * steps).contains(&place.x) && (0..=self.last.1 * steps).contains(&place.y)
    }

    fn go(&mut self, place: Place, height: f64) {
        let last = [self.last.0, self.last.1].map(|last| last * i64::from(STEPS));
        let place = match self.is_closed {
            true => Place { y: place.y.clamp(0, last[1]), x: place.x.clamp(0, last[0]) },
            false => place,
        };
        match self.before {
            Some((before, _)) if before == place => return,
            Some((before, height_before)) if self.has(before) && self.has(place) => {
                self.pieces.push(Piece::new(self.of, [(before, height_before), (place, height)]));
                self.found += 1;
            }
            _ => {}
        }
        self.before = Some((place, height));
    }

    /// All crossings of a straight line with rows and columns of the raster, in their order.
    fn cross(&mut self, from: Corner, to: Corner) {
        let (a, b) = (from.at, to.at);
        let mut columns = crossings((a.0, a.1), (b.0, b.1), self.last.0).peekable();
        let mut rows = crossings((a.1, a.0), (b.1, b.0), self.last.1).peekable();
        let is_turned = (b.1, b.0) < (a.1, a.0);
        let height = |done: i128, all: i128| match is_turned {
            false => part_way([from.height, to.height], done, all),
            true => part_way([to.height, from.height], all - done, all),
        };
        loop {
            let column_first = match (columns.peek(), rows.peek()) {
                (Some(c), Some(r)) => c.done * r.all <= r.done * c.all,
                (Some(_), None) => true,
                (None, Some(_)) => false,
                (None, None) => return,
            };
            let next = if column_first { columns.next() } else { rows.next() };
            let Some(Crossing { line, along, rounding, done, all }) = next else { return };
            let place = if column_first { Place { y: along, x: line } } else { Place { y: line, x: along } };
            if self.has(place) {
                self.largest = self.largest.max(rounding);
            }
            self.go(place, height(done, all));
        }
    }
}

/// Where a straight line crosses lines of one family, in its order. Coordinates are across the lines, then along them; `last` is
/// the number of the last line.
fn crossings((ax, ay): Fine, (bx, by): Fine, last: i64) -> impl Iterator<Item = Crossing> {
    let first = (ax.min(bx) + FINE - 1).div_euclid(FINE).max(0);
    let after = if ax == bx { first } else { (ax.max(bx).div_euclid(FINE).min(last) + 1).max(first) };
    (0..after - first).map(move |i| {
        let line = if ax < bx { first + i } else { after - 1 - i };
        let (done, all) = (i128::from((line * FINE - ax).abs()), i128::from((bx - ax).abs()));
        let step = i128::from(FINE_STEP) * all;
        let at = i128::from(ay) * all + done * i128::from(by - ay);
        let along = (at + step / 2).div_euclid(step);
        let rounding = (at - along * step).abs() as f64 / all as f64;
        Crossing { done, all, line: line * i64::from(STEPS), along: along as i64, rounding }
    })
}
