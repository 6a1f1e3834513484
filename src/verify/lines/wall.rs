//! Edges of the mesh held against the heights of lines and of the raster's surface, each exactly.

use num_bigint::BigInt;
use num_rational::BigRational;

use super::Spot;
use super::edges::Edge;
use super::heights::{Crossing, Samples, for_each_crossing};
use super::words::{spot, word};
use crate::verify::exact::rational;
use std::ops::Range;

/// What edges along lines are held to in some rows.
pub(super) struct Wall<'a> {
    pub(super) samples: &'a Samples,
    /// Heights of lines' own, by place.
    pub(super) levels: &'a [(u64, f64)],
    pub(super) tolerance: f64,
}

impl Wall<'_> {
    /// Judges an edge in some rows of samples, and those between each and the next: whether its ends that are there may be ends of
    /// edges that follow lines. Whether it keeps to the surface is noted.
    pub(super) fn judge(&self, edge: &mut Edge, rows: &Range<i64>) -> bool {
        let [a, b] = edge.ends.map(spot);
        let [from, to] = edge.heights;
        let is_near = |at: Spot, height: f64| !rows.contains(&(at.1 >> 2)) || self.is_near_target(at, height);
        if !is_near(a, from) || !is_near(b, to) {
            return false;
        }
        for_each_crossing(a, b, |crossing| {
            edge.is_on_surface =
                edge.is_on_surface && (!rows.contains(&crossing.sample.0) || self.holds(&crossing, from, to));
        });
        true
    }

    /// Whether a vertex is within the tolerance of a line's own height, or where there is none of the bilinear surface.
    fn is_near_target(&self, at: Spot, height: f64) -> bool {
        match self.levels.binary_search_by_key(&word(at), |level| level.0) {
            Ok(found) => is_within(self.tolerance, &Mean([(1, self.levels[found].1)]), &Mean([(1, height)])),
            Err(_) => self.is_near_surface(at, height),
        }
    }

    /// Whether a vertex is within the tolerance of the bilinear surface.
    fn is_near_surface(&self, (x, y): Spot, height: f64) -> bool {
        let ((column, right), (row, below)) = ((x >> 2, x & 3), (y >> 2, y & 3));
        let weights = [
            (0, 0, (4 - right) * (4 - below)),
            (0, 1, right * (4 - below)),
            (1, 0, (4 - right) * below),
            (1, 1, right * below),
        ];
        let mut corners = [(0, 0.0); 4];
        for (corner, (down, across, weight)) in corners.iter_mut().zip(weights).filter(|(_, w)| w.2 > 0) {
            let Some(sample) = self.samples.height(row + down, column + across) else { return false };
            *corner = (weight, sample);
        }
        is_within(self.tolerance, &Mean(corners), &Mean([(1, height)]))
    }

    fn holds(&self, crossing: &Crossing, from: f64, to: f64) -> bool {
        let &Crossing { sample: (row, column), part: (part, all), done, is_column } = crossing;
        let next = if is_column { (row + 1, column) } else { (row, column + 1) };
        let (before, after) = (self.samples.height(row, column), self.samples.height(next.0, next.1));
        // At a sample the next one does not matter.
        let (Some(before), Some(after)) = (before, if part == 0 { Some(0.0) } else { after }) else { return false };
        let (surface, edge) = (Mean([(all - part, before), (part, after)]), Mean([(all - done, from), (done, to)]));
        is_within(self.tolerance, &surface, &edge)
    }
}

/// An interpolated height: Σ weight · height, over the sum of weights.
pub(super) struct Mean<const N: usize>(pub(super) [(i64, f64); N]);

impl<const N: usize> Mean<N> {
    fn rounded(&self) -> (f64, f64) {
        let all: i64 = self.0.iter().map(|(w, _)| w).sum();
        let sum: f64 = self.0.iter().map(|&(w, z)| w as f64 * z).sum();
        let size: f64 = self.0.iter().map(|&(w, z)| (w as f64 * z).abs()).sum();
        (sum / all as f64, size / all as f64)
    }

    fn exact(&self) -> BigRational {
        let whole = |w: i64| BigRational::from_integer(BigInt::from(w));
        let all: BigRational = self.0.iter().map(|&(w, _)| whole(w)).sum();
        self.0.iter().map(|&(w, z)| whole(w) * rational(z)).sum::<BigRational>() / all
    }
}

/// A bound of what rounding does to the difference of two means, as a share of their sizes.
const DOUBT: f64 = 1e-14;

/// Whether two heights are within the tolerance of each other.
pub(super) fn is_within<const N: usize, const M: usize>(tolerance: f64, a: &Mean<N>, b: &Mean<M>) -> bool {
    let ((x, x_size), (y, y_size)) = (a.rounded(), b.rounded());
    let over = (x - y).abs() - tolerance;
    if over.abs() > (x_size + y_size + tolerance) * DOUBT {
        return over < 0.0;
    }
    let (off, tolerance) = (a.exact() - b.exact(), rational(tolerance));
    -&tolerance <= off && off <= tolerance
}
