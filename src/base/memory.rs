//! Samples in memory as a band.

use std::path::PathBuf;
use std::sync::Arc;

use super::{Band, RasterError, SampleType, Window, Windows};

/// Stored values of a whole band, row by row, in the machine's byte order: bytes of this program, or of another that lends
/// them, such as an array of Python.
#[derive(Clone)]
struct Memory {
    bytes: Arc<dyn AsRef<[u8]> + Send + Sync>,
    width: usize,
    sample_bytes: usize,
}

impl Windows for Memory {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        let bytes = (*self.bytes).as_ref();
        let row_bytes = window.width * self.sample_bytes;
        for (row, out) in (window.row..).zip(out.chunks_exact_mut(row_bytes)) {
            let start = (row * self.width + window.column) * self.sample_bytes;
            out.copy_from_slice(&bytes[start..start + row_bytes]);
        }
        Ok(())
    }
}

impl Band {
    /// A band over stored values in memory, row by row, in the machine's byte order; nothing is copied. `name` is what
    /// messages call it. See [`Band::new`] for what else it has.
    ///
    /// # Errors
    /// [`RasterError::TooSmall`]; [`RasterError::Length`] if there are not as many bytes as samples of this type need.
    pub fn in_memory(
        name: impl Into<PathBuf>,
        (width, height): (usize, usize),
        sample_type: SampleType,
        bytes: Arc<dyn AsRef<[u8]> + Send + Sync>,
    ) -> Result<Band, RasterError> {
        let path = name.into();
        let (found, sample_bytes) = ((*bytes).as_ref().len(), sample_type.bytes());
        let expected = width.checked_mul(height).and_then(|n| n.checked_mul(sample_bytes));
        if expected != Some(found) {
            return Err(RasterError::Length { path, width, height, sample_type: sample_type.name(), found });
        }
        Band::new(path, (width, height), sample_type, Arc::new(Memory { bytes, width, sample_bytes }))
    }

    /// A band over heights in single precision, row by row. See [`Band::in_memory`].
    ///
    /// # Errors
    /// As [`Band::in_memory`].
    pub fn of_singles(name: impl Into<PathBuf>, size: (usize, usize), heights: Vec<f32>) -> Result<Band, RasterError> {
        Band::in_memory(name, size, SampleType::F32, Arc::new(Numbers(heights)))
    }

    /// A band over heights in double precision, row by row. See [`Band::in_memory`].
    ///
    /// # Errors
    /// As [`Band::in_memory`].
    pub fn of_doubles(name: impl Into<PathBuf>, size: (usize, usize), heights: Vec<f64>) -> Result<Band, RasterError> {
        Band::in_memory(name, size, SampleType::F64, Arc::new(Numbers(heights)))
    }
}

struct Numbers<T>(Vec<T>);

impl<T: bytemuck::NoUninit> AsRef<[u8]> for Numbers<T> {
    fn as_ref(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }
}
