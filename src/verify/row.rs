//! One row of samples in one triangle.

use super::line::Line;
use super::plane::{Judged, Plane};
use super::samples::{Samples, flag};
use super::triangle::RowSpan;

/// What has happened to a sample, bit by bit.
pub(super) mod mark {
    /// It lies in a closed triangle.
    pub(crate) const COVERED: u8 = 1;
    /// It lies in the interior of one.
    pub(crate) const INTERIOR: u8 = 2;
    /// It lies in the interior of one and in another.
    pub(crate) const OVERLAP: u8 = 4;
    /// It is farther from a surface than the tolerance.
    pub(crate) const ABOVE: u8 = 8;
    /// It has no height and lies in a closed triangle.
    pub(crate) const TOUCHED: u8 = 16;
    pub(crate) const WRONG: u8 = OVERLAP | ABOVE;
}

/// What one row's samples add to the comparison. Rows are worked on alone and put together in order, so that the sums come out the
/// same whatever the threads and the bands.
#[derive(Debug, Clone)]
pub(super) struct RowTally {
    /// The least and the largest height; the other way round where there is none.
    pub(super) range: [f64; 2],
    /// Whether there are samples without a height.
    pub(super) has_nodata: bool,
    pub(super) covered: u64,
    pub(super) sum_of_squares: f64,
    pub(super) worst: Option<Worst>,
    pub(super) weighted_worst: Option<Worst>,
    /// The first sample without a height in a triangle, and the first triangle there: column, face.
    pub(super) touched: Option<(i64, u64)>,
}

/// The sample of a row that a tally has found to be the worst.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worst {
    pub(super) column: i64,
    pub(super) judged: Judged,
    pub(super) face: u64,
}

/// The one of two errors that is farther from 0; any is farther than none.
fn farther(before: f32, found: f32) -> f32 {
    if before.abs() >= found.abs() { before } else { found }
}

/// A row, and what is known of it so far.
pub(super) struct Row<'b> {
    pub(super) samples: Samples<'b>,
    pub(super) marks: &'b mut [u8],
    pub(super) tally: &'b mut RowTally,
    /// What an observer is told, see [`super::ObservedRows::errors`], where there is one. What stands there of samples that no triangle
    /// has passed is left over from other rows.
    pub(super) errors: Option<&'b mut [f32]>,
}

impl Row<'_> {
    /// Judges the samples in one triangle.
    pub(super) fn compare(&mut self, plane: &Plane, row: i64, span: &RowSpan) {
        let line = plane.line(row, span);
        let ((first, last), (inner_first, inner_last)) = (span.closed, span.interior);
        if !self.is_new(span) {
            return self.judge(plane, &line, span, (first, last));
        }
        let Some(largest) = self.pass_interior(plane, &line, span) else {
            return self.judge(plane, &line, span, (first, last));
        };
        self.judge(plane, &line, span, (first, inner_first - 1));
        if self.tally.worst.is_none_or(|worst| largest + plane.slack() >= worst.judged.error) {
            let (samples, tally) = (self.samples, &mut *self.tally);
            plane.judge_line(&line, (inner_first, inner_last), samples, |column, judged| {
                tally.weigh(plane, (column, row), samples, judged);
            });
        }
        self.judge(plane, &line, span, (inner_last + 1, last));
    }

    /// Whether there are samples in the triangle's interior, whose errors count as they are, and none of them was in a triangle before.
    fn is_new(&self, span: &RowSpan) -> bool {
        let (first, last) = span.interior;
        let marks = || &self.marks[first as usize..=last as usize];
        let (weights, intervals) = (self.samples.weights, self.samples.intervals);
        let are_plain = weights.is_none() && intervals.is_none();
        first <= last && are_plain && marks().iter().fold(0, |all, mark| all | mark) == 0
    }

    /// Marks and counts the samples in the triangle's interior, which are new, and gives their largest error, if all have a height and
    /// are within the tolerance for sure. If that is not so, only their errors are noted.
    fn pass_interior(&mut self, plane: &Plane, line: &Line, span: &RowSpan) -> Option<f64> {
        let (first, last) = span.interior;
        let columns = first as usize..=last as usize;
        let samples = &self.samples.heights[columns.clone()];
        let errors = match self.errors.as_deref_mut() {
            // No triangle was there whose error might be farther from 0.
            Some(errors) => line.errors_into(first, samples, &mut errors[columns.clone()]),
            None => line.errors(first, samples),
        };
        if errors.sum_of_squares.is_nan() || !plane.is_surely_within(errors.largest) {
            return None;
        }
        let marks = &mut self.marks[columns];
        marks.fill(mark::COVERED | mark::INTERIOR);
        self.tally.covered += marks.len() as u64;
        self.tally.sum_of_squares += errors.sum_of_squares;
        Some(errors.largest)
    }

    /// Judges each of these samples of the span, first and last column, by itself.
    fn judge(&mut self, plane: &Plane, line: &Line, span: &RowSpan, columns: (i64, i64)) {
        let (samples, marks, tally) = (self.samples, &mut *self.marks, &mut *self.tally);
        let mut errors = self.errors.as_deref_mut();
        if columns.0 > columns.1 {
            return;
        }
        let range = columns.0..=columns.1;
        let is_bridged = |column: i64| samples.flags(column as usize) & flag::BRIDGED != 0;
        let has_nodata = tally.has_nodata;
        let missing = range.clone().take_while(|_| has_nodata).filter(|&c| samples.heights[c as usize].is_nan());
        for column in missing.clone().filter(|&c| !is_bridged(c)) {
            marks[column as usize] |= mark::TOUCHED;
            let here = (column, plane.triangle.face);
            tally.touched = Some(tally.touched.map_or(here, |first| first.min(here)));
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
        for column in missing.filter(|&c| is_bridged(c)) {
            if note(column, true) {
                errors.iter_mut().for_each(|errors| errors[column as usize] = f32::NAN);
            }
        }
        if !plane.has_heights() {
            for column in range.filter(|&c| !samples.heights[c as usize].is_nan()) {
                if note(column, false) {
                    tally.covered += 1;
                    errors.iter_mut().for_each(|errors| errors[column as usize] = f32::NAN);
                }
            }
            return;
        }
        plane.judge_line(line, columns, samples, |column, judged| {
            // A sample on an edge is in two triangles, whose surfaces agree there: it counts once.
            let is_first = note(column, judged.within);
            if is_first {
                tally.covered += 1;
                tally.sum_of_squares += judged.error * judged.error;
            }
            if let Some(errors) = &mut errors {
                let (column, at) = (column as usize, judged.surface);
                let error = judged.error.copysign(at - samples.heights[column]) as f32;
                errors[column] = if is_first { error } else { farther(errors[column], error) };
            }
            tally.weigh(plane, (column, line.row), samples, judged);
        });
    }
}

impl RowTally {
    /// Of a row whose samples no triangle has passed.
    pub(super) fn new(heights: &[f64]) -> RowTally {
        // By lanes, which the compiler makes vectors of. NaN is neither less nor larger.
        let (lanes, rest) = heights.as_chunks::<8>();
        let (mut least, mut largest, mut has_nodata) = ([f64::INFINITY; 8], [f64::NEG_INFINITY; 8], false);
        for lane in lanes {
            for (i, &h) in lane.iter().enumerate() {
                least[i] = if h < least[i] { h } else { least[i] };
                largest[i] = if h > largest[i] { h } else { largest[i] };
                has_nodata |= h.is_nan();
            }
        }
        has_nodata |= rest.iter().any(|h| h.is_nan());
        // A zero has no sign here.
        let min = least.iter().chain(rest).fold(f64::INFINITY, |min, h| min.min(h + 0.0));
        let max = largest.iter().chain(rest).fold(f64::NEG_INFINITY, |max, h| max.max(h + 0.0));
        let (worst, weighted_worst, touched) = (None, None, None);
        let range = [min, max];
        RowTally { range, has_nodata, covered: 0, sum_of_squares: 0.0, worst, weighted_worst, touched }
    }

    /// Keeps the sample if it is the worst so far.
    fn weigh(&mut self, plane: &Plane, (column, row): (i64, i64), samples: Samples<'_>, judged: Judged) {
        let judged = self.refined(plane, (column, row), samples, judged);
        let here = Worst { column, judged, face: plane.triangle.face };
        let beats = |w: &Worst| (judged.error, w.column) > (w.judged.error, column);
        if self.worst.as_ref().is_none_or(beats) {
            self.worst = Some(here);
        }
        let counts_more = |w: &Worst| (judged.counted, w.column) > (w.judged.counted, column);
        if samples.weights.is_some() && self.weighted_worst.as_ref().is_none_or(counts_more) {
            self.weighted_worst = Some(here);
        }
    }

    /// The judgement of a sample that may be the worst of its row so far, with its error rounded correctly; another as it is.
    #[inline(always)]
    fn refined(&self, plane: &Plane, (column, row): (i64, i64), samples: Samples<'_>, judged: Judged) -> Judged {
        if samples.interval(column as usize).is_some() {
            return judged;
        }
        let slack = plane.slack();
        let worst = self.worst.as_ref().map_or(f64::NEG_INFINITY, |w| w.judged.error);
        let error = judged.error + slack;
        if samples.weights.is_none() && error < worst || slack == 0.0 {
            return judged;
        }
        let weight = samples.weights.map(|weights| weights[column as usize]);
        // What counts for the tolerance is, within it, no worse than what is at it.
        let is_settled = |counted: f64| judged.within && counted >= plane.tolerance();
        let is_worse = error >= worst && !(weight.is_none() && is_settled(worst));
        let counted = self.weighted_worst.as_ref().map_or(f64::NEG_INFINITY, |w| w.judged.counted);
        let weighs_more = weight.is_some_and(|weight| error * weight >= counted && !is_settled(counted));
        if !(is_worse || weighs_more) {
            return judged;
        }
        plane.refined(column, row, samples.heights[column as usize], weight, judged)
    }
}
