//! Comparing the mesh with the samples, row by row.

use rayon::prelude::*;

use crate::base::control::{Control, Stage};

use super::VerifyError;
use super::finding::{Finding, SamplePlace, TouchPlace};
use super::grid::Grid;
use super::ground::{Ground, GroundFindings};
use super::outline::{Outline, OutlineFindings};
use super::plane::{Judged, Plane};
use super::samples::{Bands, Samples, flag};
use super::triangle::{RowSpan, TRIANGLE_WORDS, Triangle, TriangleWords};
use super::verdict::{WeightedWorst, WorstSample};
use crate::base::external::{Queue, Scratch, Sorted};

/// Triangles held against a band at a time.
const BATCH: usize = 16 << 10;
/// Pieces a band is cut into for the threads.
const TASKS: usize = 32;

/// What has happened to a sample, bit by bit.
mod mark {
    /// It lies in a closed triangle.
    pub(super) const COVERED: u8 = 1;
    /// It lies in the interior of one.
    pub(super) const INTERIOR: u8 = 2;
    /// It lies in the interior of one and in another.
    pub(super) const OVERLAP: u8 = 4;
    /// It is farther from a surface than the tolerance.
    pub(super) const ABOVE: u8 = 8;
    /// It has no height and lies in a closed triangle.
    pub(super) const TOUCHED: u8 = 16;
    pub(super) const WRONG: u8 = OVERLAP | ABOVE;
}

/// What the comparison of all samples with all triangles finds.
#[derive(Debug, Default)]
pub(super) struct Comparison {
    /// Whether errors are weighted.
    pub(super) weighted: bool,
    pub(super) worst: Option<WorstSample>,
    /// Where error × weight is largest; `None` where errors are not weighted.
    pub(super) weighted_worst: Option<WeightedWorst>,
    /// Of the error, over the covered samples.
    pub(super) sum_of_squares: f64,
    /// Samples with a height that lie in a triangle.
    pub(super) covered: u64,
    pub(super) above: Finding<SamplePlace>,
    pub(super) overlapped: Finding<SamplePlace>,
    /// Samples without a height that lie in a triangle.
    pub(super) touched: Finding<TouchPlace>,
    /// The least and the largest height.
    pub(super) range: Option<[f64; 2]>,
    pub(super) ground: GroundFindings,
    pub(super) outline: OutlineFindings,
}

/// What one row's samples add to it. Rows are worked on alone and put together in order, so that the sums come out the
/// same whatever the threads and the bands.
#[derive(Debug, Clone, Default)]
struct RowTally {
    /// Whether there are samples without a height.
    has_nodata: bool,
    covered: u64,
    sum_of_squares: f64,
    worst: Option<Worst>,
    weighted_worst: Option<Worst>,
    /// The first sample without a height in a triangle, and the first triangle there: column, face.
    touched: Option<(i64, u64)>,
}

#[derive(Debug, Clone, Copy)]
struct Worst {
    column: i64,
    judged: Judged,
    face: u64,
}

/// Holds the triangles, sorted by first row, against the samples, band by band, and the edges of the boundary against
/// that of the ground.
///
/// Memory use is constant whatever the mesh, because the triangles of a band pass by in batches, and those that reach
/// into the next band wait for it in a [`Queue`].
pub(super) fn sweep(
    mut reader: Bands<'_>,
    grid: Grid,
    triangles: Sorted<'_, TRIANGLE_WORDS>,
    mut outline: Outline<'_>,
    tolerance: f64,
    scratch: &Scratch,
    control: &Control<'_>,
) -> Result<Comparison, VerifyError> {
    let (rows, bands) = (reader.rows(), reader.count());
    let samples = grid.width as u64 * grid.height as u64;
    control.progress.begin(Stage::Compare, bands as u64, samples);
    let mut triangles = triangles.peekable();
    let mut waiting = Queue::new(scratch);
    let mut ground = Ground::new(grid);
    let mut comparison = Comparison { weighted: reader.are_weighted(), ..Comparison::default() };
    for index in 0..bands {
        control.cancel.check()?;
        let mut band = Band::new(grid, tolerance, index * rows, reader.read(index)?);
        comparison.range = widened(comparison.range, band.samples.heights);
        let mut next = Queue::new(scratch);
        for piece in std::mem::replace(&mut waiting, Queue::new(scratch)).into_pieces() {
            control.cancel.check()?;
            band.compare(&piece?, &mut next)?;
        }
        loop {
            let in_band = |t: &Result<TriangleWords, _>| t.as_ref().map_or(true, |t| (t[0] as i64) < band.rows.1);
            let mut batch = Vec::new();
            while batch.len() < BATCH {
                let Some(triangle) = triangles.next_if(in_band) else { break };
                batch.push(triangle?);
            }
            if batch.is_empty() {
                break;
            }
            control.cancel.check()?;
            band.compare(&batch, &mut next)?;
        }
        waiting = next;
        band.add_to(&mut comparison);
        outline.follow(&mut ground.settle(band.samples, |at| band.marks[at] & mark::COVERED != 0))?;
        control.progress.step(Stage::Compare, band.samples.heights.len() as u64);
    }
    control.progress.end(Stage::Compare);
    Ok(Comparison { ground: ground.found, outline: outline.found(), ..comparison })
}

/// The range of these heights and those before.
fn widened(range: Option<[f64; 2]>, heights: &[f64]) -> Option<[f64; 2]> {
    let before = range.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
    // By lanes, which the compiler makes vectors of. NaN is neither less nor larger.
    let (lanes, rest) = heights.as_chunks::<8>();
    let (mut least, mut largest) = ([before[0]; 8], [before[1]; 8]);
    for lane in lanes {
        for (i, &h) in lane.iter().enumerate() {
            least[i] = if h < least[i] { h } else { least[i] };
            largest[i] = if h > largest[i] { h } else { largest[i] };
        }
    }
    // A zero has no sign here.
    let min = least.iter().chain(rest).fold(before[0], |min, h| min.min(h + 0.0));
    let max = largest.iter().chain(rest).fold(before[1], |max, h| max.max(h + 0.0));
    (min <= max).then_some([min, max])
}

/// Some rows of samples and what is known about them.
struct Band<'s> {
    grid: Grid,
    tolerance: f64,
    /// The first row, and the first one after.
    rows: (i64, i64),
    samples: Samples<'s>,
    marks: Vec<u8>,
    tallies: Vec<RowTally>,
}

impl<'s> Band<'s> {
    fn new(grid: Grid, tolerance: f64, first_row: usize, samples: Samples<'s>) -> Self {
        let lines = samples.heights.par_chunks(grid.width as usize);
        let tally = |line: &[f64]| RowTally { has_nodata: line.iter().any(|h| h.is_nan()), ..RowTally::default() };
        let tallies: Vec<RowTally> = lines.map(tally).collect();
        Band {
            grid,
            tolerance,
            rows: (first_row as i64, (first_row + tallies.len()) as i64),
            samples,
            marks: vec![0; samples.heights.len()],
            tallies,
        }
    }

    /// Holds a batch of triangles against the band; those that go on below it are handed to `next`.
    fn compare(&mut self, batch: &[TriangleWords], next: &mut Queue<'_, TRIANGLE_WORDS>) -> Result<(), VerifyError> {
        let (grid, tolerance, band_rows) = (self.grid, self.tolerance, self.rows);
        let planes: Vec<(Plane, (i64, i64))> = batch
            .par_iter()
            .map(|words| {
                let triangle = Triangle::from_words(words);
                (Plane::new(triangle, tolerance), triangle.rows(&grid))
            })
            .collect();
        for (words, (_, (_, last))) in batch.iter().zip(&planes) {
            if *last >= band_rows.1 {
                next.push(*words)?;
            }
        }
        let width = grid.width as usize;
        let rows = self.tallies.len().div_ceil(TASKS);
        let tasks = self.tallies.par_chunks_mut(rows).zip(self.marks.par_chunks_mut(rows * width));
        let samples = self.samples;
        tasks.enumerate().for_each(|(task, (tallies, marks))| {
            let first_sample = task * rows * width;
            let samples = samples.part(first_sample..first_sample + marks.len());
            let top = band_rows.0 + (task * rows) as i64;
            let bottom = top + tallies.len() as i64;
            for (plane, (first, last)) in &planes {
                for row in top.max(*first)..bottom.min(last + 1) {
                    let Some(span) = plane.triangle.row_span(row, grid.width) else { continue };
                    let at = (row - top) as usize;
                    let line = at * width..(at + 1) * width;
                    compare_row(plane, row, &span, samples.part(line.clone()), &mut marks[line], &mut tallies[at]);
                }
            }
        });
        Ok(())
    }

    /// Adds what has been found about the rows, once all their triangles have passed.
    fn add_to(&self, comparison: &mut Comparison) {
        let width = self.grid.width as usize;
        for ((row, marks), tally) in (self.rows.0..).zip(self.marks.chunks(width)).zip(&self.tallies) {
            let place = |column: usize| self.grid.sample(column as i64, row);
            for (column, mark) in marks.iter().enumerate().filter(|(_, mark)| **mark & mark::WRONG != 0) {
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

/// Judges the samples of one row in one triangle.
fn compare_row(plane: &Plane, row: i64, span: &RowSpan, samples: Samples<'_>, marks: &mut [u8], tally: &mut RowTally) {
    let columns = span.closed.0..=span.closed.1;
    let is_bridged = move |column: i64| samples.flags(column as usize) & flag::BRIDGED != 0;
    let has_nodata = tally.has_nodata;
    let missing = |bridged: bool| {
        let searched = columns.clone().take_while(move |_| has_nodata);
        searched.filter(move |&c| samples.heights[c as usize].is_nan() && is_bridged(c) == bridged)
    };
    let mut touched = tally.touched;
    for column in missing(false) {
        marks[column as usize] |= mark::TOUCHED;
        let here = (column, plane.triangle.face);
        touched = Some(touched.map_or(here, |first| first.min(here)));
    }
    let mut note = |column: i64, within: bool| {
        let mark = &mut marks[column as usize];
        let before = *mark;
        let interior = span.interior.0 <= column && column <= span.interior.1;
        let overlap = if interior { before != 0 } else { before & mark::INTERIOR != 0 };
        *mark |= mark::COVERED
            | if interior { mark::INTERIOR } else { 0 }
            | if overlap { mark::OVERLAP } else { 0 }
            | if within { 0 } else { mark::ABOVE };
        before == 0
    };
    // There is no height to be held against the surface, but the ground is to be covered, once.
    for column in missing(true) {
        note(column, true);
    }
    tally.touched = touched;
    if !plane.has_heights() {
        for column in columns.filter(|&c| !samples.heights[c as usize].is_nan()) {
            tally.covered += u64::from(note(column, false));
        }
        return;
    }
    let slack = plane.slack();
    plane.judge_row(row, span, samples, |column, judged| {
        // A sample on an edge is in two triangles, whose surfaces agree there: it counts once.
        if note(column, judged.within) {
            tally.covered += 1;
            tally.sum_of_squares += judged.error * judged.error;
        }
        let judged = refined(plane, slack, (column, row), samples, tally, judged);
        let here = Worst { column, judged, face: plane.triangle.face };
        let beats = |w: &Worst| (judged.error, w.column) > (w.judged.error, column);
        if tally.worst.as_ref().is_none_or(beats) {
            tally.worst = Some(here);
        }
        let counts_more = |w: &Worst| (judged.counted, w.column) > (w.judged.counted, column);
        if samples.weights.is_some() && tally.weighted_worst.as_ref().is_none_or(counts_more) {
            tally.weighted_worst = Some(here);
        }
    });
}

/// The judgement of a sample that may be the worst of its row so far, with its error rounded correctly; another as it is.
/// `slack` is the plane's.
#[inline(always)]
fn refined(
    plane: &Plane,
    slack: f64,
    (column, row): (i64, i64),
    samples: Samples<'_>,
    tally: &RowTally,
    judged: Judged,
) -> Judged {
    let worst = tally.worst.as_ref().map_or(f64::NEG_INFINITY, |w| w.judged.error);
    let error = judged.error + slack;
    if samples.weights.is_none() && error < worst || slack == 0.0 {
        return judged;
    }
    let weight = samples.weights.map(|weights| weights[column as usize]);
    // What counts for the tolerance is, within it, no worse than what is at it.
    let is_settled = |counted: f64| judged.within && counted >= plane.tolerance();
    let is_worse = error >= worst && !(weight.is_none() && is_settled(worst));
    let counted = tally.weighted_worst.as_ref().map_or(f64::NEG_INFINITY, |w| w.judged.counted);
    let weighs_more = weight.is_some_and(|weight| error * weight >= counted && !is_settled(counted));
    if !(is_worse || weighs_more) {
        return judged;
    }
    plane.refined(column, row, samples.heights[column as usize], weight, judged)
}
