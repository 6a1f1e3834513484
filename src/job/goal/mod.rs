//! When to stop (the paper's GOAL_MET), for a whole raster of tiles.
//!
//! A budget of vertices or triangles, or a root mean square, is one for all tiles, and none of them can tell by itself
//! when it is met. Where meshes are polished, or made by an engine that cannot stop, a tolerance is looked for
//! ([`crate::job::search`]). Where insertion makes them one sample at a time and nothing follows, it stops in order: tiles are gone over twice. First every tile tells how its insertion would go ([`Curves`]); then
//! the place where all of them together have to stop is found ([`find_cut`]); then every tile goes as far as that. An
//! insertion's place among all is its [`crate::kernel::triangulate::progressive::Key`]. Rims are nested
//! ([`crate::kernel::seam::levels`]), so a tile can begin before anybody knows a tolerance.

mod curves;
mod cut;
mod floor;
#[cfg(test)]
mod tests;

pub(super) use curves::{Cost, Curves, Told};
pub(super) use cut::find_cut;
pub(super) use floor::Floor;

use super::search::Searched;
use crate::base::exact_double;

/// What ends the refinement beside the tolerance. Qualities (`max_rms`, and the tolerance) are to be reached, all that
/// are given; budgets end the refinement before that if need be, and are never exceeded.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct Goal {
    /// The most vertices.
    pub max_points: Option<u64>,
    /// The most triangles.
    pub max_triangles: Option<u64>,
    /// The root of the mean square error over all samples on the ground that is to be reached.
    pub max_rms: Option<f64>,
}

impl Goal {
    /// Whether the tolerance is all there is.
    pub fn is_none(&self) -> bool {
        *self == Goal::default()
    }

    /// The most triangles that a budget allows: of vertices, a mesh has fewer than twice as many.
    pub fn most_triangles(&self) -> Option<u64> {
        self.max_points.map(|most| most.saturating_mul(2)).into_iter().chain(self.max_triangles).min()
    }

    /// The share of the budget that so much spends, of the one that is spent the most.
    pub(super) fn share(&self, vertices: u64, triangles: u64) -> Option<f64> {
        let share = |most: Option<u64>, count: u64| most.map(|most| count as f64 / most as f64);
        let shares = [share(self.max_points, vertices), share(self.max_triangles, triangles)];
        shares.into_iter().flatten().reduce(f64::max)
    }

    /// What of this decides the bytes of a tile, by name.
    pub(super) fn named(&self) -> impl Iterator<Item = (&'static str, String)> + use<> {
        let points = self.max_points.map(|most| ("max points", most.to_string()));
        let triangles = self.max_triangles.map(|most| ("max triangles", most.to_string()));
        let rms = self.max_rms.map(|rms| ("max RMS error", exact_double(rms)));
        [points, triangles, rms].into_iter().flatten()
    }
}

/// How far a run under a [`Goal`] got.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Outcome {
    /// The budget that ended it before the qualities that were asked for were reached.
    pub ended_by: Option<Budget>,
    /// The error of the last insertion, what the threshold for all tiles came to; or the tolerance that was found.
    pub threshold: f64,
    /// How the tolerance was found; null where insertion stopped by itself.
    pub search: Option<Searched>,
}

/// A budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Budget {
    /// [`Goal::max_points`].
    MaxPoints,
    /// [`Goal::max_triangles`].
    MaxTriangles,
}

/// A budget is too small for what is there from the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "expected a budget of at least {smallest} {what}, found {found}: corners of tiles, outlines of voids, points and breaklines are there from the start"
)]
pub struct GoalTooSmall {
    /// Vertices or triangles.
    pub what: &'static str,
    /// The smallest budget that works with this tile size.
    pub smallest: u64,
    /// The budget.
    pub found: u64,
}
