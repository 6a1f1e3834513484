use std::path::PathBuf;
use std::sync::Mutex;

use super::FieldError;
use crate::raster::{Raster, RasterError, Window};

/// Samples read through GDAL window by window, when they are wanted: nothing is decoded beforehand.
///
/// A GDAL dataset serves one thread at a time, so handles are kept in a pool: there are never more than threads that
/// read at once, and the lock is held only to take one out and to put it back.
pub(super) struct Windows {
    path: PathBuf,
    band: usize,
    masked: bool,
    idle: Mutex<Vec<Raster>>,
}

impl Windows {
    pub(super) fn new(raster: &Raster) -> Result<Windows, RasterError> {
        Ok(Windows {
            path: raster.path().to_path_buf(),
            band: raster.band(),
            masked: raster.has_mask()?,
            idle: Mutex::default(),
        })
    }

    /// Reads a window as it is stored, refusing masked samples. `words` is scratch memory; the samples are its first
    /// bytes.
    pub(super) fn read<'a>(&self, window: Window, words: &'a mut Vec<u64>) -> Result<&'a [u8], FieldError> {
        let taken = self.idle().pop();
        let raster = taken.map_or_else(|| Raster::open(&self.path, self.band), Ok)?;
        let bytes = window.len() * raster.sample_type().bytes();
        words.resize(bytes.div_ceil(8), 0);
        let samples = &mut bytemuck::cast_slice_mut(words)[..bytes];
        raster.read_native(window, samples)?;
        if self.masked {
            refuse_masked(&raster, window)?;
        }
        self.idle().push(raster);
        Ok(samples)
    }

    /// A handle that met an error is dropped, so what a panic leaves here is whole.
    fn idle(&self) -> std::sync::MutexGuard<'_, Vec<Raster>> {
        self.idle.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// Refuses a window that holds samples which a mask or alpha band marks invalid.
pub(super) fn refuse_masked(source: &Raster, window: Window) -> Result<(), FieldError> {
    let mut mask = vec![0u8; window.len()];
    source.read_mask(window, &mut mask)?;
    let Some(index) = mask.iter().position(|&m| m == 0) else { return Ok(()) };
    Err(FieldError::Nodata {
        path: source.path().to_path_buf(),
        column: window.column + index % window.width,
        row: window.row + index / window.width,
        found: "masked".to_string(),
    })
}
