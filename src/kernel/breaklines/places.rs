//! Lines cut at rows and columns of samples, every place rounded to the lattice.
//!
//! Vertices are read to 1/65536 of a cell, so all that follows is exact in whole numbers. Where a line crosses a column, its place is
//! rounded along the column, and so for rows: both ends of a piece lie in the closed cell that the piece is in.

use super::{FINE, LineCounts, LinesError, Place, Segment};
use crate::base::Polylines;
use crate::base::lattice::STEPS;

/// Parts of a lattice step that vertices are read in.
const FINE_STEP: i64 = FINE / STEPS as i64;

/// A place in parts of a cell.
type Fine = (i64, i64);

/// The segments of all lines that lie in the rectangle of this many samples, in no order, and what became of the lines.
pub(super) fn segments(
    lines: &Polylines,
    (width, height): (usize, usize),
) -> Result<(Vec<Segment>, LineCounts), LinesError> {
    let mut walk =
        Walk { last: (width as i64 - 1, height as i64 - 1), largest: 0.0, segments: Vec::new(), before: None };
    let mut counts = LineCounts { lines: lines.lines().len() as u64, ..LineCounts::default() };
    for line in lines.lines() {
        let found = walk.segments.len();
        walk.before = None;
        for (i, &vertex) in line.iter().enumerate() {
            let b = fine(vertex)?;
            if let Some(&a) = i.checked_sub(1).and_then(|i| line.get(i)) {
                walk.cross(fine(a)?, b);
            }
            walk.visit(b);
            if walk.segments.len() > Polylines::MAX_SEGMENTS {
                return Err(LinesError::TooMany);
            }
        }
        counts.left_out += u64::from(walk.segments.len() == found);
    }
    counts.largest_rounding = walk.largest / FINE as f64;
    Ok((walk.segments, counts))
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
    segments: Vec<Segment>,
    before: Option<Place>,
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
    fn visit(&mut self, (x, y): Fine) {
        let step = |v: i64| (v + FINE_STEP / 2).div_euclid(FINE_STEP);
        let place = Place { y: step(y), x: step(x) };
        if self.has(place) {
            let (dx, dy) = (place.x * FINE_STEP - x, place.y * FINE_STEP - y);
            self.largest = self.largest.max((dx as f64).hypot(dy as f64));
        }
        self.go(place);
    }

    fn has(&self, place: Place) -> bool {
        let steps = i64::from(STEPS);
        (0..=self.last.0 * steps).contains(&place.x) && (0..=self.last.1 * steps).contains(&place.y)
    }

    fn go(&mut self, place: Place) {
        if let Some(before) = self.before.replace(place)
            && before != place
            && self.has(before)
            && self.has(place)
        {
            self.segments.push([before.min(place), before.max(place)]);
        }
    }

    /// All crossings of a straight line with rows and columns of the raster, in their order.
    fn cross(&mut self, a: Fine, b: Fine) {
        let mut columns = crossings((a.0, a.1), (b.0, b.1), self.last.0).peekable();
        let mut rows = crossings((a.1, a.0), (b.1, b.0), self.last.1).peekable();
        loop {
            let column_first = match (columns.peek(), rows.peek()) {
                (Some(c), Some(r)) => c.done * r.all <= r.done * c.all,
                (Some(_), None) => true,
                (None, Some(_)) => false,
                (None, None) => return,
            };
            let next = if column_first { columns.next() } else { rows.next() };
            let Some(Crossing { line, along, rounding, .. }) = next else { return };
            let place = if column_first { Place { y: along, x: line } } else { Place { y: line, x: along } };
            if self.has(place) {
                self.largest = self.largest.max(rounding);
            }
            self.go(place);
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
