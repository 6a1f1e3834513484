//! What a sweep tells to somebody who wants more than a verdict: every face once, and every row with its errors.

use super::row::mark;

/// Is told what a mesh comes to at every sample, while it is judged.
///
/// Faces come first, in the order of the file, then rows, some at a time, from the first row of the raster to the last. The
/// calls and their values are the same whatever the threads.
pub trait Observer: Send {
    /// A face that has an area, by its corners in quarters of cells: columns and rows, from the first sample, and their heights.
    fn face(&mut self, corners: [(i64, i64); 3], heights: [f64; 3]);

    /// The next rows.
    ///
    /// # Errors
    /// Whatever keeps the observer from going on; it ends the run as [`super::VerifyError::Observer`].
    fn rows(&mut self, rows: &ObservedRows<'_>) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;
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
    /// Their weights, where errors are weighted.
    pub weights: Option<&'r [f64]>,
    /// The height of the surface less that of the sample, to the nearest single float; NaN where there is no surface or no height. Where
    /// several faces lie over a sample it is that of the one farthest from it.
    pub errors: &'r [f32],
    /// What has happened to each, see [`mark`].
    pub(super) marks: &'r [u8],
}

impl<'r> ObservedRows<'r> {
    /// Rows for the tests of observers, those above the tolerance marked by `ABOVE`.
    #[cfg(test)]
    pub(crate) fn marked(
        first_row: usize,
        width: usize,
        samples: (&'r [f64], &'r [f32], &'r [u8]),
    ) -> ObservedRows<'r> {
        let (heights, errors, marks) = samples;
        ObservedRows { first_row, width, heights, weights: None, errors, marks }
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
