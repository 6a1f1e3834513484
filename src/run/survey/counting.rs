//! Counting the samples of a block: those without peculiarities side by side, as vectors, the others one by one.

use std::ops::Range;

use super::columns::{Columns, LANES, STRETCH, Sum, sum};
use super::histogram::{Key, class_of, unclassed};
use super::line::{Block, Line};
use super::piece::{Piece, Tally};
use super::slopes::{Class, FROM};

/// Samples of a row that are taken together where some of a stretch are peculiar.
const FEW: usize = 16;
/// Rows whose columns are added up together.
const TOGETHER: usize = 4;
/// Tolerances that single precision is good for.
const USUAL: Range<f64> = 1e-30..1e30;

/// A piece that is being made.
pub(super) struct Counting {
    piece: Piece,
    tally: Tally,
    columns: Columns,
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
            let mut waiting = Waiting::default();
            for at in 0..block.cells.len() {
                let line = Line::of(block, at);
                if self.take_stretch(&line, columns.clone()) {
                    waiting.rows[waiting.count] = at;
                    waiting.count += 1;
                }
                let is_last = (line.row + 1).is_multiple_of(block.side) || at + 1 == block.cells.len();
                if is_last || waiting.count == TOGETHER {
                    self.take_waiting(block, &mut waiting, columns.clone());
                }
                if is_last {
                    self.settle(&line, columns.clone());
                }
            }
        }
    }

    /// Adds what the columns of rows that are plain come to.
    #[inline(always)]
    fn take_waiting(&mut self, block: &Block<'_>, waiting: &mut Waiting, columns: Range<usize>) {
        let inner = inner(&columns, block.rows.width);
        let (first, at, count) = (inner.start, inner.start - columns.start, inner.len());
        self.columns.rows += waiting.count as u32;
        if waiting.count == TOGETHER {
            self.columns.add(waiting.rows.map(|row| Line::of(block, row)), first, at, count);
        } else {
            waiting.rows[..waiting.count]
                .iter()
                .for_each(|row| self.columns.add([Line::of(block, *row)], first, at, count));
        }
        waiting.count = 0;
    }

    /// Counts samples of a row. Where all are plain that are not at an end of it, what their columns come to is left to be added.
    #[inline(always)]
    fn take_stretch(&mut self, line: &Line<'_>, columns: Range<usize>) -> bool {
        let inner = inner(&columns, line.heights.len());
        let tolerance = line.measure.tolerance;
        let is_usual = line.rows.weights.is_none() && (tolerance == 0.0 || USUAL.contains(&tolerance));
        if !is_usual || inner.is_empty() {
            columns.for_each(|column| self.take_any(line, column));
            return false;
        }
        (columns.start..inner.start).chain(inner.end..columns.end).for_each(|column| self.take_any(line, column));
        let mut keys = [0; STRETCH];
        let keys = &mut keys[..inner.len()];
        let are = line.keys(inner.start, keys);
        if are.plain {
            self.count(line, inner.start, keys, are.large);
            return true;
        }
        for (few, keys) in keys.chunks_mut(FEW).enumerate() {
            let first = inner.start + few * FEW;
            let are = line.keys(first, keys);
            if are.plain {
                self.count(line, first, keys, are.large);
                let at = first - columns.start;
                self.columns.add([*line], first, at, keys.len());
                self.columns.measured[at..][..keys.len()].iter_mut().for_each(|measured| *measured += 1);
            } else {
                (first..first + keys.len()).for_each(|column| self.take_any(line, column));
            }
        }
        false
    }

    /// Counts samples from this column on that are plain, and have these keys.
    #[inline(always)]
    fn count(&mut self, line: &Line<'_>, first: usize, keys: &[Key], are_large: bool) {
        if are_large {
            return self.tally.histogram.count_all(keys);
        }
        // Bins would be too wide for these.
        let errors = &line.errors[first..][..keys.len()];
        let (mut least, mut last) = (Key::MAX, 0);
        for key in keys {
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
        let (side, first, inner) = (line.side, line.squares(piece), inner(&columns, line.heights.len()));
        let mut start = columns.start;
        while start < columns.end {
            let square = start / side;
            let end = ((square + 1) * side).min(columns.end);
            let at = start - columns.start..end - columns.start;
            let whole = end.min(inner.end).saturating_sub(start.max(inner.start)) as u32;
            let sum = Sum::of(sums, at);
            let measured = sums.rows * whole + sum.measured;
            let cell = &mut piece.squares[first + square];
            cell.measured += measured;
            cell.heights += measured;
            cell.near += sum.near;
            cell.max = cell.max.max(f32::from_bits(sum.max as u32));
            cell.sum += sum.heights;
            start = end;
        }
        piece.sum += sum(&mut sums.errors);
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
        let cell = &mut piece.squares[first + column / line.side];
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

/// Rows whose columns are still to be added up.
#[derive(Default)]
struct Waiting {
    rows: [usize; TOGETHER],
    count: usize,
}

/// Those of these columns that are not at an end of a row.
fn inner(columns: &Range<usize>, width: usize) -> Range<usize> {
    columns.start.max(1)..columns.end.min(width - 1)
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
