//! What is found out about stretches, in whatever order they come.

use super::edges::Edge;
use super::follow::{Follow, Stretch};
use super::words::spot;
use super::{Finding, Grid, RequiredLines, StretchPlace};

/// Follows stretches and counts.
pub(super) struct Finder<'a> {
    grid: &'a Grid,
    lines: &'a RequiredLines,
    pub(super) tolerance: f64,
    /// Whether lines of any set have heights of their own.
    pub(super) any_heights: bool,
    pub(super) off_ground: u64,
    pub(super) stretches: u64,
    pub(super) edges: u64,
    pub(super) broken: Finding<StretchPlace>,
    /// Of the first that is broken: whether it is a ring, and its first two places. Rings come last.
    first: Option<(bool, u64, u64)>,
}

impl<'a> Finder<'a> {
    pub(super) fn new((grid, lines): (&'a Grid, &'a RequiredLines), tolerance: f64) -> Finder<'a> {
        let any_heights = lines.sets.iter().any(|set| set.has_heights);
        let (off_ground, stretches, edges, broken, first) = (0, 0, 0, Finding::default(), None);
        Finder { grid, lines, tolerance, any_heights, off_ground, stretches, edges, broken, first }
    }

    /// Follows a stretch with edges of the mesh, among them all that are between two of its places.
    pub(super) fn add(&mut self, stretch: Stretch, edges: &[Edge]) {
        let stretch = stretch.in_order();
        self.stretches += 1;
        let reached = match Follow::new(&stretch, edges, &self.lines.sets, self.tolerance).edges() {
            Ok(edges) => return self.edges += edges,
            Err(reached) => reached,
        };
        let places = &stretch.places;
        let order = (stretch.is_ring, places[0], places[1]);
        if self.first.is_none_or(|first| order < first) {
            let [from, reached, to] = [0, reached, places.len() - 1].map(|at| self.grid.map(spot(places[at])));
            (self.first, self.broken.first) = (Some(order), Some(StretchPlace { from, reached, to }));
        }
        self.broken.count += 1;
    }
}
