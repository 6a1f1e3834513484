//! Some rows of samples, and triangles held against them by all threads.

use rayon::prelude::*;

use super::finding::TouchPlace;
use super::grid::Grid;
use super::observe::ObservedRows;
use super::plane::Plane;
use super::row::{Row, RowTally, Worst, mark};
use super::samples::Samples;
use super::spans::Spans;
use super::sweep::Comparison;
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
    /// What an observer is told of each, where there is one; else empty.
    errors: Vec<f32>,
}

impl<'s> Band<'s> {
    pub(super) fn new(grid: Grid, tolerance: f64, first_row: i64, samples: Samples<'s>) -> Self {
        let lines = samples.heights.par_chunks(grid.width as usize);
        let tallies: Vec<RowTally> = lines.map(RowTally::new).collect();
        Band {
            grid,
            tolerance,
            rows: (first_row, first_row + tallies.len() as i64),
            samples,
            marks: vec![0; samples.heights.len()],
            tallies,
            errors: Vec::new(),
        }
    }

    /// The same for an observer, with a buffer that is used for one band after the other.
    pub(super) fn observed_in(self, mut errors: Vec<f32>) -> Self {
        errors.resize(self.samples.heights.len(), f32::NAN);
        Band { errors, ..self }
    }

    /// The buffer.
    pub(super) fn into_buffer(self) -> Vec<f32> {
        self.errors
    }

    /// What an observer is told, once all triangles have passed.
    pub(super) fn observed(&mut self) -> ObservedRows<'_> {
        let width = self.grid.width as usize;
        let rows = self.errors.chunks_mut(width).zip(self.marks.chunks(width)).zip(&self.tallies);
        for ((errors, marks), _) in rows.filter(|(_, tally)| tally.covered < width as u64) {
            for (error, mark) in errors.iter_mut().zip(marks) {
                *error = if mark & mark::COVERED == 0 { f32::NAN } else { *error };
            }
        }
        ObservedRows {
            first_row: self.rows.0 as usize,
            width,
            heights: self.samples.heights,
            weights: self.samples.weights,
            errors: &self.errors,
            marks: &self.marks,
        }
    }

    /// Holds a batch of triangles, in the order of their first rows, against the band. What is in `planes` is replaced.
    pub(super) fn compare(&mut self, batch: &[TriangleWords], planes: &mut Planes) {
        let (grid, tolerance, top) = (self.grid, self.tolerance, self.rows.0);
        let read = |words| {
            let triangle = Triangle::from_words(words);
            (Plane::new(triangle, tolerance), triangle.rows(&grid))
        };
        let Planes { planes, extents } = planes;
        batch.par_iter().map(read).unzip_into_vecs(planes, extents);
        let (planes, extents) = (&*planes, &*extents);
        let width = grid.width as usize;
        let rows = self.tallies.len().div_ceil(TASKS * rayon::current_num_threads());
        let tasks = self.tallies.par_chunks_mut(rows).zip(self.marks.par_chunks_mut(rows * width));
        let mut errors: Vec<Option<&mut [f32]>> = self.errors.chunks_mut(rows * width).map(Some).collect();
        errors.resize_with(tasks.len(), || None);
        let samples = self.samples;
        tasks.zip(errors).enumerate().for_each(|(task, ((tallies, marks), mut errors))| {
            let first_sample = task * rows * width;
            let samples = samples.part(first_sample..first_sample + marks.len());
            let top = top + (task * rows) as i64;
            let bottom = top + tallies.len() as i64;
            let begun = extents.partition_point(|(first, _)| *first < bottom);
            for (at, (first, last)) in extents[..begun].iter().enumerate().filter(|(_, (_, last))| *last >= top) {
                let (plane, first) = (&planes[at], top.max(*first));
                let mut spans = Spans::new(&plane.triangle, first);
                for row in first..bottom.min(last + 1) {
                    let Some(span) = spans.next(grid.width) else { continue };
                    let at = (row - top) as usize;
                    let line = at * width..(at + 1) * width;
                    let errors = errors.as_deref_mut().map(|errors| &mut errors[line.clone()]);
                    let (samples, marks) = (samples.part(line.clone()), &mut marks[line]);
                    Row { samples, marks, tally: &mut tallies[at], errors }.compare(plane, row, &span);
                }
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
