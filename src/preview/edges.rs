//! The edges of triangles.

use tiny_skia::{Paint, PathBuilder, Pixmap, Stroke, Transform};

use super::canvas::Canvas;
use super::mesh::Triangle;
use super::view::View;

/// Edges of triangles, drawn thin and smooth on a layer of their own.
pub(super) struct Edges {
    view: View,
    layer: Pixmap,
    path: PathBuilder,
    pending: usize,
}

/// Triangles that are drawn at a time: enough to spare calls, few enough to spare memory.
const BATCH: usize = 4096;

impl Edges {
    /// `None` where the picture has more pixels than the drawing library takes.
    pub(super) fn new(view: View) -> Option<Edges> {
        let layer = Pixmap::new(u32::try_from(view.width).ok()?, u32::try_from(view.height).ok()?)?;
        Some(Edges { view, layer, path: PathBuilder::new(), pending: 0 })
    }

    pub(super) fn draw(&mut self, triangle: &Triangle) {
        let place = |k: usize| {
            let (x, y) = self.view.pixel((triangle[k].column, triangle[k].row));
            (x as f32, y as f32)
        };
        let [a, b, c] = [place(0), place(1), place(2)];
        self.path.move_to(a.0, a.1);
        self.path.line_to(b.0, b.1);
        self.path.line_to(c.0, c.1);
        self.path.close();
        self.pending += 1;
        if self.pending == BATCH {
            self.flush();
        }
    }

    fn flush(&mut self) {
        self.pending = 0;
        let Some(path) = std::mem::replace(&mut self.path, PathBuilder::new()).finish() else { return };
        let mut paint = Paint { anti_alias: true, ..Paint::default() };
        paint.set_color_rgba8(0, 0, 0, 255);
        let stroke = Stroke { width: 0.7, ..Stroke::default() };
        self.layer.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
    }

    /// Lays the edges over a picture of the same size. The more triangles there are, the fainter they are: at less
    /// than a pixel each they would be nothing but black.
    pub(super) fn finish(mut self, triangles: u64, canvas: &mut Canvas) {
        self.flush();
        let pixels_each = (canvas.width * canvas.height) as f64 / triangles.max(1) as f64;
        let strength = (pixels_each.sqrt() / 10.0).clamp(0.12, 0.75) as f32;
        for (k, edge) in self.layer.pixels().iter().enumerate() {
            let cover = f32::from(edge.alpha()) / 255.0 * strength;
            canvas.blend(k % self.view.width, k / self.view.width, COLOUR, cover);
        }
    }
}

const COLOUR: [u8; 3] = [24, 48, 110];
