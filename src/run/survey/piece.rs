//! Some rows of samples, surveyed by one thread.

use std::ops::Range;

use rayon::prelude::*;

use super::grid::MapCell;
use super::histogram::Histogram;
use super::slopes::{Cell, Class, FROM, NO_CLASS, Slopes};
use crate::verify::ObservedRows;

/// Samples of a piece, about.
const SAMPLES: usize = 1 << 15;
/// Samples that are counted side by side, in sums of their own: none waits for the sum of the one before.
const LANES: usize = 4;

/// What errors are held against.
pub(super) struct Measure {
    pub(super) tolerance: f64,
    pub(super) slopes: Slopes,
}

/// What some rows come to.
pub(super) struct Piece {
    pub(super) histogram: Histogram,
    /// Samples below −ε and above ε.
    pub(super) low: u64,
    pub(super) high: u64,
    pub(super) sum: f64,
    pub(super) largest: f64,
    pub(super) near: u64,
    /// By slope, in [`LANES`] parts.
    pub(super) classes: [[Class; FROM.len()]; LANES],
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
            let mut classes = Vec::new();
            for at in range {
                // The first row of all takes its own heights for those above it, and has no slope along columns.
                let above = match at {
                    0 if above.is_empty() => &rows.heights[..width],
                    0 => above,
                    _ => &rows.heights[(at - 1) * width..at * width],
                };
                let (row, start) = (rows.first_row + at, at * width);
                let (heights, errors) = (&rows.heights[start..start + width], &rows.errors[start..start + width]);
                let cell = measure.slopes.cell(row);
                let line = Line { rows, row, start, heights, errors, above, cell, measure };
                piece.take(&line, (first / side, side), &mut classes);
            }
            (first, piece)
        };
        (0..count.div_ceil(down)).into_par_iter().map(piece).collect()
    }

    fn new(tolerance: f64, cells: usize) -> Piece {
        Piece {
            histogram: Histogram::new(tolerance),
            low: 0,
            high: 0,
            sum: 0.0,
            largest: 0.0,
            near: 0,
            classes: [[Class::default(); FROM.len()]; LANES],
            cells: vec![MapCell::default(); cells],
        }
    }

    /// Adds a row; the first squares of the piece are those of this row of squares. `classes` is a buffer.
    fn take(&mut self, line: &Line<'_>, (first_square, side): (usize, usize), classes: &mut Vec<u8>) {
        let width = line.heights.len();
        let across = width.div_ceil(side);
        let first = (line.row / side - first_square) * across;
        line.classify(classes);
        let is_plain = line.rows.weights.is_none() && !line.rows.any_above(line.start..line.start + width);
        for square in 0..across {
            let columns = square * side..((square + 1) * side).min(width);
            let mut cell = std::mem::take(&mut self.cells[first + square]);
            if !is_plain || !self.take_plain(line, columns.clone(), &classes[columns.clone()], &mut cell) {
                columns.for_each(|column| self.take_any(line, column, &mut cell));
            }
            self.cells[first + square] = cell;
        }
    }

    /// Adds samples next to each other that have no weights and are within the tolerance, if all of them have a height, a surface and a
    /// slope. Otherwise nothing changes.
    #[inline(always)]
    fn take_plain(&mut self, line: &Line<'_>, columns: Range<usize>, classes: &[u8], cell: &mut MapCell) -> bool {
        let (errors, heights) = (&line.errors[columns.clone()], &line.heights[columns]);
        let tolerance = line.measure.tolerance;
        let sums = Sums::of(errors, heights, 0.9 * tolerance);
        let any = classes.iter().fold(0, |any, class| any | class);
        if sums.error.is_nan() || sums.max > tolerance || any & NO_CLASS != 0 {
            return false;
        }
        let count = errors.len() as u32;
        cell.heights += count;
        cell.measured += count;
        cell.sum += sums.height;
        cell.max = cell.max.max(sums.max as f32);
        cell.near += sums.near;
        self.near += u64::from(sums.near);
        self.sum += sums.error;
        self.largest = self.largest.max(sums.max);
        self.histogram.count_within(errors);
        let (chunks, last_classes) = classes.as_chunks::<LANES>();
        let (errors, last_errors) = errors.as_chunks::<LANES>();
        for (classes, errors) in chunks.iter().zip(errors) {
            for lane in 0..LANES {
                self.classes[lane][usize::from(classes[lane]) % FROM.len()].count(errors[lane].abs());
            }
        }
        for (class, error) in last_classes.iter().zip(last_errors) {
            self.classes[0][usize::from(*class) % FROM.len()].count(error.abs());
        }
        true
    }

    /// Adds any sample.
    fn take_any(&mut self, line: &Line<'_>, column: usize, cell: &mut MapCell) {
        let (height, error, at) = (line.heights[column], line.errors[column], line.start + column);
        if height.is_nan() {
            return;
        }
        cell.heights += 1;
        cell.sum += height;
        if error.is_nan() {
            return;
        }
        let (tolerance, distance, is_above) = (line.measure.tolerance, error.abs(), line.rows.is_above(at));
        let counted = line.rows.weights.map_or(distance, |weights| distance * weights[at]);
        // It is rounded; whether it is above is not.
        let counted = if is_above { counted } else { counted.min(tolerance) };
        let is_near = is_above || counted > 0.9 * tolerance;
        cell.measured += 1;
        cell.max = cell.max.max(counted as f32);
        cell.near += u32::from(is_near);
        cell.above += u32::from(is_above);
        self.near += u64::from(is_near);
        self.sum += error;
        self.largest = self.largest.max(counted);
        self.histogram.count(counted.copysign(error));
        self.low += u64::from(is_above && error < 0.0);
        self.high += u64::from(is_above && error > 0.0);
        if let Some(class) = line.class(column) {
            let class = &mut self.classes[0][class];
            class.count(distance);
            class.above += u64::from(is_above);
        }
    }
}

/// A row that is surveyed.
struct Line<'r> {
    rows: &'r ObservedRows<'r>,
    /// Which it is, and where it begins in `rows`.
    row: usize,
    start: usize,
    heights: &'r [f64],
    errors: &'r [f64],
    /// The heights of the row above.
    above: &'r [f64],
    cell: Cell,
    measure: &'r Measure,
}

impl Line<'_> {
    /// The slope classes of all samples; [`NO_CLASS`] at the ends of the row, and where a height beside or above is missing.
    fn classify(&self, classes: &mut Vec<u8>) {
        let width = self.heights.len();
        classes.clear();
        classes.resize(width, NO_CLASS);
        if width < 3 {
            return;
        }
        let (left, right) = (&self.heights[..width - 2], &self.heights[2..]);
        let (here, above) = (&self.heights[1..width - 1], &self.above[1..width - 1]);
        let heights = left.iter().zip(right).zip(here.iter().zip(above));
        for (class, ((left, right), (here, above))) in classes[1..width - 1].iter_mut().zip(heights) {
            *class = self.measure.slopes.class(self.cell.squared((right - left) / 2.0, here - above));
        }
    }

    /// The slope class of any sample; `None` where there is no height beside it, or none above it.
    fn class(&self, column: usize) -> Option<usize> {
        let here = self.heights[column];
        let beside = |column: Option<usize>| column.and_then(|c| self.heights.get(c)).copied().filter(|h| !h.is_nan());
        let across = match (beside(column.checked_sub(1)), beside(Some(column + 1))) {
            (Some(left), Some(right)) => (right - left) / 2.0,
            (Some(left), None) => here - left,
            (None, Some(right)) => right - here,
            (None, None) => return None,
        };
        let squared = self.cell.squared(across, here - self.above[column]);
        Some(usize::from(self.measure.slopes.class(squared))).filter(|class| *class < FROM.len())
    }
}

/// What some samples come to, as vectors add it up: NaN where one has no height or no surface.
struct Sums {
    max: f64,
    error: f64,
    height: f64,
    near: u32,
}

impl Sums {
    #[inline(always)]
    fn of(errors: &[f64], heights: &[f64], nearly: f64) -> Sums {
        let ((errors, last_errors), (heights, last_heights)) =
            (errors.as_chunks::<LANES>(), heights.as_chunks::<LANES>());
        let (mut max, mut error, mut height, mut near) = ([0.0f64; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut add = |i: usize, e: f64, h: f64| {
            let distance = e.abs();
            max[i] = if distance > max[i] { distance } else { max[i] };
            error[i] += e;
            height[i] += h;
            near[i] += if distance > nearly { 1.0 } else { 0.0 };
        };
        for (errors, heights) in errors.iter().zip(heights) {
            for i in 0..LANES {
                add(i, errors[i], heights[i]);
            }
        }
        last_errors.iter().zip(last_heights).enumerate().for_each(|(i, (e, h))| add(i, *e, *h));
        Sums {
            max: max.into_iter().fold(0.0, f64::max),
            error: error.iter().sum(),
            height: height.iter().sum(),
            near: near.iter().sum::<f64>() as u32,
        }
    }
}
