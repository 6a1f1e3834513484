use super::PreviewError;
use super::view::View;
use crate::control::{Control, Stage};
use crate::raster::{Raster, Window};

/// The looked-at samples of the window.
pub(super) struct Samples {
    pub(super) across: usize,
    pub(super) down: usize,
    /// Row by row; NaN where there is no height.
    pub(super) heights: Vec<f64>,
}

impl Samples {
    /// Reads one row of the raster at a time.
    pub(super) fn read(raster: &Raster, view: &View, control: &Control) -> Result<Samples, PreviewError> {
        let (across, down) = view.looked_at();
        let mut heights = Vec::with_capacity(across * down);
        let mut line = vec![0.0; view.window.width];
        control.progress.begin(Stage::Rows, down as u64, view.window.len() as u64);
        for j in 0..down {
            control.cancel.check()?;
            let row = Window { row: view.window.row + j * view.stride, height: 1, ..view.window };
            raster.read_valid_heights(row, &mut line)?;
            // Nothing can be drawn of an infinite height.
            let drawn = |&h: &f64| if h.is_finite() { h } else { f64::NAN };
            heights.extend(line.iter().step_by(view.stride).map(drawn));
            control.progress.step(Stage::Rows, view.window.width as u64);
        }
        control.progress.end(Stage::Rows);
        Ok(Samples { across, down, heights })
    }

    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * self.across + i]
    }
}
