//! Rasters that are to lie on the samples of another.

use std::path::Path;

use super::{Raster, RasterError, View};

impl Raster {
    /// The raster `other`, cut like this one where it is as large as the whole of this one.
    ///
    /// # Errors
    /// As [`Raster::clip`].
    pub fn clip_alike(&self, other: Raster) -> Result<Raster, RasterError> {
        match self.window() {
            Some(window) if other.whole_size() == self.whole_size() => other.clip(window),
            _ => Ok(other),
        }
    }

    /// Opens another raster that lies on the samples of this one, such as weights: the band and open options of `view`, cut
    /// as this one is.
    ///
    /// # Errors
    /// As [`Raster::open_with`] and [`Raster::clip_alike`]; [`RasterError::OtherGrid`].
    pub fn open_on_its_grid(&self, path: &Path, view: &View) -> Result<Raster, RasterError> {
        let other = self.clip_alike(Raster::open_with(path, view.band.unwrap_or(1), &view.open_options)?)?;
        self.to_band()?.same_grid(&other.to_band()?)?;
        Ok(other)
    }
}
