//! What was found out about straying between samples.

use serde::Serialize;

use super::Verdict;
use super::finding::{Finding, SidePlace};

/// How far the surface strays from the heights of the samples around it, between samples. See
/// [`super::VerifyOptions::max_stray`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StrayVerdict {
    /// The multiple of the tolerance that was allowed.
    pub max_stray: f64,
    /// The smallest double that is the multiple of the tolerance or more; infinite (`null` in JSON) where none is.
    pub limit: f64,
    /// Sides along which the surface is beyond the limit, and cells that have vertices inside which are, each counted
    /// once.
    pub beyond: Finding<SidePlace>,
    /// Where it strays most; `None` if it strays nowhere.
    pub worst: Option<WorstStray>,
}

/// A point where the surface is beyond the heights of the samples around it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WorstStray {
    /// The vertical distance beyond the nearer one of the heights: rounded; but where errors are not weighted, at most the limit if
    /// and only if the exact distance is.
    pub stray: f64,
    /// The weight that counts there, the smallest one of the samples around it; `None` where errors are not weighted.
    pub weight: Option<f64>,
    /// Distance, or distance × weight, as a multiple of the tolerance, rounded; `None` where the tolerance is 0.
    pub tolerances: Option<f64>,
    /// The column, with a fraction.
    pub column: f64,
    /// The row, with a fraction.
    pub row: f64,
    /// Map x.
    pub x: f64,
    /// Map y.
    pub y: f64,
    /// The side it is on, or the cell it is in.
    pub side: SidePlace,
    /// The surface's height, rounded.
    pub surface_height: f64,
    /// The heights of the side's samples, the lower one first; of a cell the least and the largest.
    pub raster_heights: [f64; 2],
}

impl StrayVerdict {
    /// "30 (1.5 × 20)"
    pub(super) fn allowed(&self, tolerance: f64) -> String {
        format!("{} ({} × {tolerance})", self.limit, self.max_stray)
    }

    /// What is wrong, if something is.
    pub(super) fn failure(&self, verdict: &Verdict) -> Option<String> {
        let what = if verdict.weighted { "distance × weight is" } else { "the surface is" };
        let allowed = self.allowed(verdict.tolerance);
        let (Some(worst), count @ 1..) = (&self.worst, self.beyond.count) else { return None };
        let places = if count == 1 { "1 place:".to_string() } else { format!("{count} places, farthest:") };
        Some(format!("{what} more than {allowed} beyond the heights around, between samples, in {places} {worst}"))
    }
}

impl std::fmt::Display for StrayVerdict {
    /// The largest stray, and where it is.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.worst {
            None => write!(f, "max stray 0"),
            Some(worst) => write!(f, "max stray {worst}"),
        }
    }
}

impl std::fmt::Display for WorstStray {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let WorstStray { stray, column, row, x, y, surface_height, raster_heights: [low, high], .. } = self;
        write!(f, "{stray}")?;
        if let Some(weight) = self.weight {
            write!(f, " × weight {weight}")?;
        }
        if let Some(tolerances) = self.tolerances {
            write!(f, " ({tolerances:.3} × the tolerance)")?;
        }
        write!(f, " at column {column}, row {row} ({x} {y}): surface {surface_height}, samples {low} and {high}")
    }
}
