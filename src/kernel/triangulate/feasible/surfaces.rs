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
        let rises = |[a, b, c]: [f64; 3]| [a, b - a, c - a];
        self.values.clear();
        self.values.push(rises(vertices.map(|v| v.height)));
        self.values.extend((0..tile.channels.len()).map(|i| rises(vertices.map(|v| tile.channel_at_vertex(i, v)))));
    }

    /// The weighted error at a sample inside the triangle; 0 at its corners.
    #[inline]
    pub(crate) fn weighted(&self, tile: &Tile, error: &ChannelError, (column, row): (usize, usize)) -> f64 {
        let at = Point::of_sample(column as i32, row as i32);
        if self.corners.contains(&at) {
            return 0.0;
        }
        let [a, b, c] = self.corners;
        let (wb, wc) = (orient(c, a, at) as f64, orient(a, b, at) as f64);
        let surface = |&[a, rise_b, rise_c]: &[f64; 3]| a + (wb * rise_b + wc * rise_c) * self.inverse;
        let index = row * tile.width() + column;
        let channels = self.values[1..].iter().zip(&tile.channels);
        let differences = channels.map(|(values, samples)| surface(values) - samples[index]);
        error.weighted(surface(&self.values[0]) - tile.at(column, row), differences)
    }
}
