//! `simplify`: when to stop, and how far it came.

use serde::Serialize;

use super::combinations::Asked;
use super::values;
use crate::job::features::Feature;
use crate::job::{Budget, Goal, Outcome};

/// The tolerance and what may stand beside it or in its place: one of them is needed.
#[derive(Debug, Clone, clap::Args)]
#[group(required = true, multiple = true)]
pub(super) struct GoalArgs {
    /// The largest vertical distance allowed between mesh and samples, in the units of the heights; 0 is exact
    #[arg(long, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    pub(super) max_error: Option<f64>,
    /// The root mean square of the distances that is to be reached
    #[arg(long, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    max_rms: Option<f64>,
    /// A budget of vertices: as close as they can come. Greedy insertion only, without polishing, like the next one
    /// and --max-rms
    #[arg(long, value_name = "N", value_parser = values::count)]
    max_points: Option<u64>,
    /// A budget of triangles, likewise
    #[arg(long, value_name = "N", value_parser = values::count)]
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

    /// What of this stands in the mesh's header.
    pub(super) fn comments(&self) -> Vec<String> {
        let numbers =
            [("max_error", self.max_error), ("max_rms", self.max_rms)].map(|(n, v)| (n, v.map(|v| v.to_string())));
        let counts = [("max_points", self.max_points), ("max_triangles", self.max_triangles)];
        let counts = counts.map(|(n, v)| (n, v.map(|v| v.to_string())));
        let all = numbers.into_iter().chain(counts);
        all.filter_map(|(name, value)| value.map(|value| format!("{name} {value}"))).collect()
    }
}

/// How far a run under a goal came.
#[derive(Debug, Clone, Serialize)]
pub(super) struct GoalReport {
    #[serde(flatten)]
    goal: Goal,
    /// Whether a quality was asked for, and all that were are reached.
    reached: Option<bool>,
    #[serde(flatten)]
    outcome: Outcome,
}

impl GoalReport {
    pub(super) fn new(goal: Goal, has_tolerance: bool, outcome: Outcome) -> GoalReport {
        let asked = has_tolerance || goal.max_rms.is_some();
        GoalReport { goal, reached: asked.then_some(outcome.ended_by.is_none()), outcome }
    }

    /// Whether a quality was asked for that a budget did not allow.
    pub(super) fn fell_short(&self) -> bool {
        self.reached == Some(false)
    }

    /// In words; `vertices` and `triangles` are what the mesh has.
    pub(super) fn line(&self, vertices: u64, triangles: u64) -> String {
        let (what, used, most) = match self.outcome.ended_by {
            None => return format!("reached with all errors above {} inserted", self.outcome.threshold),
            Some(Budget::MaxPoints) => ("vertices", vertices, self.goal.max_points),
            Some(Budget::MaxTriangles) => ("triangles", triangles, self.goal.max_triangles),
        };
        let most = most.unwrap_or(used);
        let short = if self.fell_short() { "; the quality that was asked for is not reached" } else { "" };
        format!(
            "ended by the budget: {used} of {most} {what}, {} not spent; errors down to {} inserted{short}",
            most - used,
            self.outcome.threshold
        )
    }
}
