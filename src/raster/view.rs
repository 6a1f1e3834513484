//! How a raster is to be looked at, as data: whatever the order in which it was said, it is applied in one.

use std::path::Path;

use super::{BoundingBox, CutlineSource, Raster, RasterError, ShapesError, read_cutline};
use crate::base::Window;
use crate::base::control::CancelToken;
use crate::base::warning::Warning;
use crate::base::{Encoding, ValidRange};

/// Which part of a raster is meant.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Part {
    /// All of it.
    #[default]
    Whole,
    /// These samples.
    Window(Window),
    /// The samples inside a box on the map.
    Box(BoundingBox),
}

/// A view of a raster's heights: everything that decides which samples a run sees and what they are.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct View {
    /// The band, from 1; `None` is band 1, which must not be a colour then.
    pub band: Option<usize>,
    /// Open options of the format's driver, `NAME=VALUE` each.
    pub open_options: Vec<String>,
    /// How heights are stored as colours, if they are.
    pub encoding: Option<Encoding>,
    /// The part of the raster.
    pub part: Part,
    /// The marks of missing samples, see [`Raster::with_nodata`].
    pub nodata: Vec<String>,
    /// The heights that are valid, if not all are.
    pub valid_range: Option<ValidRange>,
    /// Polygons outside of which samples have no height.
    pub cutline: Option<CutlineSource>,
    /// Whether a raster of colours is accepted although no band is named.
    pub accept_pictures: bool,
}

/// Why a view cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The raster cannot be used.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The cutline cannot be used.
    #[error(transparent)]
    Cutline(#[from] ShapesError),
}

impl View {
    /// A view of the whole raster by a band, from 1.
    pub fn of_band(band: usize) -> View {
        View { band: Some(band), ..View::default() }
    }

    /// Opens the raster at `path` and applies the view.
    ///
    /// # Errors
    /// [`ViewError`]: what [`Raster::open`], [`Raster::expect_heights`], [`Raster::clip`], [`Raster::window_of`],
    /// [`Raster::with_nodata`] and [`read_cutline`] refuse.
    pub fn open(&self, path: &Path, cancel: &CancelToken) -> Result<Raster, ViewError> {
        let raster = Raster::open_with(path, self.band.unwrap_or(1), &self.open_options)?;
        let raster = match self.encoding {
            Some(encoding) => raster.with_encoding(encoding)?,
            None => raster,
        };
        if self.band.is_none() && !self.accept_pictures {
            raster.expect_heights()?;
        }
        let mut raster = self.part(raster)?.with_nodata(&self.nodata)?;
        raster.warnings.extend(raster.unreachable_tag());
        raster.warnings.extend(raster.caveats());
        let mut raster = match self.valid_range {
            Some(valid) => raster.with_valid_range(valid),
            None => raster,
        };
        match &self.cutline {
            Some(source) => {
                let (cutline, without_geometry) = read_cutline(&raster, source, cancel)?;
                raster.warnings.extend(Warning::of_no_geometry(&source.path, without_geometry));
                Ok(raster.with_cutline(cutline))
            }
            None => Ok(raster),
        }
    }

    fn part(&self, raster: Raster) -> Result<Raster, RasterError> {
        match &self.part {
            Part::Whole => Ok(raster),
            Part::Window(window) => raster.clip(*window),
            Part::Box(bounds) => {
                let window = raster.window_of(bounds)?;
                raster.clip(window)
            }
        }
    }
}
