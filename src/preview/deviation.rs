//! How far the surface is from the samples, in colours.

use super::canvas::Canvas;
use super::colours::{EXCEEDED, NO_GROUND, UNCOVERED, scale};
use super::mesh::Triangle;
use super::relief::slope;
use super::samples::Samples;
use super::scan::points_inside;
use super::view::View;

/// How far the surface is from every looked-at sample.
pub(super) struct Deviation {
    view: View,
    samples: Samples,
    /// Row by row; negative where no triangle has been.
    errors: Vec<f64>,
}

/// What the errors come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Summary {
    /// Samples with a height.
    pub(super) valid: u64,
    /// Those with a surface.
    pub(super) covered: u64,
    pub(super) largest: f64,
    pub(super) rms: f64,
    /// Samples beyond the tolerance.
    pub(super) beyond: u64,
}

impl Deviation {
    pub(super) fn new(view: View, samples: Samples) -> Deviation {
        let errors = vec![-1.0; samples.heights.len()];
        Deviation { view, samples, errors }
    }

    /// Where triangles meet the larger error stays.
    pub(super) fn draw(&mut self, triangle: &Triangle) {
        let Some((across, down)) = slope(triangle) else { return };
        let (window, stride) = (self.view.window, self.view.stride as f64);
        let origin = triangle[0];
        let place = |k: usize| {
            let c = triangle[k];
            ((c.column - window.column as f64) / stride, (c.row - window.row as f64) / stride)
        };
        let at = place(0);
        let wide = self.samples.across;
        points_inside([at, place(1), place(2)], 0..wide, 0..self.samples.down, |i, j| {
            let surface = origin.height + across * (i as f64 - at.0) * stride + down * (j as f64 - at.1) * stride;
            let weight = self.samples.weights.get(j * wide + i).copied().unwrap_or(1.0);
            let error = (surface - self.samples.heights[j * wide + i]).abs() * weight;
            // A sample without a height has no error: NaN is never larger.
            if error > self.errors[j * wide + i] {
                self.errors[j * wide + i] = error;
            }
        });
    }

    pub(super) fn summary(&self, max_error: Option<f64>) -> Summary {
        let valid = self.samples.heights.iter().filter(|h| !h.is_nan()).count() as u64;
        let known = || self.errors.iter().filter(|e| **e >= 0.0);
        let covered = known().count() as u64;
        let squares: f64 = known().map(|e| e * e).sum();
        Summary {
            valid,
            covered,
            largest: known().fold(0.0, |a, &b| a.max(b)),
            rms: (squares / covered.max(1) as f64).sqrt(),
            beyond: max_error.map_or(0, |t| known().filter(|e| **e > limit(t)).count() as u64),
        }
    }

    /// Each pixel shows the largest error of the samples it covers, or of the nearest one.
    pub(super) fn finish(&self, end: f64, tolerance: Option<f64>) -> Canvas {
        let limit = tolerance.map_or(f64::INFINITY, limit);
        let range = |at: usize, pixels: usize, nodes: usize| {
            let node = |p: f64| p / pixels as f64 * (nodes - 1) as f64;
            let (from, to) = (node(at as f64).ceil() as usize, node((at + 1) as f64).floor() as usize);
            let middle = node(at as f64 + 0.5).round() as usize;
            if from <= to { from..to + 1 } else { middle..middle + 1 }
        };
        Canvas::from_fn(self.view.width, self.view.height, |x, y| {
            let columns = range(x, self.view.width, self.samples.across);
            let rows = range(y, self.view.height, self.samples.down);
            let (mut largest, mut bare, mut ground) = (-1.0, false, false);
            for k in rows.flat_map(|j| columns.clone().map(move |i| j * self.samples.across + i)) {
                let valid = !self.samples.heights[k].is_nan();
                ground |= valid;
                bare |= valid && self.errors[k] < 0.0;
                largest = self.errors[k].max(largest);
            }
            match () {
                () if largest > limit => EXCEEDED,
                () if bare => UNCOVERED,
                () if !ground => NO_GROUND,
                () => scale(largest / end),
            }
        })
    }
}

/// Errors are computed in plain doubles: what is above the tolerance by their rounding alone is not beyond it.
fn limit(tolerance: f64) -> f64 {
    tolerance * (1.0 + 1e-9) + 1e-9
}
