//! Reading windows of samples through GDAL.
//!
//! A band is always read in its own type; scale, offset and marks are applied afterwards, by us. GDAL gives other values for
//! other types of buffers: a VRT scales and compares with its nodata value in the type it is asked for.

use gdal::raster::{GdalType, RasterBand};

use super::gdal_error::reason;
use super::gdal_messages::About;
use super::{Raster, RasterError};
use crate::base::SampleType;
use crate::base::Window;
use crate::base::with_sample_type;

impl Raster {
    /// Reads a window as it is stored, in the machine's byte order, rows one after the other; of encoded heights, the
    /// heights as doubles. `out` is `window.len()` samples long and aligned to 8 bytes.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    ///
    /// # Panics
    /// If `out` has another length, or the window is not inside the raster.
    pub fn read_native(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.check(window);
        assert_eq!(out.len(), window.len() * self.sample_type().bytes(), "buffer of {window:?}");
        match self.encoded {
            Some(encoded) => self.read_encoded(encoded, window, bytemuck::cast_slice_mut(out)),
            None => self.read_stored_of(&self.rasterband()?, self.sample_type(), window, out),
        }
    }

    /// Reads a window of a band of this type as it is stored.
    pub(super) fn read_stored_of(
        &self,
        band: &RasterBand<'_>,
        sample_type: SampleType,
        window: Window,
        out: &mut [u8],
    ) -> Result<(), RasterError> {
        with_sample_type!(sample_type, T => T::read_of(self, band, window, bytemuck::cast_slice_mut(out)))
    }

    /// GDAL before 3.7 has signed bytes as bytes with a mark; later ones have a type for them, which these bindings do
    /// not always know, and would cut negative values off on the way to bytes: it is read as 16-bit integers.
    fn read_signed_bytes(&self, band: &RasterBand<'_>, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        if band.band_type().name() == "Byte" {
            return self.read_from(band, window, out);
        }
        let mut wide = vec![0i16; out.len()];
        self.read_from(band, window, &mut wide)?;
        for (byte, value) in out.iter_mut().zip(wide) {
            *byte = value as i8 as u8;
        }
        Ok(())
    }

    /// These bindings have no type for them; single precision holds all of them.
    fn read_half_floats(
        &self,
        band: &RasterBand<'_>,
        window: Window,
        out: &mut [half::f16],
    ) -> Result<(), RasterError> {
        let mut wide = vec![0f32; out.len()];
        self.read_from(band, window, &mut wide)?;
        out.iter_mut().zip(wide).for_each(|(half, value)| *half = half::f16::from_f32(value));
        Ok(())
    }

    /// Reads a window of any band of the dataset, by GDAL, in this type.
    pub(super) fn read_from<T: GdalType + Copy>(
        &self,
        band: &RasterBand<'_>,
        window: Window,
        out: &mut [T],
    ) -> Result<(), RasterError> {
        let _about = About::reading(self.path());
        let (at, size) = (self.in_whole(window), (window.width, window.height));
        band.read_into_slice((at.column as isize, at.row as isize), size, size, out, None).map_err(|error| {
            let Window { column, row, width, height } = window;
            RasterError::Read { path: self.path().to_path_buf(), column, row, width, height, reason: reason(&error) }
        })
    }

    pub(super) fn check(&self, w: Window) {
        let inside = w.column + w.width <= self.width() && w.row + w.height <= self.height();
        assert!(inside, "{w:?} of a raster of {} × {}", self.width(), self.height());
    }
}

/// The types of samples that GDAL reads into.
pub(super) trait Read: bytemuck::Pod {
    /// Reads a window of a band.
    fn read_of(raster: &Raster, band: &RasterBand<'_>, window: Window, out: &mut [Self]) -> Result<(), RasterError>;
}
macro_rules! read {
    ($($t:ty),*) => {$(
        impl Read for $t {
            fn read_of(
                raster: &Raster,
                band: &RasterBand<'_>,
                window: Window,
                out: &mut [Self],
            ) -> Result<(), RasterError> {
                raster.read_from(band, window, out)
            }
        }
    )*};
}
read!(u8, u16, i16, u32, i32, u64, i64, f32, f64);
impl Read for i8 {
    fn read_of(raster: &Raster, band: &RasterBand<'_>, window: Window, out: &mut [i8]) -> Result<(), RasterError> {
        raster.read_signed_bytes(band, window, bytemuck::cast_slice_mut(out))
    }
}
impl Read for half::f16 {
    fn read_of(
        raster: &Raster,
        band: &RasterBand<'_>,
        window: Window,
        out: &mut [half::f16],
    ) -> Result<(), RasterError> {
        raster.read_half_floats(band, window, out)
    }
}
