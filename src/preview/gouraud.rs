//! Colours of the vertices, blended across every triangle.

use super::canvas::Canvas;
use super::colours::NO_GROUND;
use super::mesh::Triangle;
use super::scan::points_inside;
use super::view::View;

/// What a mesh's colours are called.
pub(super) const COLOURS: [&str; 3] = ["red", "green", "blue"];

/// Triangles in the colours of their corners; a pixel has that of its middle.
pub(super) struct Gouraud {
    view: View,
    canvas: Canvas,
}

impl Gouraud {
    pub(super) fn new(view: View) -> Gouraud {
        Gouraud { view, canvas: Canvas::filled(view.width, view.height, NO_GROUND) }
    }

    pub(super) fn draw(&mut self, triangle: &Triangle) {
        let [a, b, c] = triangle.map(|corner| {
            // The middle of pixel i lies at i + ½.
            let (x, y) = self.view.pixel((corner.column, corner.row));
            (x - 0.5, y - 0.5)
        });
        let colours = triangle.map(|corner| corner.colour.map(f64::from));
        let area = (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
        let (width, height) = (self.view.width, self.view.height);
        points_inside([a, b, c], 0..width, 0..height, |x, y| {
            let (px, py) = (x as f64 - a.0, y as f64 - a.1);
            let of_b = (px * (c.1 - a.1) - py * (c.0 - a.0)) / area;
            let of_c = (py * (b.0 - a.0) - px * (b.1 - a.1)) / area;
            let mix = |i: usize| {
                let [ca, cb, cc] = [colours[0][i], colours[1][i], colours[2][i]];
                (ca + (cb - ca) * of_b + (cc - ca) * of_c).round().clamp(0.0, 255.0) as u8
            };
            self.canvas.pixels[y * width + x] = [mix(0), mix(1), mix(2)];
        });
    }

    pub(super) fn finish(self) -> Canvas {
        self.canvas
    }
}
