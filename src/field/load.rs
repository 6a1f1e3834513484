//! From stored samples to the heights of a tile.

use super::stored::{Height, Stored};
use super::tile::padded;
use super::{Field, FieldError, Tile};
use crate::exact::MAX_WEIGHT;
use crate::raster::{Window, with_sample_type};

impl Field {
    /// Copies a window into `tile` as heights, with weights where the field has them, and beside them the channels'
    /// values, reusing its memory.
    ///
    /// # Errors
    /// [`FieldError::Nodata`], [`FieldError::NotAHeight`], [`FieldError::NotAWeight`], [`FieldError::Inexact`], each
    /// naming such a sample of the window; [`FieldError::Raster`] where windows are read from the raster itself.
    ///
    /// # Panics
    /// If the window is not inside the field.
    pub fn load(&self, window: Window, tile: &mut Tile) -> Result<(), FieldError> {
        let inside = window.column + window.width <= self.width && window.row + window.height <= self.height;
        assert!(inside, "{window:?} of a field of {} × {}", self.width, self.height);
        tile.width = window.width;
        tile.height = window.height;
        let Tile { heights, weights, channels, stored, .. } = tile;
        match &self.importance {
            Some(importance) => importance.load_weights(window, stored, padded(weights, window.len()))?,
            None => weights.clear(),
        }
        if self.fits_f32() {
            let heights = heights.as_f32(window.len());
            with_sample_type!(self.sample_type, T => self.copy::<T, f32>(window, stored, heights))?;
        } else {
            let heights = heights.as_f64(window.len());
            with_sample_type!(self.sample_type, T => self.copy::<T, f64>(window, stored, heights))?;
        }
        let fields = self.channels.iter().flat_map(|c| &c.fields);
        channels.resize_with(self.channels().len(), Vec::new);
        fields.zip(channels).try_for_each(|(field, values)| field.load_values(window, values, stored))?;
        tile.channel_error = self.channels.as_ref().map(|c| c.error.clone());
        Ok(())
    }

    /// Whether tiles of this field hold their heights in single precision.
    pub fn fits_f32(&self) -> bool {
        self.importance.is_none() && self.sample_type.fits_f32() && self.scaling.is_none()
    }

    /// Copies a window of an importance raster as weights.
    fn load_weights(&self, window: Window, stored: &mut Vec<u64>, out: &mut [f64]) -> Result<(), FieldError> {
        with_sample_type!(self.sample_type, T => self.copy::<T, f64>(window, stored, out))
            .map_err(FieldError::about_a_weight)?;
        let Some(index) = out.iter().position(|weight| !(0.0..=MAX_WEIGHT).contains(weight)) else { return Ok(()) };
        Err(FieldError::NotAWeight {
            path: self.name.clone(),
            column: window.column + index % window.width,
            row: window.row + index / window.width,
            found: out[index].to_string(),
        })
    }

    pub(super) fn copy<T: Stored, H: Height>(
        &self,
        window: Window,
        scratch: &mut Vec<u64>,
        out: &mut [H],
    ) -> Result<(), FieldError> {
        let nodata = T::nodata(self.nodata);
        let scaling = (!self.scaling.is_none()).then_some(self.scaling);
        self.source.for_each_run(&self.name, window, scratch, |row, column, bytes| {
            let start = row * window.width + column;
            let run = &mut out[start..start + bytes.len() / size_of::<T>()];
            let mut suspicious = false;
            for (height, stored) in run.iter_mut().zip(bytes.chunks_exact(size_of::<T>())) {
                let stored: T = bytemuck::pod_read_unaligned(stored);
                *height = H::of(stored, scaling);
                suspicious |= !height.usable() | nodata.is_some_and(|n| stored == n) | !stored.exact();
            }
            if !suspicious {
                return Ok(());
            }
            let bad = bytes.chunks_exact(size_of::<T>()).enumerate().find_map(|(i, stored)| {
                let stored: T = bytemuck::pod_read_unaligned(stored);
                self.refusal(stored, nodata, window.column + column + i, window.row + row)
            });
            bad.map_or(Ok(()), Err)
        })
    }

    /// Why the value stored at this place is no height, if it is none.
    fn refusal<T: Stored>(&self, stored: T, nodata: Option<T>, column: usize, row: usize) -> Option<FieldError> {
        let path = self.name.clone();
        let value = stored.to_f64();
        let height = self.scaling.height(value);
        if value.is_nan() || nodata == Some(stored) {
            return Some(FieldError::Nodata { path, column, row, found: value.to_string() });
        }
        if !stored.exact() {
            return Some(FieldError::Inexact { path, column, row, found: stored.to_i128() });
        }
        (!height.usable()).then_some(FieldError::NotAHeight { path, column, row, found: height })
    }
}
