use super::PreviewError;
use super::view::View;
use crate::control::{Control, Stage};
use crate::raster::{Nodata, Raster, SampleType, Window};

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
        let masked = raster.has_mask()?;
        let mut heights = Vec::with_capacity(across * down);
        let (mut line, mut mask) = (vec![0.0; view.window.width], vec![255u8; view.window.width]);
        control.progress.begin(Stage::Rows, down as u64, view.window.len() as u64);
        for j in 0..down {
            control.cancel.check()?;
            let row = Window { row: view.window.row + j * view.stride, height: 1, ..view.window };
            raster.read_heights(row, &mut line)?;
            if masked {
                raster.read_mask(row, &mut mask)?;
            }
            let valid = |h: f64, m: u8| if m == 0 || is_nodata(raster, h) { f64::NAN } else { h };
            heights.extend(line.iter().zip(&mask).step_by(view.stride).map(|(&h, &m)| valid(h, m)));
            control.progress.step(Stage::Rows, view.window.width as u64);
        }
        control.progress.end(Stage::Rows);
        Ok(Samples { across, down, heights })
    }

    pub(super) fn at(&self, i: usize, j: usize) -> f64 {
        self.heights[j * self.across + i]
    }
}

/// Whether a height read from the raster is its mark of no height.
fn is_nodata(raster: &Raster, height: f64) -> bool {
    let height_of = |stored| raster.scaling().height(stored);
    !height.is_finite()
        || match raster.nodata() {
            Nodata::None => false,
            // A tag is written with more digits than a single-precision sample has.
            Nodata::Real(v) if raster.sample_type() == SampleType::F32 => {
                height == height_of(v) || height == height_of(f64::from(v as f32))
            }
            Nodata::Real(v) => height == height_of(v),
            Nodata::I64(v) => height == height_of(v as f64),
            Nodata::U64(v) => height == height_of(v as f64),
        }
}
