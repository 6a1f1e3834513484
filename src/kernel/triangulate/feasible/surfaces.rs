//! The surfaces of a triangle's attributes, and their error.

use crate::base::Tile;
use crate::base::channels::ChannelError;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;

/// The surfaces over one triangle of a tile with channels: of the heights and of each channel (Garland & Heckbert 1995,
/// section 4.6, where `FitPlane` retains a plane for each). Reused from triangle to triangle.
///
/// By weights of corners as a [`super::Plane`], and off by as little: a few roundings of the largest value at a corner.
#[derive(Debug)]
pub(crate) struct Surfaces {
    corners: [Point; 3],
    inverse: f64,
    /// Of the heights, then of each channel: the value at the first corner, and what the others rise above it.
    values: Vec<[f64; 3]>,
}

impl Default for Surfaces {
    fn default() -> Self {
        Surfaces { corners: [Point { x: 0, y: 0 }; 3], inverse: 0.0, values: Vec::new() }
    }
}

impl Surfaces {
    /// Through the samples at three vertices with positive orientation.
    ///
    /// # Panics
    /// If a vertex does not lie on a sample of the tile.
    pub(crate) fn set(&mut self, tile: &Tile, vertices: [Vertex; 3]) {
        self.corners = vertices.map(|v| v.at);
        let [a, b, c] = self.corners;
        self.inverse = 1.0 / orient(a, b, c) as f64;
        self.values.clear();
        self.values.push(rises(vertices.map(|v| v.height)));
        self.values.extend((0..tile.channels.len()).map(|i| rises(vertices.map(|v| tile.channel_at_vertex(i, v)))));
    }

    /// The weighted error at a sample inside the triangle; 0 at its corners.
    #[inline]
    pub(crate) fn weighted(&self, tile: &Tile, error: &ChannelError, sample: (usize, usize)) -> f64 {
        let place = Point::of_sample(sample.0 as i32, sample.1 as i32);
        if self.corners.contains(&place) {
            return 0.0;
        }
        let (heights, channels) = self.values.split_first().expect("the heights come first");
        between(
            tile,
            error,
            Weights::new(self.corners, self.inverse, place),
            sample,
            *heights,
            channels.iter().copied(),
        )
    }
}

/// The same of a single sample that is no corner, without memory.
pub(super) fn weighted_at(tile: &Tile, error: &ChannelError, corners: [Vertex; 3], sample: (usize, usize)) -> f64 {
    let [a, b, c] = corners.map(|v| v.at);
    let place = Point::of_sample(sample.0 as i32, sample.1 as i32);
    let weights = Weights::new([a, b, c], 1.0 / orient(a, b, c) as f64, place);
    let samples = corners.map(|v| tile.sample_of_vertex(v));
    let channels = tile.channels.iter().map(|values| rises(samples.map(|sample| values[sample])));
    between(tile, error, weights, sample, rises(corners.map(|v| v.height)), channels)
}

/// The weights of corners b and c at a place.
#[derive(Clone, Copy)]
struct Weights {
    b: f64,
    c: f64,
    inverse: f64,
}

impl Weights {
    #[inline(always)]
    fn new([a, b, c]: [Point; 3], inverse: f64, at: Point) -> Weights {
        Weights { b: orient(c, a, at) as f64, c: orient(a, b, at) as f64, inverse }
    }

    #[inline(always)]
    fn surface(self, [a, rise_b, rise_c]: [f64; 3]) -> f64 {
        a + (self.b * rise_b + self.c * rise_c) * self.inverse
    }
}

/// The value at the first corner, and what the others rise above it.
#[inline(always)]
fn rises([a, b, c]: [f64; 3]) -> [f64; 3] {
    [a, b - a, c - a]
}

/// The weighted error at a sample of surfaces with these values.
#[inline(always)]
fn between(
    tile: &Tile,
    error: &ChannelError,
    weights: Weights,
    (column, row): (usize, usize),
    heights: [f64; 3],
    channels: impl Iterator<Item = [f64; 3]>,
) -> f64 {
    let index = row * tile.width() + column;
    let differences = channels.zip(&tile.channels).map(|(values, samples)| weights.surface(values) - samples[index]);
    error.weighted(weights.surface(heights) - tile.at(column, row), differences)
}
