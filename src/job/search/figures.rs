//! What meshes came to, and what of that is compared with a goal.

use serde::{Deserialize, Serialize};

use crate::job::Goal;

/// What a mesh came to.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Figures {
    /// Vertices.
    pub vertices: u64,
    /// Triangles.
    pub triangles: u64,
    /// The root of the mean square error.
    pub rms: f64,
    /// The largest error, weighted where errors are.
    pub largest: f64,
}

impl Figures {
    /// So many times as many vertices and triangles.
    pub(super) fn scaled(&self, times: f64) -> Figures {
        let count = |count: u64| (count as f64 * times).round() as u64;
        Figures { vertices: count(self.vertices), triangles: count(self.triangles), ..*self }
    }

    /// The fourth proportional: what is to `other` as these are to `one`.
    pub(super) fn in_proportion(&self, one: &Figures, other: &Figures) -> Figures {
        let count = |of: fn(&Figures) -> u64| {
            let share = of(other) as f64 / of(one).max(1) as f64;
            (of(self) as f64 * share).round() as u64
        };
        let rms = if one.rms > 0.0 { self.rms * (other.rms / one.rms) } else { self.rms };
        let (vertices, triangles) = (count(|figures| figures.vertices), count(|figures| figures.triangles));
        Figures { vertices, triangles, rms, ..*self }
    }
}

/// What a goal is about. [`Quantity::of`] a mesh grows with the tolerance, about in proportion to it, and is 1 at the goal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Quantity {
    /// How many times the mesh goes into the budgets.
    Budget { points: Option<u64>, triangles: Option<u64> },
    /// The root of the mean square error, of this one.
    Rms(f64),
}

/// What of a budget is to be spent at the least, and how far below one a root mean square may stay.
pub(super) const SHARE: f64 = 0.97;

/// What is aimed at: the middle between [`SHARE`] and all.
const AIM: f64 = (1.0 + SHARE) / 2.0;

impl Quantity {
    pub(super) fn budget(goal: &Goal) -> Option<Quantity> {
        let Goal { max_points: points, max_triangles: triangles, .. } = *goal;
        (points.is_some() || triangles.is_some()).then_some(Quantity::Budget { points, triangles })
    }

    pub(super) fn of(&self, figures: &Figures) -> f64 {
        let times =
            |most: Option<u64>, count: u64| most.map_or(f64::INFINITY, |most| most as f64 / count.max(1) as f64);
        match *self {
            Quantity::Budget { points, triangles } => {
                times(points, figures.vertices).min(times(triangles, figures.triangles))
            }
            Quantity::Rms(wanted) => figures.rms / wanted,
        }
    }

    /// Where it is to come to.
    pub(super) fn aim(&self) -> f64 {
        match self {
            Quantity::Budget { .. } => 1.0 / AIM,
            Quantity::Rms(_) => AIM,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tighter_budget_counts() {
        let goal = Goal { max_points: Some(100), max_triangles: Some(150), ..Goal::default() };
        let budget = Quantity::budget(&goal).unwrap();
        let figures = |vertices, triangles| Figures { vertices, triangles, ..Figures::default() };
        assert_eq!(budget.of(&figures(100, 100)), 1.0);
        assert_eq!(budget.of(&figures(50, 300)), 0.5);
        assert!(budget.of(&Figures::default()).is_finite());
        assert_eq!(Quantity::budget(&Goal { max_rms: Some(1.0), ..Goal::default() }), None);
    }
}
