//! Reading windows of samples through GDAL.
//!
//! A band is always read in its own type; scale, offset and marks are applied afterwards, by us. GDAL gives other values for
//! other types of buffers: a VRT scales and compares with its nodata value in the type it is asked for.

use gdal::raster::{GdalType, RasterBand};

use super::error::reason;
use super::gdal_messages::About;
use super::sample_type::with_sample_type;
use super::{Raster, RasterError, SampleType};
use crate::base::Window;

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

    /// Reads a window as heights, scale and offset applied, rows one after the other. Missing samples come as the number
    /// they are stored as.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    ///
    /// # Panics
    /// If `out` is not `window.len()` long, or the window is not inside the raster.
    pub fn read_heights(&self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        self.read_stored(window, out)?;
        self.scale(out);
        Ok(())
    }

    /// Reads a window of stored values as doubles: exactly, but for 64-bit integers beyond 2⁵³.
    pub(super) fn read_stored(&self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        assert_eq!(out.len(), window.len(), "heights of {window:?}");
        let bytes = window.len() * self.sample_type().bytes();
        let mut words = vec![0u64; bytes.div_ceil(8)];
        let stored = &mut bytemuck::cast_slice_mut(&mut words)[..bytes];
        self.read_native(window, stored)?;
        with_sample_type!(self.sample_type(), T => {
            let stored = bytemuck::cast_slice::<u8, T>(stored);
            out.iter_mut().zip(stored).for_each(|(height, stored)| *height = stored.double());
        });
        Ok(())
    }

    /// Stored values become heights.
    pub(super) fn scale(&self, values: &mut [f64]) {
        let scaling = self.scaling();
        if !scaling.is_none() {
            values.iter_mut().for_each(|v| *v = scaling.height(*v));
        }
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

/// The types of samples as doubles, and those that GDAL reads into.
pub(super) trait Stored: bytemuck::Pod {
    /// The number, rounded where no double equals it.
    fn double(self) -> f64;

    /// The whole number, of integers.
    fn whole(self) -> i128;

    /// Reads a window of a band.
    fn read_of(raster: &Raster, band: &RasterBand<'_>, window: Window, out: &mut [Self]) -> Result<(), RasterError>;
}
macro_rules! stored {
    ($($t:ty),*) => {$(
        impl Stored for $t {
            fn double(self) -> f64 {
                self as f64
            }
            fn whole(self) -> i128 {
                self as i128
            }
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
stored!(u8, u16, i16, u32, i32, u64, i64, f32, f64);
impl Stored for i8 {
    fn double(self) -> f64 {
        f64::from(self)
    }
    fn whole(self) -> i128 {
        i128::from(self)
    }
    fn read_of(raster: &Raster, band: &RasterBand<'_>, window: Window, out: &mut [i8]) -> Result<(), RasterError> {
        raster.read_signed_bytes(band, window, bytemuck::cast_slice_mut(out))
    }
}
impl Stored for half::f16 {
    fn double(self) -> f64 {
        f64::from(self)
    }
    fn whole(self) -> i128 {
        f64::from(self) as i128
    }
    fn read_of(
        raster: &Raster,
        band: &RasterBand<'_>,
        window: Window,
        out: &mut [half::f16],
    ) -> Result<(), RasterError> {
        raster.read_half_floats(band, window, out)
    }
}
