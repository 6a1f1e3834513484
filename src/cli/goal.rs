//! `simplify`: what a mesh is to come to.

use super::combinations::Asked;
use super::values;
use crate::base::features::Feature;
use crate::job::Goal;

/// The tolerance and what may stand beside it or in its place: one of them is needed.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = true)]
pub(super) struct GoalArgs {
    /// The largest vertical distance allowed between mesh and samples, in the units of the heights; 0 is exact
    #[arg(long, help_heading = "Mesh", value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    pub(super) max_error: Option<f64>,
    /// The root mean square of the distances to reach, with as few triangles as --quality comes to
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    max_rms: Option<f64>,
    /// A budget of vertices, never exceeded: a tolerance is looked for whose mesh spends it
    #[arg(long, help_heading = "Mesh", hide_short_help = true, value_name = "N", value_parser = values::count)]
    max_points: Option<u64>,
    /// A budget of triangles, never exceeded: a tolerance is looked for whose mesh spends it, in about two runs
    #[arg(long, help_heading = "Mesh", value_name = "N", value_parser = values::count)]
    max_triangles: Option<u64>,
}

impl GoalArgs {
    /// What of this asks for features.
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::VertexBudget, self.max_points.is_some());
        asked.add(Feature::TriangleBudget, self.max_triangles.is_some());
        asked.add(Feature::RmsGoal, self.max_rms.is_some());
    }

    pub(super) fn goal(&self) -> Goal {
        Goal { max_points: self.max_points, max_triangles: self.max_triangles, max_rms: self.max_rms }
    }

    /// The tolerance; infinite where none was given.
    pub(super) fn tolerance(&self) -> f64 {
        self.max_error.unwrap_or(f64::INFINITY)
    }
}
