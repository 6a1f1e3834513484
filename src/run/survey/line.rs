//! Rows that are counted: slopes and keys of their samples.

use super::columns::STRETCH;
use super::histogram::{Key, key};
use super::piece::{Measure, Piece};
use super::slopes::{Cell, NO_CLASS};
use crate::verify::ObservedRows;

/// Samples that are all less than this share of the tolerance off count in their class as they are.
const SMALL: f64 = 1.0 / 16.0;

/// Some rows.
pub(super) struct Block<'r> {
    pub(super) rows: &'r ObservedRows<'r>,
    /// The cells of each.
    pub(super) cells: &'r [Cell],
    pub(super) measure: &'r Measure,
    /// The side of a square of the map.
    pub(super) side: usize,
}

/// What samples are.
pub(super) struct Are {
    /// All have a height, a surface within the tolerance and a slope.
    pub(super) plain: bool,
    /// Some is too far off to count by itself.
    pub(super) large: bool,
}

/// A row that is counted.
#[derive(Clone, Copy)]
pub(super) struct Line<'r> {
    pub(super) rows: &'r ObservedRows<'r>,
    pub(super) measure: &'r Measure,
    pub(super) side: usize,
    /// Which it is, and where it begins in `rows`.
    pub(super) row: usize,
    pub(super) start: usize,
    pub(super) heights: &'r [f64],
    pub(super) errors: &'r [f32],
    /// The heights of the row above.
    above: &'r [f64],
    cell: Cell,
}

impl<'r> Line<'r> {
    #[inline(always)]
    pub(super) fn of(block: &Block<'r>, at: usize) -> Line<'r> {
        let Block { rows, cells, measure, side } = *block;
        let (width, start) = (rows.width, at * rows.width);
        // There is none above the first row: it is level along columns.
        let above = if rows.above.is_empty() { &rows.heights[..width] } else { rows.above };
        Line {
            rows,
            measure,
            side,
            row: rows.first_row + at,
            start,
            heights: &rows.heights[start..start + width],
            errors: &rows.errors[start..start + width],
            above: if at == 0 { above } else { &rows.heights[start - width..start] },
            cell: cells[at],
        }
    }

    /// Where in a piece the squares begin that it goes through.
    #[inline(always)]
    pub(super) fn squares(&self, piece: &Piece) -> usize {
        (self.row / self.side - piece.row / self.side) * self.heights.len().div_ceil(self.side)
    }

    /// The squares of the slopes' tangents at samples from this column on, none of them at an end of the row; NaN where a height beside
    /// or above is missing.
    #[inline(always)]
    fn slopes(&self, first: usize, slopes: &mut [f32]) {
        let count = slopes.len();
        let (left, right) = (&self.heights[first - 1..][..count], &self.heights[first + 1..][..count]);
        let (here, above) = (&self.heights[first..][..count], &self.above[first..][..count]);
        for i in 0..count {
            slopes[i] = self.cell.squared(right[i] - left[i], here[i] - above[i]);
        }
    }

    /// The keys of samples from this column on, none of them at an end of the row, and what all of them are. Those that are not plain have
    /// any key.
    #[inline(always)]
    pub(super) fn keys(&self, first: usize, keys: &mut [Key]) -> Are {
        let count = keys.len();
        let mut slopes = [0.0; STRETCH];
        let slopes = &mut slopes[..count];
        self.slopes(first, slopes);
        let (errors, measure) = (&self.errors[first..][..count], self.measure);
        // Numbers that are not negative are in the order of their bits, and what is no number comes after all.
        let (mut farthest, mut steepest) = (0, 0);
        for i in 0..count {
            let (slope, error) = (slopes[i], errors[i]);
            keys[i] = key(measure.slopes.class(slope), measure.bins.bin(error));
            farthest = farthest.max(error.abs().to_bits());
            steepest = steepest.max(slope.to_bits());
        }
        let (tolerance, small) = (measure.tolerance as f32, (SMALL * measure.tolerance) as f32);
        let are_peculiar = farthest > tolerance.to_bits() || steepest > f32::INFINITY.to_bits();
        let start = self.start + first;
        let plain = !are_peculiar && !self.rows.any_above(start..start + count);
        Are { plain, large: farthest >= small.to_bits() }
    }

    /// The slope class of any sample; [`NO_CLASS`] where there is no height beside it, or none above it.
    pub(super) fn class(&self, column: usize) -> usize {
        let here = self.heights[column];
        let beside = |column: Option<usize>| column.and_then(|c| self.heights.get(c)).copied().filter(|h| !h.is_nan());
        let across = match (beside(column.checked_sub(1)), beside(Some(column + 1))) {
            (Some(left), Some(right)) => right - left,
            (Some(left), None) => 2.0 * (here - left),
            (None, Some(right)) => 2.0 * (right - here),
            (None, None) => return NO_CLASS,
        };
        let squared = self.cell.squared(across, here - self.above[column]);
        if squared.is_nan() { NO_CLASS } else { self.measure.slopes.class(squared) as usize }
    }
}
