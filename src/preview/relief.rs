//! Shading: light from the upper left, 45° high, as maps have it.

use super::canvas::Canvas;
use super::mesh::Triangle;
use super::samples::Samples;
use super::scan::points_inside;
use super::vertical::rises;
use super::view::View;

/// The size of cells against heights, exaggeration included.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Light {
    /// Heights are divided by these to become slopes per cell across and down.
    cell: (f64, f64),
}

impl Light {
    /// For cells of this size in the unit of heights, and heights that are multiplied by a factor.
    pub(crate) fn new((across, down): (f64, f64), factor: f64) -> Light {
        Light { cell: (across / factor, down / factor) }
    }

    /// Brightness from 0 to 1 of ground that rises by so much per cell across and down.
    pub(crate) fn shade(&self, rise_across: f64, rise_down: f64) -> f32 {
        let (dx, dy) = (rise_across / self.cell.0, rise_down / self.cell.1);
        let light = (0.5 * dx + 0.5 * dy + std::f64::consts::FRAC_1_SQRT_2) / (1.0 + dx * dx + dy * dy).sqrt();
        light.clamp(0.0, 1.0) as f32
    }
}

/// Heights per cell across and down on the triangle's plane; `None` where it has no area.
pub(super) fn slope([a, b, c]: &Triangle) -> Option<(f64, f64)> {
    let (ux, uy, uh) = (b.column - a.column, b.row - a.row, b.height - a.height);
    let (vx, vy, vh) = (c.column - a.column, c.row - a.row, c.height - a.height);
    let area = ux * vy - uy * vx;
    let slope = ((uh * vy - vh * uy) / area, (vh * ux - uh * vx) / area);
    (slope.0.is_finite() && slope.1.is_finite()).then_some(slope)
}

/// Points that are shaded in every pixel, each way.
const FINE: usize = 2;

/// Shaded triangles at [`FINE`] times the picture's resolution.
pub(super) struct Shading {
    view: View,
    /// Negative where no triangle is.
    light: Vec<f32>,
}

impl Shading {
    pub(super) fn new(view: View) -> Shading {
        Shading { view, light: vec![-1.0; view.width * view.height * FINE * FINE] }
    }

    pub(super) fn draw(&mut self, triangle: &Triangle, light: &Light) {
        let Some((across, down)) = slope(triangle) else { return };
        let shade = light.shade(across, down);
        let (width, height) = (self.view.width * FINE, self.view.height * FINE);
        // The middle of point i lies at i + ½.
        let place = |k: usize| {
            let (x, y) = self.view.pixel((triangle[k].column, triangle[k].row));
            (x * FINE as f64 - 0.5, y * FINE as f64 - 0.5)
        };
        points_inside([place(0), place(1), place(2)], 0..width, 0..height, |x, y| self.light[y * width + x] = shade);
    }

    pub(super) fn finish(&self) -> Canvas {
        let wide = self.view.width * FINE;
        Canvas::from_fn(self.view.width, self.view.height, |x, y| {
            let mut sum = [0.0f32; 3];
            for k in 0..FINE * FINE {
                let light = self.light[(y * FINE + k / FINE) * wide + x * FINE + k % FINE];
                let colour = if light < 0.0 { EMPTY } else { ground(light) };
                sum.iter_mut().zip(colour).for_each(|(s, c)| *s += c);
            }
            sum.map(|s| (s / (FINE * FINE) as f32).round() as u8)
        })
    }
}

/// Where there is no surface.
const EMPTY: [f32; 3] = [96.0, 112.0, 136.0];

fn ground(light: f32) -> [f32; 3] {
    [12.0 + 240.0 * light, 12.0 + 238.0 * light, 14.0 + 232.0 * light]
}

/// The raster itself, shaded by the cell under every pixel: half of it where it has three heights, none where it has fewer.
pub(super) fn shaded_samples(samples: &Samples, view: View, light: &Light) -> Canvas {
    let stride = view.stride as f64;
    Canvas::from_fn(view.width, view.height, |x, y| {
        let node = |at: usize, pixels: usize, nodes: usize| {
            let place = (at as f64 + 0.5) / pixels as f64 * (nodes - 1) as f64;
            let first = (place as usize).min(nodes - 2);
            (first, place - first as f64)
        };
        let ((i, u), (j, v)) = (node(x, view.width, samples.across), node(y, view.height, samples.down));
        let (a, b) = (samples.at(i, j), samples.at(i + 1, j));
        let (c, d) = (samples.at(i, j + 1), samples.at(i + 1, j + 1));
        let [a, b, c, d] = with_half_cells([a, b, c, d], (u, v));
        let (across, down) = rises([a, b, c, d]);
        let colour = if across.is_nan() { EMPTY } else { ground(light.shade(across / stride, down / stride)) };
        colour.map(|c| c.round() as u8)
    })
}

/// The heights of a cell (upper left and right, lower left and right) with the one that is missing put onto the plane of
/// the other three, if the place, from 0 to 1 across and down, lies in their triangle.
fn with_half_cells([a, b, c, d]: [f64; 4], (u, v): (f64, f64)) -> [f64; 4] {
    match [a, b, c, d].map(f64::is_nan) {
        [true, false, false, false] if u + v >= 1.0 => [b + c - d, b, c, d],
        [false, true, false, false] if u <= v => [a, a + d - c, c, d],
        [false, false, true, false] if u >= v => [a, b, a + d - b, d],
        [false, false, false, true] if u + v <= 1.0 => [a, b, c, b + c - a],
        _ => [a, b, c, d],
    }
}
