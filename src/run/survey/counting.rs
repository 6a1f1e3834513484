//! Counting the samples of a block: those without peculiarities side by side, as vectors, the others one by one.

use std::ops::Range;

use super::histogram::{Key, class_of, key, unclassed};
use super::piece::{Measure, Piece, Tally};
use super::slopes::{Cell, Class, FROM, NO_CLASS};
use crate::verify::ObservedRows;

/// Samples of a row that are taken together: what is made of them step by step stays in the cache.
const STRETCH: usize = 256;
/// The same where some of those are peculiar.
const FEW: usize = 16;
/// Samples that are added up side by side, in sums of their own.
const LANES: usize = 8;
/// Samples that are all less than this share of the tolerance off count in their class as they are.
const SMALL: f64 = 1.0 / 16.0;
/// Tolerances that single precision is good for.
const USUAL: Range<f64> = 1e-30..1e30;

/// Some rows.
pub(super) struct Block<'r> {
    pub(super) rows: &'r ObservedRows<'r>,
    /// The cells of each.
    pub(super) cells: &'r [Cell],
    pub(super) measure: &'r Measure,
    /// The side of a square of the map.
    pub(super) side: usize,
}

/// A piece that is being made.
pub(super) struct Counting {
    piece: Piece,
    tally: Tally,
    columns: Columns,
}

/// What samples come to that lie in one column, in a stretch of columns and in one row of squares.
struct Columns {
    measured: [u16; STRETCH],
    near: [u16; STRETCH],
    /// The bits of distances, which are in the same order.
    max: [u32; STRETCH],
    heights: [f64; STRETCH],
}

impl Columns {
    const NONE: Columns =
        Columns { measured: [0; STRETCH], near: [0; STRETCH], max: [0; STRETCH], heights: [0.0; STRETCH] };
}

impl Counting {
    pub(super) fn new(piece: Piece, tally: Tally) -> Counting {
        Counting { piece, tally, columns: Columns::NONE }
    }

    pub(super) fn finish(self) -> (Piece, Tally) {
        (self.piece, self.tally)
    }

    /// Counts a block, the one that the piece was made for.
    #[inline(always)]
    pub(super) fn take(&mut self, block: &Block<'_>) {
        for first in (0..block.rows.width).step_by(STRETCH) {
            let columns = first..(first + STRETCH).min(block.rows.width);
            for at in 0..block.cells.len() {
                let line = Line::of(block, at);
                self.take_stretch(&line, columns.clone());
                if (line.row + 1).is_multiple_of(block.side) || at + 1 == block.cells.len() {
                    self.settle(&line, columns.clone());
                }
            }
        }
    }

    /// Counts samples of a row.
    #[inline(always)]
    fn take_stretch(&mut self, line: &Line<'_>, columns: Range<usize>) {
        let width = line.heights.len();
        let inner = columns.start.max(1)..columns.end.min(width - 1);
        let tolerance = line.measure.tolerance;
        let is_usual = line.rows.weights.is_none() && (tolerance == 0.0 || USUAL.contains(&tolerance));
        if !is_usual || inner.is_empty() {
            return columns.for_each(|column| self.take_any(line, column));
        }
        (columns.start..inner.start).chain(inner.end..columns.end).for_each(|column| self.take_any(line, column));
        let mut slopes = [0.0; STRETCH];
        let slopes = &mut slopes[..inner.len()];
        line.slopes(inner.start, slopes);
        let together = if line.are_plain(inner.start, slopes) { STRETCH } else { FEW };
        for at in (0..inner.len()).step_by(together) {
            let few = at..(at + together).min(inner.len());
            let (first, slopes) = (inner.start + at, &slopes[few]);
            if together == STRETCH || line.are_plain(first, slopes) {
                self.take_plain(line, first, slopes, first - columns.start);
            } else {
                (first..first + slopes.len()).for_each(|column| self.take_any(line, column));
            }
        }
    }

    /// Counts samples from this column on that are plain, with these slopes.
    #[inline(always)]
    fn take_plain(&mut self, line: &Line<'_>, first: usize, slopes: &[f32], at: usize) {
        let count = slopes.len();
        let (errors, heights) = (&line.errors[first..][..count], &line.heights[first..][..count]);
        let (measure, nearly) = (line.measure, line.measure.nearly());
        let small = (SMALL * measure.tolerance) as f32;
        let mut keys: [Key; STRETCH] = [0; STRETCH];
        let keys = &mut keys[..count];
        // The loops are simple ones, so that all of them become vectors.
        for i in 0..count {
            keys[i] = key(measure.slopes.class(slopes[i]), measure.bins.bin(errors[i]));
        }
        let Columns { measured, near, max, heights: sums } = &mut self.columns;
        let (measured, near) = (&mut measured[at..][..count], &mut near[at..][..count]);
        let (max, sums) = (&mut max[at..][..count], &mut sums[at..][..count]);
        let mut are_large = 0;
        for i in 0..count {
            let distance = errors[i].abs();
            max[i] = max[i].max(distance.to_bits());
            near[i] += u16::from(distance > nearly);
            are_large |= u32::from(distance >= small);
        }
        for i in 0..count {
            sums[i] += heights[i];
        }
        for measured in measured {
            *measured += 1;
        }
        self.piece.sum += sum(errors);
        if are_large != 0 {
            keys.iter().for_each(|key| self.tally.histogram.count(*key));
            return;
        }
        // Bins would be too wide for these.
        let (mut least, mut last) = (Key::MAX, 0);
        for key in &*keys {
            least = least.min(*key);
            last = last.max(*key);
        }
        for class in class_of(least)..=class_of(last) {
            self.piece.classes[class % FROM.len()].add(&Lanes::of_class(class, keys, errors));
        }
        keys.iter().for_each(|key| self.tally.histogram.count(unclassed(*key)));
    }

    /// Adds what these columns have come to to the squares of the row of them that a line is in.
    #[inline(always)]
    fn settle(&mut self, line: &Line<'_>, columns: Range<usize>) {
        let Counting { piece, columns: sums, .. } = self;
        let (side, first) = (line.side, line.squares(piece));
        let mut at = 0;
        while at < columns.len() {
            let square = (columns.start + at) / side;
            let end = ((square + 1) * side - columns.start).min(columns.len());
            let measured: u32 = sums.measured[at..end].iter().map(|count| u32::from(*count)).sum();
            let cell = &mut piece.cells[first + square];
            cell.measured += measured;
            cell.heights += measured;
            cell.near += sums.near[at..end].iter().map(|count| u32::from(*count)).sum::<u32>();
            let max = sums.max[at..end].iter().fold(0, |max, bits| max.max(*bits));
            cell.max = cell.max.max(f32::from_bits(max));
            cell.sum += sums.heights[at..end].iter().sum::<f64>();
            at = end;
        }
        *sums = Columns::NONE;
    }

    /// Counts any sample.
    fn take_any(&mut self, line: &Line<'_>, column: usize) {
        let (height, error, at) = (line.heights[column], line.errors[column], line.start + column);
        if height.is_nan() {
            return;
        }
        let Counting { piece, tally, .. } = self;
        let first = line.squares(piece);
        let cell = &mut piece.cells[first + column / line.side];
        cell.heights += 1;
        cell.sum += height;
        if error.is_nan() {
            return;
        }
        let error = f64::from(error.clamp(f32::MIN, f32::MAX));
        let (tolerance, distance, is_above) = (line.measure.tolerance, error.abs(), line.rows.is_above(at));
        let counted = line.rows.weights.map_or(distance, |weights| distance * weights[at]);
        // It is rounded; whether it is above is not.
        let counted = if is_above { counted.max(tolerance.next_up()) } else { counted.min(tolerance) };
        cell.measured += 1;
        cell.max = cell.max.max(counted as f32);
        cell.near += u32::from(is_above || counted as f32 > line.measure.nearly());
        cell.above += u32::from(is_above);
        tally.histogram.count_any(counted.copysign(error));
        // One of two triangles over it may be above while the other is not: then the error is any.
        tally.low += u64::from(is_above && error.is_sign_negative());
        tally.high += u64::from(is_above && !error.is_sign_negative());
        piece.sum += error;
        if let Some(class) = piece.classes.get_mut(line.class(column)) {
            let squares = distance * distance;
            class.add(&Class { samples: 1, above: u64::from(is_above), max: distance, squares });
        }
    }
}

/// The sum of some errors, as vectors add it up.
#[inline(always)]
fn sum(errors: &[f32]) -> f64 {
    // Of fewer the compiler makes no vectors.
    let (mut lanes, (errors, last)) = ([0.0; 32], errors.as_chunks::<32>());
    for errors in errors {
        for i in 0..32 {
            lanes[i] += errors[i];
        }
    }
    for i in 0..16 {
        lanes[i] += lanes[i + 16];
    }
    for i in 0..8 {
        lanes[i] += lanes[i + 8];
    }
    lanes[..8].iter().chain(last).map(|error| f64::from(*error)).sum()
}

/// What samples of one class come to, lane by lane.
#[derive(Default)]
struct Lanes {
    samples: [u32; LANES],
    max: [f32; LANES],
    squares: [f64; LANES],
}

impl Lanes {
    #[inline(always)]
    fn take<const N: usize>(&mut self, class: usize, keys: &[Key; N], errors: &[f32; N]) {
        for i in 0..N {
            let is_of = class_of(keys[i]) == class;
            let distance = if is_of { errors[i].abs() } else { 0.0 };
            self.samples[i] += u32::from(is_of);
            self.max[i] = if distance > self.max[i] { distance } else { self.max[i] };
            self.squares[i] += f64::from(distance) * f64::from(distance);
        }
    }

    /// Those of this class among some samples, by their errors.
    #[inline(always)]
    fn of_class(class: usize, keys: &[Key], errors: &[f32]) -> Class {
        let mut lanes = Lanes::default();
        let ((keys, last_keys), (errors, last_errors)) = (keys.as_chunks(), errors.as_chunks());
        for (keys, errors) in keys.iter().zip(errors) {
            lanes.take::<LANES>(class, keys, errors);
        }
        for (key, error) in last_keys.iter().zip(last_errors) {
            lanes.take(class, &[*key], &[*error]);
        }
        Class {
            samples: lanes.samples.into_iter().map(u64::from).sum(),
            above: 0,
            max: f64::from(lanes.max.into_iter().fold(0.0, f32::max)),
            squares: lanes.squares.into_iter().sum(),
        }
    }
}

/// A row that is counted.
struct Line<'r> {
    rows: &'r ObservedRows<'r>,
    measure: &'r Measure,
    side: usize,
    /// Which it is, and where it begins in `rows`.
    row: usize,
    start: usize,
    heights: &'r [f64],
    errors: &'r [f32],
    /// The heights of the row above.
    above: &'r [f64],
    cell: Cell,
}

impl<'r> Line<'r> {
    #[inline(always)]
    fn of(block: &Block<'r>, at: usize) -> Line<'r> {
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
    fn squares(&self, piece: &Piece) -> usize {
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

    /// Whether all samples from this column on have a height, a surface within the tolerance and one of these slopes.
    #[inline(always)]
    fn are_plain(&self, first: usize, slopes: &[f32]) -> bool {
        let (count, tolerance) = (slopes.len(), self.measure.tolerance as f32);
        let errors = &self.errors[first..][..count];
        // What is no number is neither.
        let mut are_peculiar = 0;
        for i in 0..count {
            let (is_within, is_known) = (errors[i].abs() <= tolerance, slopes[i] >= 0.0);
            are_peculiar |= u32::from(!is_within) | u32::from(!is_known);
        }
        let start = self.start + first;
        are_peculiar == 0 && !self.rows.any_above(start..start + count)
    }

    /// The slope class of any sample; [`NO_CLASS`] where there is no height beside it, or none above it.
    fn class(&self, column: usize) -> usize {
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
