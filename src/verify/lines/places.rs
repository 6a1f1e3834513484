//! A line's places: its vertices, and where it crosses rows and columns.

use super::Spot;
use crate::base::Polylines;
use crate::verify::VerifyError;

/// Parts of a cell that vertices are read in, and of a quarter of one.
const PARTS: i128 = 1 << 16;
const QUARTER: i128 = PARTS / 4;

/// The pieces between consecutive places of all lines, as far as both lie in the rectangle of this many samples. A piece may be there
/// more than once.
pub(super) fn cut(lines: &Polylines, (width, height): (i64, i64)) -> Result<Vec<[Spot; 2]>, VerifyError> {
    let mut pieces = Vec::new();
    let is_inside = |(x, y): Spot| (0..=4 * (width - 1)).contains(&x) && (0..=4 * (height - 1)).contains(&y);
    for line in lines.lines() {
        let corners = line.iter().map(|&corner| read(corner)).collect::<Result<Vec<_>, _>>()?;
        let mut spots: Vec<Spot> = Vec::new();
        for (i, &corner) in corners.iter().enumerate() {
            if i > 0 {
                between(corners[i - 1], corner, (width, height), &mut spots);
            }
            spots.push((quarters(corner.0, 1), quarters(corner.1, 1)));
            let both = spots.windows(2).map(|pair| [pair[0], pair[1]]);
            pieces.extend(both.filter(|[p, q]| p != q && is_inside(*p) && is_inside(*q)));
            spots.drain(..spots.len() - 1);
            if pieces.len() > Polylines::MAX_SEGMENTS {
                return Err(VerifyError::ManyLines);
            }
        }
    }
    Ok(pieces)
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
fn between(a: (i128, i128), b: (i128, i128), (width, height): (i64, i64), spots: &mut Vec<Spot>) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    // Shares of the way over one denominator.
    let mut crossings: Vec<(i128, Spot)> = Vec::new();
    let lines = |from: i128, to: i128, count: i64| {
        let (low, high) = (from.min(to), from.max(to));
        let first = -(-low).div_euclid(PARTS);
        first.max(0)..=high.div_euclid(PARTS).min(i128::from(count) - 1)
    };
    if dx != 0 {
        for column in lines(a.0, b.0, width) {
            let run = column * PARTS - a.0;
            let y = quarters((a.1 * dx + dy * run) * dx.signum(), dx.abs());
            crossings.push((run.abs() * dy.abs().max(1), (4 * column as i64, y)));
        }
    }
    if dy != 0 {
        for row in lines(a.1, b.1, height) {
            let run = row * PARTS - a.1;
            let x = quarters((a.0 * dy + dx * run) * dy.signum(), dy.abs());
            crossings.push((run.abs() * dx.abs().max(1), (x, 4 * row as i64)));
        }
    }
    crossings.sort_by_key(|(share, _)| *share);
    spots.extend(crossings.into_iter().map(|(_, spot)| spot));
}
