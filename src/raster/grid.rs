//! Rasters that are to lie on the samples of another.

use super::{Raster, RasterError};

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
}
