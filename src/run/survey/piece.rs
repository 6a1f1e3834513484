//! Some rows of samples, surveyed by one thread.

use rayon::prelude::*;

use super::SIGNED;
use super::grid::MapCell;
use super::histogram::Histogram;
use super::slopes::{Class, FROM, Slopes};
use crate::verify::ObservedRows;

/// Samples of a piece, about.
const SAMPLES: usize = 1 << 15;

/// What errors are held against.
pub(super) struct Measure {
    pub(super) tolerance: f64,
    pub(super) slopes: Slopes,
}

/// What some rows come to.
pub(super) struct Piece {
    pub(super) histogram: Histogram,
    pub(super) signed: Vec<u64>,
    pub(super) sum: f64,
    pub(super) largest: f64,
    pub(super) near: u64,
    pub(super) classes: [Class; FROM.len()],
    /// The squares of the map that the rows go through, row by row.
    pub(super) cells: Vec<MapCell>,
}

impl Piece {
    /// The pieces of these rows, each with its first row, in order; `above` are the heights of the row above the first one, or
    /// none, and `side` samples make the side of a square of the map.
    pub(super) fn all_of(
        rows: &ObservedRows<'_>,
        above: &[f64],
        measure: &Measure,
        side: usize,
    ) -> Vec<(usize, Piece)> {
        let (width, count) = (rows.width, rows.heights.len() / rows.width);
        let down = (SAMPLES / width).max(1);
        let piece = |index: usize| {
            let range = index * down..((index + 1) * down).min(count);
            let first = rows.first_row + range.start;
            let squares = (first + range.len() - 1) / side - first / side + 1;
            let mut piece = Piece::new(measure.tolerance, squares * width.div_ceil(side));
            for at in range {
                // The first row of all takes its own heights for those above it, and has no slope along columns.
                let above = match at {
                    0 if above.is_empty() => &rows.heights[..width],
                    0 => above,
                    _ => &rows.heights[(at - 1) * width..at * width],
                };
                piece.take(rows, at, above, measure, (first / side, side));
            }
            (first, piece)
        };
        (0..count.div_ceil(down)).into_par_iter().map(piece).collect()
    }

    fn new(tolerance: f64, cells: usize) -> Piece {
        Piece {
            histogram: Histogram::new(tolerance),
            signed: vec![0; 2 * SIGNED + 2],
            sum: 0.0,
            largest: 0.0,
            near: 0,
            classes: [Class::default(); FROM.len()],
            cells: vec![MapCell::default(); cells],
        }
    }

    /// Adds a row; the first squares of the piece are those of this row of squares.
    fn take(
        &mut self,
        rows: &ObservedRows<'_>,
        at: usize,
        above: &[f64],
        measure: &Measure,
        (first_square, side): (usize, usize),
    ) {
        let (width, row) = (rows.width, rows.first_row + at);
        let start = at * width;
        let heights = &rows.heights[start..start + width];
        let errors = &rows.errors[start..start + width];
        let cell_size = measure.slopes.cell(row);
        let across = width.div_ceil(side);
        let cells = &mut self.cells[(row / side - first_square) * across..][..across];
        let (tolerance, nearly) = (measure.tolerance, 0.9 * measure.tolerance);
        let per_error = if tolerance > 0.0 { SIGNED as f64 / tolerance } else { 0.0 };
        for (square, cell) in cells.iter_mut().enumerate() {
            for column in square * side..((square + 1) * side).min(width) {
                let (height, error) = (heights[column], errors[column]);
                if height.is_nan() {
                    continue;
                }
                cell.heights += 1;
                cell.sum += height;
                if error.is_nan() {
                    continue;
                }
                let distance = error.abs();
                let counted = rows.weights.map_or(distance, |weights| distance * weights[start + column]);
                let is_above = rows.is_above(start + column);
                cell.measured += 1;
                cell.max = cell.max.max(counted as f32);
                let is_near = is_above || counted > nearly;
                cell.near += u32::from(is_near);
                cell.above += u32::from(is_above);
                self.near += u64::from(is_near);
                self.histogram.count(counted);
                self.sum += error;
                self.largest = self.largest.max(counted);
                self.signed[signed_bin(error, tolerance, per_error)] += 1;
                let neighbour = |there: bool, column: usize| if there { heights[column] } else { f64::NAN };
                let (left, right) =
                    (neighbour(column > 0, column.wrapping_sub(1)), neighbour(column + 1 < width, column + 1));
                if let Some(class) = measure.slopes.class(cell_size, height, [left, right, above[column]]) {
                    let class = &mut self.classes[class];
                    class.samples += 1;
                    class.above += u64::from(is_above);
                    class.max = class.max.max(distance);
                    class.squares += distance * distance;
                }
            }
        }
    }
}

/// The bin of a signed error: below −ε, [`SIGNED`] bins up to 0, as many up to ε, above it.
#[inline(always)]
fn signed_bin(error: f64, tolerance: f64, per_error: f64) -> usize {
    if error > tolerance {
        return 2 * SIGNED + 1;
    }
    if error < -tolerance {
        return 0;
    }
    let steps = (error * per_error).floor() as isize;
    (1 + SIGNED as isize + steps).clamp(1, 2 * SIGNED as isize) as usize
}
