//! How samples fall on pixels.

use crate::base::Window;

/// Of a larger window only every second, third, … sample is looked at.
pub(super) const MOST_SAMPLES_A_SIDE: usize = 4096;

/// The window, and where its samples lie in the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    pub(super) window: Window,
    /// Pixels across.
    pub(super) width: usize,
    /// Pixels down.
    pub(super) height: usize,
    /// Samples from one that is looked at to the next.
    pub(super) stride: usize,
}

impl View {
    /// As large as fits in `size` pixels, at the window's own proportions. The picture covers the window from its
    /// first sample to its last, the ground that has a surface.
    pub(super) fn fit(window: Window, size: (usize, usize)) -> View {
        let (across, down) = ((window.width - 1) as f64, (window.height - 1) as f64);
        let scale = (size.0 as f64 / across).min(size.1 as f64 / down);
        let pixels = |cells: f64, most: usize| ((cells * scale).round() as usize).clamp(1, most);
        let stride = window.width.max(window.height).div_ceil(MOST_SAMPLES_A_SIDE);
        View { window, width: pixels(across, size.0), height: pixels(down, size.1), stride }
    }

    /// Pixels per cell across and down.
    pub(super) fn scale(&self) -> (f64, f64) {
        (self.width as f64 / (self.window.width - 1) as f64, self.height as f64 / (self.window.height - 1) as f64)
    }

    /// Whole cells in a pixel, 1 at least.
    pub(super) fn cells_per_pixel(&self) -> usize {
        (1.0 / self.scale().0.max(self.scale().1)).max(1.0) as usize
    }

    /// From (column, row) of the raster to the picture, whose pixel (x, y) covers x to x + 1 and y to y + 1.
    pub(super) fn pixel(&self, (column, row): (f64, f64)) -> (f64, f64) {
        let (sx, sy) = self.scale();
        ((column - self.window.column as f64) * sx, (row - self.window.row as f64) * sy)
    }

    /// Looked-at samples across and down.
    pub(super) fn looked_at(&self) -> (usize, usize) {
        (self.window.width.div_ceil(self.stride), self.window.height.div_ceil(self.stride))
    }
}
