use std::sync::Mutex;

use super::FieldError;
use crate::base::Window;
use crate::raster::{Opening, Raster, RasterError, SampleType};

/// Samples read through GDAL window by window, when they are wanted: nothing is decoded beforehand.
///
/// A GDAL dataset serves one thread at a time and keeps its own blocks in GDAL's cache, so every thread of the pool has
/// a handle of its own: tiles are worked on in runs, and the blocks that a tile shares with the one before it are mostly
/// still there. Locks are never waited for, but by threads outside the pool, which share a handle.
pub(super) struct Windows {
    opening: Opening,
    shape: (usize, usize, SampleType),
    handles: Vec<Mutex<Option<Raster>>>,
}

impl Windows {
    pub(super) fn new(raster: &Raster) -> Windows {
        Windows {
            opening: raster.opening(),
            shape: shape(raster),
            handles: (0..=rayon::current_num_threads()).map(|_| Mutex::default()).collect(),
        }
    }

    /// Reads a window as it is stored. `words` is scratch memory; the samples are its first bytes.
    pub(super) fn read<'a>(&self, window: Window, words: &'a mut Vec<u64>) -> Result<&'a [u8], FieldError> {
        self.with_handle(|raster| {
            let samples = room(words, window.len() * raster.sample_type().bytes());
            raster.read_native(window, samples)?;
            Ok(&*samples)
        })
    }

    /// Reads the mask of a window, a byte for every sample: 0 is invalid.
    pub(super) fn read_mask<'a>(&self, window: Window, words: &'a mut Vec<u64>) -> Result<&'a [u8], FieldError> {
        self.with_handle(|raster| {
            let mask = room(words, window.len());
            raster.read_mask(window, mask)?;
            Ok(&*mask)
        })
    }

    /// A handle more. By now there may be another raster under the name.
    fn reopened(&self) -> Result<Raster, FieldError> {
        let raster = self.opening.open()?;
        let said = |(width, height, sample_type): (usize, usize, SampleType)| {
            format!("{width} × {height} of type {}", sample_type.name())
        };
        let (expected, found) = (said(self.shape), said(shape(&raster)));
        if expected == found {
            return Ok(raster);
        }
        let (path, what) = (raster.path().to_path_buf(), "samples".to_string());
        Err(RasterError::Changed { path, what, expected, found }.into())
    }

    fn with_handle<T>(&self, read: impl FnOnce(&Raster) -> Result<T, FieldError>) -> Result<T, FieldError> {
        let last = self.handles.len() - 1;
        let own = rayon::current_thread_index().map_or(last, |thread| thread.min(last));
        // What a panic leaves here is a handle, or none.
        let mut handle = self.handles[own].lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let raster = match handle.take() {
            Some(raster) => raster,
            None => self.reopened()?,
        };
        let found = read(&raster)?;
        *handle = Some(raster);
        Ok(found)
    }
}

/// What windows depend on.
fn shape(raster: &Raster) -> (usize, usize, SampleType) {
    (raster.width(), raster.height(), raster.sample_type())
}

/// So many bytes, aligned for every type of sample.
fn room(words: &mut Vec<u64>, bytes: usize) -> &mut [u8] {
    words.resize(bytes.div_ceil(8), 0);
    &mut bytemuck::cast_slice_mut(words)[..bytes]
}
