//! Masks: which samples an alpha band or GDAL's mask of the file says are there.
//!
//! Which of them count is decided in [`MaskFlags`] and [`Masks`].

use super::gdal_error;
use gdal::raster::ColorInterpretation;

use super::{Raster, RasterError};
use crate::base::{MaskFlags, Masks, Window, mask_by_alpha};

impl Raster {
    /// Whether a mask of the file or an alpha band marks samples invalid, or one value for each band together
    /// (`NODATA_VALUES`), apart from any nodata value of the band's own.
    ///
    /// # Errors
    /// [`RasterError::Gdal`] when GDAL cannot tell.
    pub fn has_mask(&self) -> Result<bool, RasterError> {
        Ok(self.masks()?.are_some())
    }

    /// The alpha band that counts for this one, from 1.
    pub fn alpha_band(&self) -> Option<usize> {
        Masks::alpha_band(self.band, self.band_count(), |number| self.is_alpha(number))
    }

    fn is_alpha(&self, number: usize) -> bool {
        let band = self.dataset.rasterband(number);
        band.is_ok_and(|b| b.color_interpretation() == ColorInterpretation::AlphaBand)
    }

    fn masks(&self) -> Result<Masks, RasterError> {
        let flags = self.rasterband()?.mask_flags().map_err(|e| gdal_error::failed(self.path(), "mask", &e))?;
        let flags = MaskFlags {
            all_valid: flags.is_all_valid(),
            per_dataset: flags.is_per_dataset(),
            alpha: flags.is_alpha(),
            nodata: flags.is_nodata(),
        };
        Ok(Masks::of(flags, self.band, self.band_count(), |number| self.is_alpha(number)))
    }

    /// Reads the validity mask of a window: 0 is invalid.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    ///
    /// # Panics
    /// If `out` is not `window.len()` long, or the window is not inside the raster.
    pub fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.check(window);
        let masks = self.masks()?;
        if masks.file {
            let band = self.rasterband()?;
            let mask = band.open_mask_band().map_err(|e| gdal_error::failed(self.path(), "mask", &e))?;
            self.read_from(&mask, window, out)?;
        } else {
            out.fill(255);
        }
        match masks.alpha {
            Some(alpha) => self.mask_by_alpha(alpha, window, out),
            None => Ok(()),
        }
    }

    /// See [`mask_by_alpha`].
    fn mask_by_alpha(&self, alpha: usize, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let band = self.dataset.rasterband(alpha).map_err(|e| gdal_error::failed(self.path(), "alpha band", &e))?;
        let Some(sample_type) = super::open::sample_type(&band) else {
            return Err(RasterError::SampleType {
                path: self.path().to_path_buf(),
                band: alpha,
                found: super::open::type_name(&band),
            });
        };
        let mut words = vec![0u64; (window.len() * sample_type.bytes()).div_ceil(8)];
        let stored = &mut bytemuck::cast_slice_mut(&mut words)[..window.len() * sample_type.bytes()];
        self.read_stored_of(&band, sample_type, window, stored)?;
        mask_by_alpha(sample_type, stored, out);
        Ok(())
    }
}
