//! Which samples of a window may be far from a triangle, as far as the heights between which squares of them are can tell. Where triangles are
//! large and errors, too, few squares are left, and most windows need not be read.
//!
//! **How high a triangle is over a square.** The height of its plane along the normal is F = g ÷ q, with g = n·(A − S) and q = n·N, the
//! normal n of the triangle being of length 1. Bilinear between the corners of the square, which are Δ apart in longitude and latitude, it would be between
//! the four heights there. It is off that by Δ² ÷ 8 × (|∂²F/∂λ²| + |∂²F/∂φ²|) at the most. With r = 2a² ÷ b, which bounds what first and
//! second derivatives of a place S are (half of it would do where the ellipsoid is hardly flattened), those of N being at most 1, either is at most
//! r ÷ q + 2r ÷ q² + |g| (1 ÷ q² + 2 ÷ q³). On the square q is at most 2Δ less than at a corner, and |g| at most 2rΔ more.

use super::body::Body;
use super::error::PyramidError;
use super::facet::{Facet, Row};
use super::measure::{Places, clipped};
use super::outline::{SQUARE, SQUARES};
use super::samples::{Patch, Samples};

/// Where normals of a triangle and of the ellipsoid are farther apart than this cosine, nothing is told.
const LEAST_FACING: f64 = 0.25;

/// What rounding adds to a height, in metres.
const MARGIN: f64 = 1e-3;

/// A window of a tile, square by square.
pub(super) struct Rough {
    /// Samples of the raster in the window.
    pub(super) samples: u64,
    /// Squares across and down.
    size: (usize, usize),
    /// By rows.
    ends: Vec<(f64, f64)>,
    /// Of the meridians and parallels between squares.
    meridians: Vec<(f64, f64)>,
    parallels: Vec<Row>,
    /// Δ, in radians.
    side: f64,
    /// r.
    reach: f64,
}

impl Rough {
    /// The squares of a window; `None` where nothing is known of them.
    pub(super) fn of(body: &Body, samples: &Samples, patch: Patch) -> Result<Option<Rough>, PyramidError> {
        let Patch { column, row, width, height, .. } = patch;
        let size = (width.div_ceil(SQUARE), height.div_ceil(SQUARE));
        let mut ends = vec![(f64::INFINITY, f64::NEG_INFINITY); size.0 * size.1];
        let mut inside = 0;
        let is_known = samples.each_outline((column, row), (width, height), |(left, top), outline, count| {
            inside += count.inside;
            let (left, top) = (left / SQUARE, top / SQUARE);
            for r in top..(top + SQUARES).min(size.1) {
                (left..(left + SQUARES).min(size.0))
                    .for_each(|c| ends[r * size.0 + c] = outline.ends(c - left, r - top));
            }
        })?;
        if !is_known {
            return Ok(None);
        }
        let grid = samples.grid;
        let across = |i: usize| Patch { width: 1, height: 1, column: column + (i * SQUARE) as i64, ..patch };
        let down = |i: usize| Patch { width: 1, height: 1, row: row + (i * SQUARE) as i64, ..patch };
        let meridian = |i: usize| Places::new(body, grid, across(i), [0.0; 3]).meridian(0);
        let parallel = |i: usize| Places::new(body, grid, down(i), [0.0; 3]).rows.remove(0);
        Ok(Some(Rough {
            samples: inside,
            size,
            ends,
            meridians: (0..=size.0).map(meridian).collect(),
            parallels: (0..=size.1).map(parallel).collect(),
            side: (SQUARE as f64 * grid.cell()).to_radians(),
            reach: 2.0 * body.semi_major * body.semi_major / body.semi_minor,
        }))
    }

    /// The columns of the window from the first to behind the last square, of those with the row in them, where a sample that a triangle has may be farther from it
    /// than `limit`; `at` is the first column and row of the window in the tile.
    pub(super) fn columns(&self, facet: &Facet, at: (i64, i64), row: usize, limit: f64) -> std::ops::Range<usize> {
        let (down, size) = (row / SQUARE, SQUARE as f64);
        let first = at.1 as f64 + down as f64 * size;
        let Some((low, high)) = facet.columns_between(first, first + size) else { return 0..0 };
        let left = at.0 as f64;
        let squares = clipped(((low - left) / size).floor(), (high - left) / size, self.size.0);
        let mut open = squares.filter(|&across| self.is_open(facet, (across, down), limit));
        let Some(first) = open.next() else { return 0..0 };
        first * SQUARE..(open.next_back().unwrap_or(first) + 1) * SQUARE
    }

    /// Whether any sample of the window that a triangle has may be farther from it than `limit`.
    pub(super) fn has_any(&self, facet: &Facet, at: (i64, i64), limit: f64) -> bool {
        let (_, (low, high)) = (facet.bounds()[0], facet.bounds()[1]);
        let (top, size) = (at.1 as f64, SQUARE as f64);
        let mut rows = clipped(((low - top) / size).floor(), (high - top) / size, self.size.1);
        rows.any(|down| !self.columns(facet, at, down * SQUARE, limit).is_empty())
    }

    fn is_open(&self, facet: &Facet, (across, down): (usize, usize), limit: f64) -> bool {
        let (lowest, highest) = self.ends[down * self.size.0 + across];
        if lowest > highest {
            return false;
        }
        let (mut low, mut high, mut least) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
        for parallel in &self.parallels[down..down + 2] {
            for &meridian in &self.meridians[across..across + 2] {
                let (height, facing) = facet.above(parallel, meridian);
                (low, high, least) = (low.min(height), high.max(height), least.min(facing));
            }
        }
        let facing = least - 2.0 * self.side;
        // What is not a number is open, too.
        if facing.is_nan() || facing < LEAST_FACING {
            return true;
        }
        let (r, q) = (self.reach, 1.0 / facing);
        let g = high.abs().max(low.abs()) + 2.0 * r * self.side;
        let bend = 0.25 * self.side * self.side * (r * q + 2.0 * r * q * q + g * (q * q + 2.0 * q * q * q));
        let error = (high - lowest).max(highest - low) + bend + MARGIN;
        error.is_nan() || error > limit
    }
}
