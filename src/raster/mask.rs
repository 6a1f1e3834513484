//! Masks: which samples an alpha band or GDAL's mask of the file says are there.
//!
//! The last band whose colour is alpha counts, of whatever type; GDAL's own masks heed alpha bands of bytes and UInt16
//! only, of two or four bands, and none beside a nodata tag. Masks of the file (`.msk`, internal ones) and one nodata value
//! for all bands together (`NODATA_VALUES`) come from GDAL. What GDAL makes of the nodata tag is not asked: `marks` says it.

use super::gdal_error;
use gdal::raster::ColorInterpretation;

use super::{Raster, RasterError};
use crate::base::Window;
use crate::base::with_sample_type;

/// What says that samples are missing, beside marks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Masks {
    /// GDAL's mask of the file.
    file: bool,
    /// The alpha band, from 1.
    alpha: Option<usize>,
}

impl Raster {
    /// Whether a mask of the file or an alpha band marks samples invalid, or one value for each band together
    /// (`NODATA_VALUES`), apart from any nodata value of the band's own.
    ///
    /// # Errors
    /// [`RasterError::Gdal`] when GDAL cannot tell.
    pub fn has_mask(&self) -> Result<bool, RasterError> {
        let masks = self.masks()?;
        Ok(masks.file || masks.alpha.is_some())
    }

    /// The alpha band that counts for this one, from 1.
    pub fn alpha_band(&self) -> Option<usize> {
        let is_alpha = |n: &usize| {
            let band = self.dataset.rasterband(*n);
            band.is_ok_and(|b| b.color_interpretation() == ColorInterpretation::AlphaBand)
        };
        (1..=self.band_count()).rev().find(is_alpha).filter(|n| *n != self.band)
    }

    fn masks(&self) -> Result<Masks, RasterError> {
        let flags = self.rasterband()?.mask_flags().map_err(|e| gdal_error::failed(self.path(), "mask", &e))?;
        let of_file = !flags.is_all_valid() && !flags.is_alpha() && (!flags.is_nodata() || flags.is_per_dataset());
        Ok(Masks { file: of_file, alpha: self.alpha_band() })
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

    /// Where alpha is 0 or NaN, nothing is there.
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
        with_sample_type!(sample_type, T => {
            for (valid, value) in out.iter_mut().zip(bytemuck::cast_slice::<u8, T>(stored)) {
                // NaN is equal to nothing, itself included.
                #[allow(clippy::eq_op)]
                if *value == T::default() || *value != *value {
                    *valid = 0;
                }
            }
        });
        Ok(())
    }
}
