//! What errors are allowed along a line: the same everywhere, or one for each sample.

/// The largest vertical error allowed at each sample of a line.
#[derive(Debug, Clone, Copy)]
pub enum Limits<'a> {
    /// The same everywhere.
    Same(f64),
    /// One for every sample.
    Each(&'a [f64]),
}

impl From<f64> for Limits<'_> {
    fn from(tolerance: f64) -> Self {
        Limits::Same(tolerance)
    }
}

impl<'a> From<&'a [f64]> for Limits<'a> {
    fn from(limits: &'a [f64]) -> Self {
        Limits::Each(limits)
    }
}

/// [`Limits`] of a section of the line, as the search reads them.
pub(super) trait Allowed: Copy {
    /// The limit at a sample.
    fn at(&self, sample: usize) -> f64;
    /// No limit is larger.
    fn largest(&self) -> f64;
}

impl Allowed for f64 {
    #[inline(always)]
    fn at(&self, _: usize) -> f64 {
        *self
    }
    fn largest(&self) -> f64 {
        *self
    }
}

/// Limits of samples, but none above `cap`: twice the greatest magnitude of the heights, farther than which no sample is
/// from any link. It keeps the bound of rounding small where a sample is free.
#[derive(Clone, Copy)]
pub(super) struct Capped<'a> {
    limits: &'a [f64],
    cap: f64,
}

impl<'a> Capped<'a> {
    /// Limits of samples whose heights are at most `highest` in magnitude.
    pub(super) fn new(limits: &'a [f64], highest: f64) -> Capped<'a> {
        Capped { limits, cap: 2.0 * highest }
    }
}

impl Allowed for Capped<'_> {
    #[inline(always)]
    fn at(&self, sample: usize) -> f64 {
        self.limits[sample].min(self.cap)
    }
    fn largest(&self) -> f64 {
        self.cap
    }
}
