//! Angles of triangles, and how far edges stray between samples.

use std::borrow::Cow;

use crate::base::Tile;
use crate::base::lattice::{Point, distance2, orient};
use crate::base::mesh::TileMesh;
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::feasible::Tester;

/// Bins of smallest angles: degrees, from 0 to 60.
pub const ANGLES: usize = 60;

/// Bins of overshoots: eighths of the tolerance up to four times it, and everything beyond.
pub const OVERSHOOTS: usize = 33;

/// Shapes of triangles, seen from above with square cells, and what edges do between samples.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeStats {
    /// How many triangles have their smallest angle in each degree.
    pub angles: [u64; ANGLES],
    /// How many edges inside tiles stray how far from the grid's edges and diagonals, where they cross them (strong
    /// feasibility, see [`Feasibility::Strong`]), in eighths of the tolerance.
    pub overshoots: [u64; OVERSHOOTS],
    /// How far the one strays that strays farthest, in the heights' units (times its weight).
    pub overshoot_max: f64,
    /// How many edges stray farther than they may ([`Task::max_stray`](crate::kernel::triangulate::Task::max_stray)).
    pub astray: u64,
}

impl Default for ShapeStats {
    fn default() -> Self {
        ShapeStats { angles: [0; ANGLES], overshoots: [0; OVERSHOOTS], overshoot_max: 0.0, astray: 0 }
    }
}

impl ShapeStats {
    /// Adds those of other triangles.
    pub fn add(&mut self, other: &ShapeStats) {
        self.angles.iter_mut().zip(other.angles).for_each(|(sum, count)| *sum += count);
        self.overshoots.iter_mut().zip(other.overshoots).for_each(|(sum, count)| *sum += count);
        self.overshoot_max = self.overshoot_max.max(other.overshoot_max);
        self.astray += other.astray;
    }

    /// The angle, in whole degrees, that a share of the triangles has as its smallest or less.
    pub fn angle(&self, share: f64) -> f64 {
        at_share(&self.angles, share) as f64 + 1.0
    }

    /// The share of the edges that stray more than the tolerance.
    pub fn beyond_tolerance(&self) -> f64 {
        let all: u64 = self.overshoots.iter().sum();
        let beyond: u64 = self.overshoots[8..].iter().sum();
        if all == 0 { 0.0 } else { beyond as f64 / all as f64 }
    }

    /// The overshoot that a share of the edges does not exceed, in units of the tolerance, to an eighth; at most 33/8.
    pub fn overshoot(&self, share: f64) -> f64 {
        (at_share(&self.overshoots, share) + 1) as f64 / 8.0
    }
}

/// The bin in which a share of all lies.
fn at_share(bins: &[u64], share: f64) -> usize {
    let wanted = (share * bins.iter().sum::<u64>() as f64).ceil() as u64;
    let mut seen = 0;
    let found = bins.iter().position(|count| {
        seen += count;
        seen >= wanted
    });
    found.unwrap_or(bins.len() - 1)
}

/// Looks at every triangle and at every edge inside the tile once; if only some triangles are wanted, at each of their
/// edges in the one of its two triangles in which it ascends. `scale` is the tolerance, or what stands for it, `max_stray` how
/// far edges may stray, infinite for any. Costs as much as measuring the errors.
pub fn shape(
    tile: &Tile,
    mesh: &TileMesh,
    scale: f64,
    max_stray: f64,
    wanted: impl Fn([Point; 3]) -> bool,
) -> ShapeStats {
    let mut stats = ShapeStats::default();
    // The weights of samples in lakes would count what is beside a shore.
    let tile = if tile.eased.is_empty() { Cow::Borrowed(tile) } else { Cow::Owned(tile.with_light_weights()) };
    let tile = tile.as_ref();
    let tester = Tester::new(tile, scale, Feasibility::Strong).with_max_stray(max_stray);
    for corners in mesh.triangles.iter().map(|&t| mesh.corners(t)) {
        if !wanted(corners.map(|v| v.at)) {
            continue;
        }
        let [a, b, c] = corners.map(|v| v.at);
        let [x, y, z] = [distance2(a, b), distance2(b, c), distance2(c, a)].map(|d| d as f64);
        // The smallest angle lies between the two longer sides, and is at most 60°.
        let sine = orient(a, b, c) as f64 / (x * y * z / x.min(y).min(z)).sqrt();
        stats.angles[(sine.min(1.0).asin().to_degrees() as usize).min(ANGLES - 1)] += 1;
        // Of an edge's two directions one ascends; those of the rim run along the grid and stray nowhere.
        let ascends = |i: usize| corners[i].at < corners[(i + 1) % 3].at;
        for i in (0..3).filter(|&i| ascends(i)) {
            let strays = tester.edge_deviation(corners[i], corners[(i + 1) % 3]);
            let bin = if strays > 0.0 { (strays / scale * 8.0) as usize } else { 0 };
            stats.overshoots[bin.min(OVERSHOOTS - 1)] += 1;
            stats.overshoot_max = stats.overshoot_max.max(strays);
            stats.astray += u64::from(tester.strays(corners[i], corners[(i + 1) % 3]));
        }
    }
    stats
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Heights;
    use crate::base::mesh::Vertex;

    #[test]
    fn a_diagonal_beside_a_bump() {
        let tile = Tile::from_heights(3, 2, Heights::F64(vec![0.0, 0.0, 0.0, 0.0, 3.0, 0.0]));
        let vertex = |c, r| Vertex { at: Point::of_sample(c, r), height: 0.0 };
        let vertices = vec![vertex(0, 0), vertex(2, 0), vertex(2, 1), vertex(0, 1)];
        let mesh = TileMesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]], relaxed: 0 };
        let stats = shape(&tile, &mesh, 1.0, 1.0, |_| true);
        // Two triangles with legs of 2 and 1: 26.57°.
        assert_eq!((stats.angles[26], stats.angle(0.5)), (2, 27.0));
        // It crosses the middle column halfway up to the bump; the two other edges counted stray nowhere.
        assert_eq!(stats.astray, 0, "it is as low as the lower of two samples");
        assert_eq!((stats.overshoot_max, stats.beyond_tolerance(), stats.overshoot(0.5)), (1.5, 1.0 / 3.0, 0.125));
    }
}
