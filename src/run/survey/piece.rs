//! Some rows of samples, surveyed by one thread.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::grid::MapCell;
use super::histogram::{Bins, Histogram, Key, class_of, key, unclassed};
use super::slopes::{Cell, Class, FROM, NO_CLASS, Slopes};
use crate::verify::ObservedRows;

/// Samples of a piece, about.
const SAMPLES: usize = 1 << 15;
/// Samples that are counted side by side, in sums of their own: none waits for the sum of the one before.
const LANES: usize = 4;
/// Samples that are all less than this share of the tolerance off count in their class as they are.
const SMALL: f64 = 1.0 / 16.0;
/// Samples of a row that are classified together: what is made of them step by step stays in the cache.
const STRETCH: usize = 512;

/// What errors are held against.
pub(super) struct Measure {
    pub(super) tolerance: f64,
    pub(super) slopes: Slopes,
    pub(super) bins: Bins,
}

/// What comes out the same in whatever order samples are counted: a thread counts into the same for piece after piece.
pub(super) struct Tally {
    pub(super) histogram: Histogram,
    /// Samples below −ε and above ε.
    pub(super) low: u64,
    pub(super) high: u64,
    pub(super) largest: f64,
    pub(super) near: u64,
    /// Samples of all pieces, at least those that were counted.
    samples: u64,
}

/// Tallies that no thread has at the moment.
pub(super) struct Tallies {
    tolerance: f64,
    idle: Mutex<Vec<Tally>>,
}

/// What some rows come to, as far as it depends on the order.
pub(super) struct Piece {
    pub(super) sum: f64,
    /// By slope, as far as the tally does not know it.
    pub(super) classes: [Class; FROM.len()],
    /// The squares of the map that the rows go through, row by row.
    pub(super) cells: Vec<MapCell>,
}

impl Tally {
    /// Samples after which a tally is added up, so that 32 bits hold what it counts.
    const MANY: u64 = 1 << 30;

    fn new(tolerance: f64) -> Tally {
        Tally { histogram: Histogram::new(tolerance), low: 0, high: 0, largest: 0.0, near: 0, samples: 0 }
    }
}

impl Tallies {
    pub(super) fn new(tolerance: f64) -> Tallies {
        Tallies { tolerance, idle: Mutex::default() }
    }

    fn take(&self) -> Tally {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        idle.unwrap_or_else(|| Tally::new(self.tolerance))
    }

    fn put_back(&self, tally: Tally) {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(tally);
    }

    /// Those that have counted enough, to be added up.
    pub(super) fn full(&mut self) -> impl Iterator<Item = Tally> {
        let idle = self.idle.get_mut().unwrap_or_else(PoisonError::into_inner);
        idle.extract_if(.., |tally| tally.samples >= Tally::MANY)
    }

    /// All of them.
    pub(super) fn all(self) -> Vec<Tally> {
        self.idle.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Piece {
    /// The pieces of these rows, each with its first row, in order; `above` are the heights of the row above the first one, or
    /// none, and `side` samples make the side of a square of the map.
    pub(super) fn all_of(
        rows: &ObservedRows<'_>,
        above: &[f64],
        measure: &Measure,
        side: usize,
        tallies: &Tallies,
    ) -> Vec<(usize, Piece)> {
        let (width, count) = (rows.width, rows.heights.len() / rows.width);
        let down = (SAMPLES / width).max(1);
        let piece = |index: usize| {
            let range = index * down..((index + 1) * down).min(count);
            let first = rows.first_row + range.start;
            let squares = (first + range.len() - 1) / side - first / side + 1;
            let mut tally = tallies.take();
            tally.samples += (range.len() * width) as u64;
            let mut counting = Counting { piece: Piece::new(squares * width.div_ceil(side)), tally, keys: Vec::new() };
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
                pulp::Arch::new().dispatch(Take {
                    counting: &mut counting,
                    line: &line,
                    squares: (first / side, side),
                });
            }
            let Counting { piece, tally, .. } = counting;
            tallies.put_back(tally);
            (first, piece)
        };
        (0..count.div_ceil(down)).into_par_iter().map(piece).collect()
    }

    fn new(cells: usize) -> Piece {
        Piece { sum: 0.0, classes: [Class::default(); FROM.len()], cells: vec![MapCell::default(); cells] }
    }
}

/// A piece that is being made.
struct Counting {
    piece: Piece,
    tally: Tally,
    /// Of the samples of a row: where each is counted.
    keys: Vec<Key>,
}

/// Adding a row, compiled for the processor. Not a closure: those are not always inlined into what is.
struct Take<'a, 'r> {
    counting: &'a mut Counting,
    line: &'a Line<'r>,
    /// The first row of squares of the piece, and their side.
    squares: (usize, usize),
}

impl pulp::NullaryFnOnce for Take<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.counting.take(self.line, self.squares);
    }
}

impl Counting {
    /// Adds a row; the first squares of the piece are those of this row of squares.
    #[inline(always)]
    fn take(&mut self, line: &Line<'_>, (first_square, side): (usize, usize)) {
        let width = line.heights.len();
        let across = width.div_ceil(side);
        let first = (line.row / side - first_square) * across;
        let is_plain = line.rows.weights.is_none() && !line.rows.any_above(line.start..line.start + width);
        let mut keys = std::mem::take(&mut self.keys);
        if is_plain {
            line.keys(&mut keys);
        }
        for square in 0..across {
            let columns = square * side..((square + 1) * side).min(width);
            let mut cell = std::mem::take(&mut self.piece.cells[first + square]);
            if !is_plain || !self.take_plain(line, columns.clone(), &keys[columns.clone()], &mut cell) {
                columns.for_each(|column| self.take_any(line, column, &mut cell));
            }
            self.piece.cells[first + square] = cell;
        }
        self.keys = keys;
    }

    /// Adds samples next to each other that have no weights and are within the tolerance, if all of them have a height, a surface and a
    /// slope. Otherwise nothing changes.
    #[inline(always)]
    fn take_plain(&mut self, line: &Line<'_>, columns: Range<usize>, keys: &[Key], cell: &mut MapCell) -> bool {
        let (errors, heights) = (&line.errors[columns.clone()], &line.heights[columns]);
        let tolerance = line.measure.tolerance;
        let sums = Sums::of(errors, heights, 0.9 * tolerance);
        let last = keys.iter().fold(0, |last, key| last.max(*key));
        if sums.error.is_nan() || sums.max > tolerance || class_of(last) == NO_CLASS {
            return false;
        }
        let Counting { piece, tally, .. } = self;
        let count = errors.len() as u32;
        cell.heights += count;
        cell.measured += count;
        cell.sum += sums.height;
        cell.max = cell.max.max(sums.max as f32);
        cell.near += sums.near;
        tally.near += u64::from(sums.near);
        tally.largest = tally.largest.max(sums.max);
        piece.sum += sums.error;
        if sums.max < SMALL * tolerance {
            // Bins would be too wide for these.
            for (key, error) in keys.iter().zip(errors) {
                let distance = error.abs();
                tally.histogram.count(unclassed(*key));
                let class = &mut piece.classes[class_of(*key) % FROM.len()];
                class.add(&Class { samples: 1, above: 0, max: distance, squares: distance * distance });
            }
        } else {
            keys.iter().for_each(|key| tally.histogram.count(*key));
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
        let tally = &mut self.tally;
        tally.near += u64::from(is_near);
        tally.largest = tally.largest.max(counted);
        tally.histogram.count_any(counted.copysign(error));
        tally.low += u64::from(is_above && error < 0.0);
        tally.high += u64::from(is_above && error > 0.0);
        self.piece.sum += error;
        if let Some(class) = self.piece.classes.get_mut(line.class(column)) {
            let squares = distance * distance;
            class.add(&Class { samples: 1, above: u64::from(is_above), max: distance, squares });
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
    /// The keys of all samples that are within the tolerance; those of [`NO_CLASS`] at the ends of the row, and where a height beside
    /// or above is missing.
    #[inline(always)]
    fn keys(&self, keys: &mut Vec<Key>) {
        let width = self.heights.len();
        keys.clear();
        keys.resize(width, key(NO_CLASS as u32, 0));
        if width < 3 {
            return;
        }
        let (mut squared, mut bins, mut classes) = ([0.0; STRETCH], [0; STRETCH], [0; STRETCH]);
        // The loops are simple ones, so that all of them become vectors.
        for (stretch, keys) in keys[1..width - 1].chunks_mut(STRETCH).enumerate() {
            let (first, count) = (stretch * STRETCH, keys.len());
            let (left, right) = (&self.heights[first..][..count], &self.heights[first + 2..][..count]);
            let (here, above) = (&self.heights[first + 1..][..count], &self.above[first + 1..][..count]);
            for (i, squared) in squared[..count].iter_mut().enumerate() {
                *squared = self.cell.squared((right[i] - left[i]) / 2.0, here[i] - above[i]);
            }
            for (bin, error) in bins[..count].iter_mut().zip(&self.errors[first + 1..]) {
                *bin = self.measure.bins.bin(*error);
            }
            for (class, squared) in classes[..count].iter_mut().zip(&squared) {
                *class = self.measure.slopes.class(*squared);
            }
            for (at, (class, bin)) in keys.iter_mut().zip(classes.iter().zip(&bins)) {
                *at = key(*class, *bin);
            }
        }
    }

    /// The slope class of any sample; [`NO_CLASS`] where there is no height beside it, or none above it.
    fn class(&self, column: usize) -> usize {
        let here = self.heights[column];
        let beside = |column: Option<usize>| column.and_then(|c| self.heights.get(c)).copied().filter(|h| !h.is_nan());
        let across = match (beside(column.checked_sub(1)), beside(Some(column + 1))) {
            (Some(left), Some(right)) => (right - left) / 2.0,
            (Some(left), None) => here - left,
            (None, Some(right)) => right - here,
            (None, None) => return NO_CLASS,
        };
        self.measure.slopes.class(self.cell.squared(across, here - self.above[column])) as usize
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
        for (errors, heights) in errors.iter().zip(heights) {
            for i in 0..LANES {
                let distance = errors[i].abs();
                max[i] = if distance > max[i] { distance } else { max[i] };
                error[i] += errors[i];
                height[i] += heights[i];
                near[i] += if distance > nearly { 1.0 } else { 0.0 };
            }
        }
        for (i, (e, h)) in last_errors.iter().zip(last_heights).enumerate() {
            max[i] = max[i].max(e.abs());
            error[i] += e;
            height[i] += h;
            near[i] += f64::from(e.abs() > nearly);
        }
        Sums {
            max: max.into_iter().fold(0.0, f64::max),
            error: error.iter().sum(),
            height: height.iter().sum(),
            near: near.iter().sum::<f64>() as u32,
        }
    }
}
