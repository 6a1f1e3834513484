//! The samples that are looked at.

use super::PreviewError;
use super::view::View;
use crate::base::Band;
use crate::base::Window;
use crate::base::control::{Control, Stage};
use crate::verify::HeightReader;

/// The looked-at samples of the window.
pub(super) struct Samples {
    pub(super) across: usize,
    pub(super) down: usize,
    /// Row by row; NaN where there is no height, or no ground.
    pub(super) heights: Vec<f64>,
    /// What errors weigh, row by row; empty where all weigh the same.
    pub(super) weights: Vec<f64>,
}

impl Samples {
    /// Reads the samples of a band, and what errors weigh there.
    pub(super) fn read(
        band: &Band,
        importance: Option<&Band>,
        view: &View,
        control: &Control,
    ) -> Result<Samples, PreviewError> {
        let (across, down) = view.looked_at();
        let heights = rows(band, view, control)?;
        let weights = importance.map(|band| rows(band, view, control)).transpose()?.unwrap_or_default();
        let mut samples = Samples { across, down, heights, weights };
        if view.stride == 1 {
            samples.leave_out_those_without_ground();
        }
        Ok(samples)
    }

    /// The same where samples are colours: heights are 0 wherever there is one.
    pub(super) fn levelled(mut self) -> Samples {
        self.heights.iter_mut().filter(|h| !h.is_nan()).for_each(|h| *h = 0.0);
        self
    }

    /// A sample in no cell with three heights is to have no surface. At the rim of the window its cells are not all known.
    fn leave_out_those_without_ground(&mut self) {
        let (across, down) = (self.across, self.down);
        let cell = |i: usize, j: usize| {
            let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
            corners.iter().filter(|&&(i, j)| !self.at(i, j).is_nan()).count() >= 3
        };
        let inner = (1..down - 1).flat_map(|j| (1..across - 1).map(move |i| (i, j)));
        let bare = inner.filter(|&(i, j)| !self.at(i, j).is_nan());
        let around = |i: usize, j: usize| [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)];
        let bare: Vec<usize> = bare
            .filter(|&(i, j)| !around(i, j).iter().any(|&(i, j)| cell(i, j)))
            .map(|(i, j)| j * across + i)
            .collect();
        bare.into_iter().for_each(|k| self.heights[k] = f64::NAN);
    }

    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * self.across + i]
    }
}

/// The looked-at samples, one row of the raster at a time.
fn rows(band: &Band, view: &View, control: &Control) -> Result<Vec<f64>, PreviewError> {
    let (across, down) = view.looked_at();
    let mut values = Vec::with_capacity(across * down);
    let mut reader = HeightReader::new(band);
    let mut line = vec![0.0; view.window.width];
    control.progress.begin(Stage::Rows, down as u64, view.window.len() as u64);
    for j in 0..down {
        control.cancel.check()?;
        let row = Window { row: view.window.row + j * view.stride, height: 1, ..view.window };
        reader.read(row, &mut line)?;
        // Nothing can be drawn of an infinite height.
        let drawn = |&h: &f64| if h.is_finite() { h } else { f64::NAN };
        values.extend(line.iter().step_by(view.stride).map(drawn));
        control.progress.step(Stage::Rows, view.window.width as u64);
    }
    control.progress.end(Stage::Rows);
    Ok(values)
}
