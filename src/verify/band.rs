//! Some rows of samples, and triangles held against them by all threads.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::finding::TouchPlace;
use super::grid::Grid;
use super::observe::ObservedRows;
use super::plane::Plane;
use super::row::{RowTally, Worst, mark};
use super::samples::Samples;
use super::sweep::Comparison;
use super::task::{Task, Told, told_together};
use super::triangle::{Triangle, TriangleWords};
use super::verdict::{WeightedWorst, WorstSample};

/// Pieces a band is cut into for each thread: one that is done early takes what others have left. A triangle is set up anew in
/// each piece.
pub(super) const TASKS: usize = 4;

/// The surfaces of a batch of triangles, and the first and the last row that each touches. It is used again for the next batch:
/// memory that each thread allocates in turn is given back to the system by none.
#[derive(Default)]
pub(super) struct Planes {
    planes: Vec<Plane>,
    extents: Vec<(i64, i64)>,
}

impl Planes {
    /// The surfaces.
    pub(super) fn all(&self) -> &[Plane] {
        &self.planes
    }
}

/// What is used for one band after the other.
#[derive(Default)]
pub(super) struct Buffers {
    marks: Vec<u8>,
    errors: Vec<f32>,
    of_tasks: Mutex<Vec<Vec<f32>>>,
}

/// Some rows of samples and what is known about them.
pub(super) struct Band<'s> {
    grid: Grid,
    tolerance: f64,
    /// The first row, and the first one after.
    pub(super) rows: (i64, i64),
    pub(super) samples: Samples<'s>,
    /// What has happened to each sample, see [`mark`].
    pub(super) marks: Vec<u8>,
    tallies: Vec<RowTally>,
    /// What an observer is told of each, where that is held for all of them; else empty.
    errors: Vec<f32>,
    /// Buffers for the same that no task has at the moment.
    of_tasks: Mutex<Vec<Vec<f32>>>,
}

impl<'s> Band<'s> {
    pub(super) fn new(
        (grid, tolerance): (Grid, f64),
        first_row: i64,
        samples: Samples<'s>,
        Buffers { mut marks, mut errors, of_tasks }: Buffers,
    ) -> Self {
        let lines = samples.heights.par_chunks(grid.width as usize);
        let tallies: Vec<RowTally> = lines.map(RowTally::new).collect();
        marks.clear();
        marks.resize(samples.heights.len(), 0);
        errors.clear();
        let rows = (first_row, first_row + tallies.len() as i64);
        Band { grid, tolerance, rows, samples, marks, tallies, errors, of_tasks }
    }

    /// Holds errors from now on, until all triangles have passed.
    pub(super) fn hold_errors(&mut self) {
        self.errors.resize(self.samples.heights.len(), f32::NAN);
    }

    /// The buffers.
    pub(super) fn into_buffers(self) -> Buffers {
        Buffers { marks: self.marks, errors: self.errors, of_tasks: self.of_tasks }
    }

    /// What an observer is told of the band, once it has been told of its rows; given its heights, and those of the row above.
    pub(super) fn observed<'o>(&'o self, heights: &'o [f64], above: &'o [f64]) -> ObservedRows<'o> {
        ObservedRows {
            first_row: self.rows.0 as usize,
            width: self.grid.width as usize,
            heights,
            above,
            weights: self.samples.weights,
            errors: &self.errors,
            marks: &self.marks,
        }
    }

    /// Holds a batch of triangles, in the order of their first rows, against the band. What is in `planes` is replaced. With the last
    /// batch comes who is to be told of the rows, if somebody is.
    pub(super) fn compare(&mut self, batch: &[TriangleWords], planes: &mut Planes, told: Option<&Told<'_>>) {
        let (grid, tolerance, top, width) = (self.grid, self.tolerance, self.rows.0, self.grid.width as usize);
        let read = |words| {
            let triangle = Triangle::from_words(words);
            (Plane::new(triangle, tolerance), triangle.rows(&grid))
        };
        let Planes { planes, extents } = planes;
        batch.par_iter().map(read).unzip_into_vecs(planes, extents);
        let (planes, extents) = (&*planes, &*extents);
        let is_told = told.is_some_and(|told| told.observer.is_some());
        let together = if is_told || !self.errors.is_empty() { told_together(width) } else { 1 };
        let rows = self.tallies.len().div_ceil(TASKS * rayon::current_num_threads()).next_multiple_of(together);
        let tasks = self.tallies.par_chunks_mut(rows).zip(self.marks.par_chunks_mut(rows * width));
        let mut errors: Vec<&mut [f32]> = self.errors.chunks_mut(rows * width).collect();
        let is_brief = is_told && errors.is_empty();
        errors.resize_with(tasks.len(), Default::default);
        let (samples, idle) = (self.samples, || self.of_tasks.lock().unwrap_or_else(PoisonError::into_inner));
        tasks.zip(errors).enumerate().for_each(|(task, ((tallies, marks), errors))| {
            let first = task * rows;
            let samples = samples.part(first * width..first * width + marks.len());
            let mut brief = if is_brief { idle().pop().unwrap_or_default() } else { Vec::new() };
            brief.resize(if is_brief { marks.len() } else { 0 }, f32::NAN);
            let errors = if is_brief { &mut brief } else { errors };
            let mut task = Task { top: top + first as i64, first, width, samples, tallies, marks, errors };
            task.compare(planes, extents);
            told.iter().for_each(|told| task.tell(told));
            if is_brief {
                idle().push(brief);
            }
        });
    }

    /// Adds what has been found about the rows, once all their triangles have passed.
    pub(super) fn add_to(&self, comparison: &mut Comparison) {
        let width = self.grid.width as usize;
        for ((row, marks), tally) in (self.rows.0..).zip(self.marks.chunks(width)).zip(&self.tallies) {
            let place = |column: usize| self.grid.sample(column as i64, row);
            // Nothing is wrong most often, and that is soon known.
            let all = marks.iter().fold(0, |all, mark| all | mark);
            let wrong = if all & mark::WRONG == 0 { &[] } else { marks };
            for (column, mark) in wrong.iter().enumerate() {
                if mark & mark::OVERLAP != 0 {
                    comparison.overlapped.add(|| place(column));
                }
                if mark & mark::ABOVE != 0 {
                    comparison.above.add(|| place(column));
                }
            }
            if let Some((column, face)) = tally.touched {
                let count = marks.iter().filter(|mark| **mark & mark::TOUCHED != 0).count() as u64;
                comparison.touched.add_all(count, || TouchPlace { sample: place(column as usize), face });
            }
            if tally.range[0] <= tally.range[1] {
                let [min, max] = comparison.range.unwrap_or(tally.range);
                comparison.range = Some([min.min(tally.range[0]), max.max(tally.range[1])]);
            }
            comparison.covered += tally.covered;
            comparison.sum_of_squares += tally.sum_of_squares;
            if let Some(worst) = tally.worst
                && comparison.worst.is_none_or(|w| worst.judged.error > w.error)
            {
                comparison.worst = Some(self.worst_sample(row, worst));
            }
            if let (Some(worst), Some(weights)) = (tally.weighted_worst, self.samples.weights)
                && comparison.weighted_worst.is_none_or(|w| worst.judged.counted > w.weighted_error)
            {
                comparison.weighted_worst = Some(WeightedWorst {
                    weighted_error: worst.judged.counted,
                    weight: weights[self.index(row, worst.column)],
                    sample: self.worst_sample(row, worst),
                });
            }
        }
    }

    fn index(&self, row: i64, column: i64) -> usize {
        ((row - self.rows.0) * self.grid.width + column) as usize
    }

    fn worst_sample(&self, row: i64, worst: Worst) -> WorstSample {
        WorstSample {
            error: worst.judged.error,
            place: self.grid.sample(worst.column, row),
            raster_height: self.samples.heights[self.index(row, worst.column)],
            surface_height: worst.judged.surface,
            face: worst.face,
        }
    }
}
