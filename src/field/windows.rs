use std::sync::Mutex;

use super::FieldError;
use crate::raster::{Opening, Raster, RasterError, Window};

/// Samples read through GDAL window by window, when they are wanted: nothing is decoded beforehand.
///
/// A GDAL dataset serves one thread at a time and keeps its own blocks in GDAL's cache, so every thread of the pool has
/// a handle of its own: tiles are worked on in runs, and the blocks that a tile shares with the one before it are mostly
/// still there. Locks are never waited for, but by threads outside the pool, which share a handle.
pub(super) struct Windows {
    opening: Opening,
    masked: bool,
    handles: Vec<Mutex<Option<Raster>>>,
}

impl Windows {
    pub(super) fn new(raster: &Raster) -> Result<Windows, RasterError> {
        Ok(Windows {
            opening: raster.opening(),
            masked: raster.has_mask()?,
            handles: (0..=rayon::current_num_threads()).map(|_| Mutex::default()).collect(),
        })
    }

    /// Reads a window as it is stored, refusing masked samples. `words` is scratch memory; the samples are its first
    /// bytes.
    pub(super) fn read<'a>(&self, window: Window, words: &'a mut Vec<u64>) -> Result<&'a [u8], FieldError> {
        let last = self.handles.len() - 1;
        let own = rayon::current_thread_index().map_or(last, |thread| thread.min(last));
        // What a panic leaves here is a handle, or none.
        let mut handle = self.handles[own].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let raster = match handle.take() {
            Some(raster) => raster,
            None => self.opening.open()?,
        };
        let bytes = window.len() * raster.sample_type().bytes();
        words.resize(bytes.div_ceil(8), 0);
        let samples = &mut bytemuck::cast_slice_mut(words)[..bytes];
        raster.read_native(window, samples)?;
        if self.masked {
            refuse_masked(&raster, window)?;
        }
        *handle = Some(raster);
        Ok(samples)
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
