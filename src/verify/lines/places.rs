//! A line's places: its vertices, and where it crosses rows and columns.

use super::Spot;
use super::pieces::{Piece, between};
use crate::base::exact::MAX_HEIGHT;
use crate::base::{LineKind, LineSet, Polylines};
use crate::verify::VerifyError;

/// The most pieces between rows and columns of outlines that have an inside, which are held in memory: some 15 GiB.
pub(in crate::verify) const MAX_SEGMENTS: u64 = 64_000_000;

/// Parts of a cell that vertices are read in, and of a quarter of one.
const PARTS: i128 = 1 << 16;
const QUARTER: i128 = PARTS / 4;

/// A place, and the line's own height there; 0 where it has none.
type Level = (Spot, f64);

/// Hands on the pieces between consecutive places of all lines of a set, as far as both lie in the rectangle of this many samples. A
/// piece may be there more than once.
pub(super) fn cut(
    (number, set): (usize, &LineSet),
    size: (i64, i64),
    take: &mut dyn FnMut(Piece) -> Result<(), VerifyError>,
) -> Result<(), VerifyError> {
    let mut count = 0;
    let mut counting = |piece| {
        count += 1;
        if set.kind.has_inside() && count > MAX_SEGMENTS { Err(VerifyError::ManyLines) } else { take(piece) }
    };
    for some in set.lines.pieces() {
        let (first, lines) = some?;
        cut_some((number, set), (first, &lines), size, &mut counting)?;
    }
    Ok(())
}

/// Those of some lines of the set, the number of the first of which is given.
fn cut_some(
    (number, set): (usize, &LineSet),
    (first, lines): (usize, &Polylines),
    size: (i64, i64),
    take: &mut dyn FnMut(Piece) -> Result<(), VerifyError>,
) -> Result<(), VerifyError> {
    let (width, rows) = size;
    // Of what has an inside, what lies outside is drawn to the raster's rim: outlines stay closed.
    let drawn = |(x, y): Spot| match set.kind {
        LineKind::Lakes | LineKind::Cutline => (x.max(0).min(4 * (width - 1)), y.max(0).min(4 * (rows - 1))),
        LineKind::Breaklines | LineKind::Footprints => (x, y),
    };
    let is_inside = |(x, y): Spot| (0..=4 * (width - 1)).contains(&x) && (0..=4 * (rows - 1)).contains(&y);
    for (i, line) in lines.lines().iter().enumerate() {
        let own = lines.heights().map(|heights| &heights[i]);
        let i = first + i;
        let of = (number, if own.is_some() || set.kind == LineKind::Cutline { i } else { 0 });
        let height = |j: usize| own.map_or(0.0, |own| own[j % line.len()]);
        if let Some(height) = (0..line.len()).map(height).find(|height| height.is_nan() || height.abs() > MAX_HEIGHT) {
            return Err(VerifyError::LineHeight { feature: set.lines.feature(i), height });
        }
        // An outline that has an inside comes back to where it began.
        let back = line.first().filter(|first| set.kind.has_inside() && line.last() != Some(first));
        let corners = line.iter().chain(back).map(|&corner| read(corner)).collect::<Result<Vec<_>, _>>()?;
        let mut spots: Vec<Level> = Vec::new();
        for (j, &corner) in corners.iter().enumerate() {
            if j > 0 {
                crossings([(corners[j - 1], height(j - 1)), (corner, height(j))], size, &mut spots);
            }
            spots.push(((quarters(corner.0, 1), quarters(corner.1, 1)), height(j)));
            spots.iter_mut().for_each(|(spot, _)| *spot = drawn(*spot));
            // Of several levels at one place the first counts.
            spots.dedup_by_key(|(spot, _)| *spot);
            let both = spots.windows(2).map(|pair| (pair[0], pair[1]));
            both.filter(|(p, q)| is_inside(p.0) && is_inside(q.0)).try_for_each(|(p, q)| take(Piece::new(of, p, q)))?;
            spots.drain(..spots.len() - 1);
        }
    }
    Ok(())
}

/// A vertex in parts of a cell.
fn read((column, row): (f64, f64)) -> Result<(i128, i128), VerifyError> {
    if column.abs().max(row.abs()) > Polylines::FARTHEST {
        return Err(VerifyError::FarLine { column, row });
    }
    let parts = |v: f64| (v * PARTS as f64).round() as i128;
    Ok((parts(column), parts(row)))
}

/// The whole number of quarter cells nearest to a fraction of parts; of two the larger.
fn quarters(over: i128, under: i128) -> i64 {
    let whole = QUARTER * under;
    ((2 * over + whole).div_euclid(2 * whole)) as i64
}

/// Adds where the way between two vertices crosses columns and rows.
fn crossings([(a, from), (b, to)]: [((i128, i128), f64); 2], (width, height): (i64, i64), spots: &mut Vec<Level>) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    // Heights are reckoned from the upper end, or from the left one.
    let level = |run: i128, all: i128| match dy < 0 || dy == 0 && dx < 0 {
        true => between((to, from), (all - run, all)),
        false => between((from, to), (run, all)),
    };
    // Shares of the way over one denominator.
    let mut crossings: Vec<(i128, Level)> = Vec::new();
    let lines = |from: i128, to: i128, count: i64| {
        let (low, high) = (from.min(to), from.max(to));
        let first = -(-low).div_euclid(PARTS);
        first.max(0)..=high.div_euclid(PARTS).min(i128::from(count) - 1)
    };
    if dx != 0 {
        for column in lines(a.0, b.0, width) {
            let run = column * PARTS - a.0;
            let y = quarters((a.1 * dx + dy * run) * dx.signum(), dx.abs());
            let level = level(run.abs(), dx.abs());
            crossings.push((run.abs() * dy.abs().max(1), ((4 * column as i64, y), level)));
        }
    }
    if dy != 0 {
        for row in lines(a.1, b.1, height) {
            let run = row * PARTS - a.1;
            let x = quarters((a.0 * dy + dx * run) * dy.signum(), dy.abs());
            let level = level(run.abs(), dy.abs());
            crossings.push((run.abs() * dx.abs().max(1), ((x, 4 * row as i64), level)));
        }
    }
    crossings.sort_by_key(|(share, _)| *share);
    spots.extend(crossings.into_iter().map(|(_, spot)| spot));
}
