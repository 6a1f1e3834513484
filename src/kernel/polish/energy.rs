//! How far a triangle is from its samples, in numbers that can be minimised.
//!
//! With t = |error| · weight / tolerance, or where there are channels the larger one of |error| / tolerance and the weighted
//! error / tolerance, the energy of a sample is max(0, t − 0.97)² + 10⁻⁴·t⁴: violations count, and a little
//! what may become one. With strong feasibility an edge counts as one more sample, where it is farthest from the grid's
//! surface. Summed in single precision, in lanes and in one fixed order, so that every machine steers alike.
//! It only steers: what is kept has passed the exact test.

use super::channels::ChannelScan;
use super::lanes::{LANES, Lanes, run};
use super::net::{Fit, NONE};
use super::scan::{HeightScan, Question};
use super::witnesses::{Witness, Witnesses};
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::feasible::Tester;

/// Where violations begin to count, a little before they are some.
pub(super) const ONSET: f32 = 0.97;
/// The weight of t⁴. Anything from 5·10⁻⁵ to 3·10⁻⁴ does; with 10⁻³ one per cent more triangles are left.
pub(super) const PULL: f32 = 1e-4;

/// Measures triangles of one tile. The tolerance is positive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meter<'a> {
    tile: &'a Tile,
    per_tolerance: f64,
    /// For the edges, where they count.
    edges: Option<Tester<'a>>,
}

impl<'a> Meter<'a> {
    pub(super) fn new(tester: Tester<'a>, tolerance: f64) -> Meter<'a> {
        let edges = (tester.feasibility() == Feasibility::Strong).then_some(tester);
        Meter { tile: tester.tile(), per_tolerance: 1.0 / tolerance, edges }
    }

    /// Whether energies are numbers: not if the tolerance is 0 or next to it.
    pub(super) fn is_of_use(&self) -> bool {
        self.per_tolerance < 1e30
    }

    pub(super) fn tile(&self) -> &'a Tile {
        self.tile
    }

    pub(super) fn per_tolerance(&self) -> f64 {
        self.per_tolerance
    }

    /// What measures edges, where they count.
    pub(super) fn edges(&self) -> Option<&Tester<'a>> {
        self.edges.as_ref()
    }

    /// Measures a triangle with positive orientation. Stops once its energy is above `limit`; what it then returns is
    /// above it, too.
    pub(super) fn fit(&self, corners: [Vertex; 3], limit: f32) -> Fit {
        self.with_edges(self.scan(corners, limit, 1), corners, limit)
    }

    /// Adds a triangle's edges, where they count, to how its samples fit.
    pub(super) fn with_edges(&self, mut fit: Fit, corners: [Vertex; 3], limit: f32) -> Fit {
        if let Some(tester) = &self.edges {
            let [a, b, c] = corners;
            for (p, q) in [(a, b), (b, c), (c, a)] {
                if fit.energy > limit {
                    break;
                }
                let t = (tester.edge_deviation(p, q) * self.per_tolerance) as f32;
                fit.energy += energy(t);
                if t > fit.worst {
                    (fit.worst, fit.place) = (t, NONE);
                }
            }
        }
        fit
    }

    /// Remembers where a triangle is worst, if that is known; returns the witness, if it is a new one.
    pub(super) fn note(&self, fit: Fit, witnesses: &mut Witnesses) -> Option<Witness> {
        if fit.place == NONE {
            return None;
        }
        witnesses.note(fit.place as usize, self)
    }

    /// Where a triangle is worst, if that is known.
    pub(super) fn place(&self, fit: Fit) -> Option<Point> {
        let (place, width) = (fit.place as usize, self.tile.width);
        (fit.place != NONE).then(|| Point::of_sample((place % width) as i32, (place / width) as i32))
    }

    /// Makes a place a witness, if it is a sample.
    pub(super) fn call(&self, at: Point, witnesses: &mut Witnesses) {
        if let Some((column, row)) = at.sample() {
            witnesses.note(row * self.tile.width + column, self);
        }
    }

    /// About the energy of a triangle's samples, from every `stride`th row alone: small errors count `stride` times, as
    /// those of rows between will be like them; violations count once.
    pub(super) fn coarse_energy(&self, corners: [Vertex; 3], limit: f32, stride: i32) -> f32 {
        self.scan(corners, limit, stride).energy
    }

    fn scan(&self, corners: [Vertex; 3], limit: f32, stride: i32) -> Fit {
        let Meter { tile, per_tolerance, .. } = *self;
        let question = Question { corners, width: tile.width, per_tolerance, limit, stride };
        let weights = &tile.weights[..];
        if let Some(error) = &tile.channel_error {
            return match &tile.heights {
                Heights::F32(heights) => run(ChannelScan::new(question.frame(), tile, heights, error, corners)),
                Heights::F64(heights) => run(ChannelScan::new(question.frame(), tile, heights, error, corners)),
            };
        }
        match &tile.heights {
            Heights::F32(heights) => run(HeightScan::<_, false> { question, heights, weights }),
            Heights::F64(heights) if weights.is_empty() => run(HeightScan::<_, false> { question, heights, weights }),
            Heights::F64(heights) => run(HeightScan::<_, true> { question, heights, weights }),
        }
    }
}

/// The energies of eight errors.
#[inline(always)]
pub(super) fn energies<L: Lanes>(on: L, t: L::Eight, pull: L::Eight) -> L::Eight {
    let over = on.max(on.sub(t, on.all(ONSET)), on.all(0.0));
    let t2 = on.mul(t, t);
    on.add(on.mul(over, over), on.mul(pull, on.mul(t2, t2)))
}

/// The energy of one error, as a share of the tolerance.
pub(super) fn energy(t: f32) -> f32 {
    let (over, t2) = (t - ONSET, t * t);
    let over = if over > 0.0 { over } else { 0.0 };
    over * over + PULL * (t2 * t2)
}

/// A fixed tree of additions.
#[inline(always)]
pub(super) fn total(&[a, b, c, d, e, f, g, h]: &[f32; LANES]) -> f32 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[inline(always)]
pub(super) fn largest(&[a, b, c, d, e, f, g, h]: &[f32; LANES]) -> f32 {
    let max = |a: f32, b: f32| if b > a { b } else { a };
    max(max(max(a, e), max(c, g)), max(max(b, f), max(d, h)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::lattice::orient;

    #[test]
    fn one_violation_among_samples_on_the_plane() {
        let mut heights = vec![0.0f32; 144];
        heights[12 * 2 + 3] = 3.0;
        let tile = Tile::from_heights(12, 12, Heights::F32(heights));
        let at = |c, r| Vertex { at: Point::of_sample(c, r), height: 0.0 };
        let tester = Tester::new(&tile, 2.0, Feasibility::Weak);
        let fit = Meter::new(tester, 2.0).fit([at(0, 0), at(11, 0), at(0, 11)], f32::INFINITY);
        let t = 1.5f32;
        assert_eq!((fit.worst, fit.place), (t, 12 * 2 + 3));
        assert!((fit.energy - ((t - ONSET).powi(2) + PULL * t.powi(4))).abs() < 1e-6, "{fit:?}");
    }

    /// Rows of every length up to twelve, with none of them and with all of them in one lane: sample by sample is the oracle.
    #[test]
    fn a_triangle_has_the_energy_of_its_samples() {
        let noise = |i: usize| (i * 7919 % 101) as f32 * 0.05;
        let tile = Tile::from_heights(12, 12, Heights::F32((0..144).map(noise).collect()));
        let tolerance = 2.0;
        let meter = Meter::new(Tester::new(&tile, tolerance, Feasibility::Weak), tolerance);
        let places = [(0, 0), (5, 1), (11, 0), (3, 4), (8, 3), (1, 9), (6, 11), (11, 7), (2, 2), (7, 5)];
        let mut seen = 0;
        for i in 0..1000 {
            let corners = [i / 100, i / 10 % 10, i % 10].map(|i: usize| {
                let (column, row) = places[i];
                Vertex { at: Point::of_sample(column, row), height: tile.at(column as usize, row as usize) }
            });
            let [a, b, c] = corners;
            let area = orient(a.at, b.at, c.at);
            if area <= 0 {
                continue;
            }
            let (mut sum, mut worst) = (0.0f64, 0.0f64);
            for (column, row) in (0..144).map(|i| (i % 12, i / 12)) {
                let p = Point::of_sample(column, row);
                let weights = [orient(b.at, c.at, p), orient(c.at, a.at, p), orient(a.at, b.at, p)];
                if weights.iter().all(|&w| w >= 0) {
                    let plane: f64 =
                        weights.iter().zip(corners).map(|(&w, v)| w as f64 * v.height).sum::<f64>() / area as f64;
                    let t = (plane - tile.at(column as usize, row as usize)).abs() / tolerance;
                    sum += f64::from(energy(t as f32));
                    worst = worst.max(t);
                }
            }
            let fit = meter.fit(corners, f32::INFINITY);
            assert!((f64::from(fit.energy) - sum).abs() <= 1e-4 * sum + 1e-6, "{corners:?}: {fit:?} for {sum}");
            assert!((f64::from(fit.worst) - worst).abs() <= 1e-5, "{corners:?}: {fit:?} for {worst}");
            seen += 1;
        }
        assert!(seen > 300, "{seen} triangles");
    }
}
