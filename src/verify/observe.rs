//! What a sweep tells to somebody who wants more than a verdict: every face once, and every row with its errors.

use super::row::mark;

/// Is told what a mesh comes to at every sample, while it is judged.
///
/// Vertices come first, then faces, both in the order of the file, then rows, some at a time, from the first row of the raster to the last. The
/// calls and their values are the same whatever the threads.
pub trait Observer: Send {
    /// A vertex that is somewhere, by its place in quarters of cells as [`Observer::face`] has it, and its height.
    fn vertex(&mut self, _place: (i64, i64), _height: f64) {}

    /// A face that has an area, by its corners in quarters of cells: columns and rows, from the first sample, and their heights.
    fn face(&mut self, corners: [(i64, i64); 3], heights: [f64; 3]);

    /// Who is told of rows while they are in the cache of the thread that has judged them, if somebody is.
    fn row_observer(&self) -> Option<&dyn RowObserver> {
        None
    }

    /// Whether [`Observer::rows`] has to know errors. Otherwise they are held for the row observer alone, most often for a few rows.
    fn needs_errors(&self) -> bool {
        true
    }

    /// The next rows, after the [`Observer::row_observer`] has been told of them. There may be no errors where none are needed.
    ///
    /// # Errors
    /// Whatever keeps the observer from going on; it ends the run as [`super::VerifyError::Observer`].
    fn rows(&mut self, rows: &ObservedRows<'_>) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;
}

/// Is told of rows by the threads that have judged them: a few at a time, each once, in any order. Which rows come together depends on
/// the raster alone.
pub trait RowObserver: Sync {
    /// Some rows.
    fn rows(&self, rows: &ObservedRows<'_>);
}

/// Whole rows of samples and their errors.
#[derive(Debug, Clone, Copy)]
pub struct ObservedRows<'r> {
    /// The first row, from 0.
    pub first_row: usize,
    /// Samples in a row.
    pub width: usize,
    /// The heights of the samples, row by row; NaN where there is none, or outside of outlines that the mesh is to end at.
    pub heights: &'r [f64],
    /// Those of the row above the first one; none where that is the raster's first.
    pub above: &'r [f64],
    /// Their weights, where errors are weighted.
    pub weights: Option<&'r [f64]>,
    /// The height of the surface less that of the sample, to the nearest single float; NaN where there is no surface or no height. Where
    /// several faces lie over a sample it is that of the one farthest from it.
    pub errors: &'r [f32],
    /// What has happened to each, see [`mark`].
    pub(super) marks: &'r [u8],
}

impl<'r> ObservedRows<'r> {
    /// Rows for the tests of observers, those above the tolerance marked by `ABOVE`, from the arrays of all rows of a raster.
    #[cfg(test)]
    pub(crate) fn marked(
        rows: std::ops::Range<usize>,
        width: usize,
        (heights, errors, marks): (&'r [f64], &'r [f32], &'r [u8]),
    ) -> ObservedRows<'r> {
        let samples = rows.start * width..rows.end * width;
        ObservedRows {
            first_row: rows.start,
            width,
            heights: &heights[samples.clone()],
            above: &heights[samples.start.saturating_sub(width)..samples.start],
            weights: None,
            errors: &errors[samples.clone()],
            marks: &marks[samples],
        }
    }

    #[cfg(test)]
    pub(crate) const ABOVE: u8 = mark::ABOVE;

    /// Whether what is held against the tolerance is exactly above it at a sample of these.
    pub fn is_above(&self, at: usize) -> bool {
        self.marks[at] & mark::ABOVE != 0
    }

    /// Whether that is so at any of them.
    pub fn any_above(&self, samples: std::ops::Range<usize>) -> bool {
        self.marks[samples].iter().fold(0, |all, mark| all | mark) & mark::ABOVE != 0
    }
}
