//! The rows of a triangle where samples have channels: their weighted errors are held to a limit of their own.
//!
//! The limit ([`ChannelError::limit`]) leaves room for some hundred roundings, so nothing here has to be exact: an error that
//! one way of computing it finds within the limit is within the tolerance, whoever computes it again. The fast path carries
//! the surfaces along a row by their steps. What it does not find within is looked at again by [`Surfaces::weighted`]'s
//! definition, which insertion and `measure` go by.
//!
//! [`Surfaces::weighted`]: super::Surfaces::weighted

use super::RowShares;
use super::surfaces::weighted_at;
use super::tester::{LANES, Rows, Scan};
use crate::base::Tile;
use crate::base::channels::ChannelError;
use crate::base::lattice::{Point, STEPS};
use crate::base::mesh::Vertex;

/// Samples of a row that are looked at together: their errors fit into registers or next to them.
const BLOCK: usize = 8 * LANES;

/// The rows of a triangle of a tile with channels. Heights are tested apart: this is about the weighted error alone.
pub(super) struct ChannelRows<'a, H> {
    scan: &'a Scan,
    tile: &'a Tile,
    heights: &'a [H],
    error: &'a ChannelError,
    corners: [Vertex; 3],
    /// The samples at the corners.
    samples: [usize; 3],
    limit: f64,
}

impl<'a, H: Copy + Into<f64>> ChannelRows<'a, H> {
    #[inline(always)]
    pub(super) fn new(
        scan: &'a Scan,
        (tile, heights): (&'a Tile, &'a [H]),
        error: &'a ChannelError,
        corners: [Vertex; 3],
    ) -> ChannelRows<'a, H> {
        let samples = corners.map(|v| tile.sample_of_vertex(v));
        ChannelRows { scan, tile, heights, error, corners, samples, limit: error.limit(scan.tolerance) }
    }
}

/// Adds what the errors in one value count to those of a block of samples, some samples behind the first of the row; lanes are
/// whole.
#[inline(always)]
fn add<V: Copy + Into<f64>>(
    errors: &mut [[f64; LANES]],
    scale: f64,
    values: &[V],
    [a, b, c]: [f64; 3],
    shares: &RowShares,
    before: usize,
) {
    let (start, step) = shares.line([b - a, c - a]);
    let start = a + start;
    let mut index = before as f64;
    for (errors, lane) in errors.iter_mut().zip(values.as_chunks::<LANES>().0) {
        for i in 0..LANES {
            let value: f64 = lane[i].into();
            let surface = start + step * (index + i as f64);
            errors[i] += scale * (surface - value).abs();
        }
        index += LANES as f64;
    }
}

impl<H: Copy + Into<f64>> Rows for ChannelRows<'_, H> {
    #[inline(always)]
    fn scan(&self) -> &Scan {
        self.scan
    }

    #[inline(always)]
    fn within(&self, row: i32) -> bool {
        let Some((at, index, count)) = self.scan.samples(row) else { return true };
        let shares = RowShares::new(&self.scan.plane, at);
        let mut done = 0;
        while done < count {
            let len = (count - done).min(BLOCK);
            let mut errors = [[0.0; LANES]; BLOCK / LANES];
            let lanes = &mut errors[..len.div_ceil(LANES)];
            let samples = index + done..index + done + len.next_multiple_of(LANES);
            let [a, b, c] = self.corners;
            add(
                lanes,
                self.error.scale_z(),
                &self.heights[samples.clone()],
                [a.height, b.height, c.height],
                &shares,
                done,
            );
            for (&scale, values) in self.error.scales().iter().zip(&self.tile.channels) {
                let [a, b, c] = self.samples;
                add(lanes, scale, &values[samples.clone()], [values[a], values[b], values[c]], &shares, done);
            }
            let errors = &errors.as_flattened()[..len];
            let all_within = errors.iter().fold(true, |all, &error| all & (error <= self.limit));
            if !all_within && !self.within_in_doubt(errors, at.x / STEPS + done as i32, row) {
                return false;
            }
            done += len;
        }
        true
    }
}

impl<H> ChannelRows<'_, H> {
    /// Looks again at the samples of a block, from this column on, that seem to be beyond the limit.
    #[cold]
    #[inline(never)]
    fn within_in_doubt(&self, errors: &[f64], first: i32, row: i32) -> bool {
        for (&error, column) in errors.iter().zip(first..) {
            let seems_within = error <= self.limit;
            let is_within = || {
                let at = Point::of_sample(column, row);
                self.corners.iter().any(|v| v.at == at)
                    || weighted_at(self.tile, self.error, self.corners, (column as usize, row as usize)) <= self.limit
            };
            if !seems_within && !is_within() {
                self.scan.violation.set(Some(Point::of_sample(column, row)));
                return false;
            }
        }
        true
    }
}
