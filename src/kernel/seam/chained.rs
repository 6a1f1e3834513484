//! What chains of breaklines have on the side of a tile.

use super::Side;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;
use crate::kernel::breaklines::TileChains;

/// The vertices of chains on one side of a tile, corners apart, and their edges along it.
#[derive(Debug, Default)]
pub(super) struct OnSide {
    vertices: Vec<Vertex>,
    /// From one place along the side to another, in lattice steps.
    edges: Vec<[i32; 2]>,
    is_level: bool,
}

impl OnSide {
    /// Of a tile whose last sample is at this place.
    pub(super) fn new(chains: &TileChains, side: Side, far: Point) -> OnSide {
        let is_level = matches!(side, Side::North | Side::South);
        let has = |at: Point| match side {
            Side::North => at.y == 0,
            Side::South => at.y == far.y,
            Side::West => at.x == 0,
            Side::East => at.x == far.x,
        };
        let along = |at: Point| if is_level { at.x } else { at.y };
        let end = along(far);
        let between = |v: &&Vertex| has(v.at) && (1..end).contains(&along(v.at));
        let vertices = chains.vertices().iter().filter(between).copied().collect();
        let on_side = chains.edges().iter().filter(|edge| edge.iter().all(|v| has(v.at)));
        let edges = on_side.map(|[a, b]| [along(a.at).min(along(b.at)), along(a.at).max(along(b.at))]).collect();
        OnSide { vertices, edges, is_level }
    }

    fn along(&self, at: Point) -> i32 {
        if self.is_level { at.x } else { at.y }
    }

    /// The places along the side of samples that must be vertices of it: those of chains, and those on either side of a vertex
    /// between two, so that the side is straight there. Points are given, all come back in order.
    pub(super) fn force(&self, points: &[usize]) -> Vec<usize> {
        let around = |v: &Vertex| {
            let along = self.along(v.at);
            [along.div_euclid(STEPS), (along + STEPS - 1).div_euclid(STEPS)].map(|i| i as usize)
        };
        let mut all: Vec<usize> = points.iter().copied().chain(self.vertices.iter().flat_map(around)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The vertices of the side, of which these stand on samples: those of chains come to them, and edges of chains have none between
    /// their ends.
    pub(super) fn merge(&self, samples: impl Iterator<Item = Vertex>) -> Vec<Vertex> {
        let passed = |at: Point| self.edges.iter().any(|[from, to]| (from + 1..*to).contains(&self.along(at)));
        let between = self.vertices.iter().filter(|v| v.at.sample().is_none()).copied();
        let mut all: Vec<Vertex> = samples.filter(|v| !passed(v.at)).chain(between).collect();
        all.sort_by_key(|v| self.along(v.at));
        all
    }
}
