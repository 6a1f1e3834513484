//! Some rows of a band, held against triangles by one thread.

use super::observe::{ObservedRows, RowObserver};
use super::plane::Plane;
use super::row::{Row, RowTally, mark};
use super::samples::Samples;
use super::spans::Spans;

/// Samples of rows that an observer is told of together, about.
const TOLD: usize = 1 << 15;

/// Who is told of the rows of a band once all triangles have passed, and what of their heights.
#[derive(Clone, Copy)]
pub(super) struct Told<'t> {
    pub(super) observer: Option<&'t dyn RowObserver>,
    /// Of all rows of the band.
    pub(super) heights: &'t [f64],
    /// Of the row above.
    pub(super) above: &'t [f64],
}

/// How many rows of this number of samples an observer is told of together.
pub(super) fn told_together(width: usize) -> usize {
    (TOLD / width).max(1)
}

/// Some rows.
pub(super) struct Task<'t> {
    /// The first one in the raster, and in the band.
    pub(super) top: i64,
    pub(super) first: usize,
    pub(super) width: usize,
    pub(super) samples: Samples<'t>,
    pub(super) tallies: &'t mut [RowTally],
    pub(super) marks: &'t mut [u8],
    /// What an observer is told; nothing where there is none.
    pub(super) errors: &'t mut [f32],
}

impl Task<'_> {
    /// Holds triangles, in the order of their first rows, against the rows. `extents` are the first and the last row of each.
    pub(super) fn compare(&mut self, planes: &[Plane], extents: &[(i64, i64)]) {
        let (top, width) = (self.top, self.width);
        let bottom = top + self.tallies.len() as i64;
        let begun = extents.partition_point(|(first, _)| *first < bottom);
        for (at, (first, last)) in extents[..begun].iter().enumerate().filter(|(_, (_, last))| *last >= top) {
            let (plane, first) = (&planes[at], top.max(*first));
            let mut spans = Spans::new(&plane.triangle, first);
            for row in first..bottom.min(last + 1) {
                let Some(span) = spans.next(width as i64) else { continue };
                let at = (row - top) as usize;
                let line = at * width..(at + 1) * width;
                let (samples, marks) = (self.samples.part(line.clone()), &mut self.marks[line.clone()]);
                let (tally, errors) = (&mut self.tallies[at], self.errors.get_mut(line));
                Row { samples, marks, tally, errors }.compare(plane, row, &span);
            }
        }
    }

    /// Tells an observer of the rows, once all triangles have passed.
    pub(super) fn tell(&mut self, told: &Told<'_>) {
        let width = self.width;
        let rows = self.errors.chunks_mut(width).zip(self.marks.chunks(width)).zip(&*self.tallies);
        for ((errors, marks), _) in rows.filter(|(_, tally)| tally.covered < width as u64) {
            for (error, mark) in errors.iter_mut().zip(marks) {
                *error = if mark & mark::COVERED == 0 { f32::NAN } else { *error };
            }
        }
        let Some(observer) = told.observer else { return };
        let together = told_together(width);
        for from in (0..self.tallies.len()).step_by(together) {
            let rows = from..(from + together).min(self.tallies.len());
            let samples = rows.start * width..rows.end * width;
            let in_band = (self.first + rows.start) * width..(self.first + rows.end) * width;
            observer.rows(&ObservedRows {
                first_row: self.top as usize + rows.start,
                width,
                heights: &told.heights[in_band.clone()],
                above: match in_band.start {
                    0 => told.above,
                    start => &told.heights[start - width..start],
                },
                weights: self.samples.weights.map(|weights| &weights[samples.clone()]),
                errors: &self.errors[samples.clone()],
                marks: &self.marks[samples],
            });
        }
    }
}
