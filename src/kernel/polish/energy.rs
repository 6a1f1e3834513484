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
use super::scan::{Frame, Scan};
use super::witnesses::Witnesses;
use crate::base::lattice::Point;
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::feasible::{Plane, Spans, Tester};

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

    /// Remembers where a triangle is worst, if that is known.
    pub(super) fn note(&self, fit: Fit, witnesses: &mut Witnesses) {
        if fit.place != NONE {
            witnesses.note(fit.place as usize, self);
        }
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

    fn scan(&self, [a, b, c]: [Vertex; 3], limit: f32, stride: i32) -> Fit {
        let frame = Frame {
            spans: Spans::new(a.at, b.at, c.at),
            plane: Plane::new(a, b, c),
            height_of_a: a.height,
            width: self.tile.width,
            per_tolerance: self.per_tolerance,
            limit,
            stride,
        };
        let weights = &self.tile.weights[..];
        if let Some(error) = &self.tile.channel_error {
            return match &self.tile.heights {
                Heights::F32(heights) => run(ChannelScan::new(frame, self.tile, heights, error, [a, b, c])),
                Heights::F64(heights) => run(ChannelScan::new(frame, self.tile, heights, error, [a, b, c])),
            };
        }
        match &self.tile.heights {
            Heights::F32(heights) => run(Scan::<_, false> { frame, heights, weights }),
            Heights::F64(heights) if weights.is_empty() => run(Scan::<_, false> { frame, heights, weights }),
            Heights::F64(heights) => run(Scan::<_, true> { frame, heights, weights }),
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
    use crate::base::lattice::Point;

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
}
