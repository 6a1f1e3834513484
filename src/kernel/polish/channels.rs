//! How far a triangle is from its samples where these have channels: in height, or in all together.
//!
//! A sample is within the tolerance if its height is, and so is its weighted error
//! ([`ChannelError::weighted`]). So what is measured of it is the larger one of the two.

use super::lanes::{Kernel, LANES, Lanes};
use super::net::Fit;
use super::scan::{COUNTS, Frame, INDEX, Line, Row, Rows, Run, Sample, Sums, place_of};
use crate::base::Tile;
use crate::base::channels::ChannelError;
use crate::base::mesh::Vertex;
use crate::kernel::triangulate::feasible::RowShares;

/// Lanes of a row that are measured together: their errors stay in registers or next to them.
const BLOCK: usize = 8;

/// Measures a triangle of a tile with channels.
pub(super) struct ChannelScan<'a, H> {
    frame: Frame,
    tile: &'a Tile,
    heights: &'a [H],
    error: &'a ChannelError,
    /// The samples at the corners.
    corners: [usize; 3],
}

impl<'a, H> ChannelScan<'a, H> {
    #[inline(always)]
    pub(super) fn new(
        frame: Frame,
        tile: &'a Tile,
        heights: &'a [H],
        error: &'a ChannelError,
        corners: [Vertex; 3],
    ) -> ChannelScan<'a, H> {
        ChannelScan { frame, tile, heights, error, corners: corners.map(|v| tile.sample_of_vertex(v)) }
    }
}

impl<H: Sample> Kernel for ChannelScan<'_, H> {
    type Output = Fit;

    #[inline(always)]
    fn run<L: Lanes>(self, on: L) -> Fit {
        self.measure(on)
    }
}

impl<H: Sample> Rows<H> for ChannelScan<'_, H> {
    #[inline(always)]
    fn frame(&self) -> &Frame {
        &self.frame
    }

    #[inline(always)]
    fn row<L: Lanes>(&self, run: Run, line: Line<H>, mut sums: Sums<L::Eight>, on: L) -> Sums<L::Eight> {
        let row = Row::new(&self.frame, line, on);
        let shares = RowShares::new(&self.frame.plane, run.first);
        let scale_z = on.all(self.error.scale_z() as f32);
        let mut done = 0;
        while done < run.count {
            let len = (run.count - done).min(BLOCK * LANES);
            let (first, lanes) = (run.index + done, len.div_ceil(LANES));
            let samples = first..first + lanes * LANES;
            let start = on.add(on.of(INDEX), on.all(done as f32));
            let (mut heights, mut errors) = ([on.all(0.0); BLOCK], [on.all(0.0); BLOCK]);
            let mut at = start;
            for (i, lane) in self.heights[samples.clone()].as_chunks::<LANES>().0.iter().enumerate() {
                heights[i] = row.errors(lane, at, on);
                errors[i] = on.mul(scale_z, heights[i]);
                at = on.add(at, on.all(LANES as f32));
            }
            for (scale, values) in self.error.scales().iter().zip(&self.tile.channels) {
                let [a, b, c] = at_corners(values, self.corners);
                // What it counts, in tolerances.
                let scale = scale * self.frame.per_tolerance;
                let (above_a, step) = shares.line([(b - a) * scale, (c - a) * scale]);
                let (above_a, step) = (on.all(above_a as f32), on.all(step as f32));
                let mut at = start;
                for (errors, lane) in errors.iter_mut().zip(values[samples.clone()].as_chunks::<LANES>().0) {
                    let mut above = [0.0; LANES];
                    for (above, value) in above.iter_mut().zip(lane) {
                        *above = ((value - a) * scale) as f32;
                    }
                    let surface = on.add(above_a, on.mul(step, at));
                    *errors = on.add(*errors, on.abs(on.sub(surface, on.of(above))));
                    at = on.add(at, on.all(LANES as f32));
                }
            }
            let mut place = place_of(first);
            for i in 0..lanes {
                let counts = on.of(COUNTS[(len - i * LANES).min(LANES)]);
                sums.add(on.mul(on.max(heights[i], errors[i]), counts), row.pull, place, on);
                place = place.saturating_add(LANES as u32);
            }
            done += len;
        }
        sums
    }
}

/// A channel's values at three samples. (Maps of arrays are not always inlined.)
#[inline(always)]
fn at_corners(values: &[f64], [a, b, c]: [usize; 3]) -> [f64; 3] {
    [values[a], values[b], values[c]]
}

/// The weighted error at one sample under a triangle, from its weights (the lattice's orientations) there; 0 at a corner.
#[inline(never)]
pub(super) fn weighted_at(
    tile: &Tile,
    error: &ChannelError,
    sample: usize,
    [a, b, c]: [Vertex; 3],
    [wa, wb, wc]: [f64; 3],
) -> f64 {
    let places = [tile.sample_of_vertex(a), tile.sample_of_vertex(b), tile.sample_of_vertex(c)];
    let inverse = 1.0 / (wa + wb + wc);
    let off = |[a, b, c]: [f64; 3], value: f64| (wa * (a - value) + wb * (b - value) + wc * (c - value)) * inverse;
    let channels = tile.channels.iter().map(|values| off(at_corners(values, places), values[sample]));
    let (column, row) = (sample % tile.width, sample / tile.width);
    error.weighted(off([a.height, b.height, c.height], tile.at(column, row)), channels)
}
