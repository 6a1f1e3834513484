//! Where the stored samples of a field are.

use std::path::Path;
use std::sync::Arc;

use super::FieldError;
use super::partial::Partial;
use super::store::Store;
use crate::base::{Band, Window};

/// Where the samples of a field come from.
pub(super) enum Source {
    /// Blocks in memory or mapped.
    Blocks(Store),
    /// The same, read into a temporary file when they are wanted for the first time.
    Partial(Partial),
    /// The band itself, by windows.
    Windows(Arc<Band>),
    /// The band's mask: a byte for every sample, 0 where it is invalid.
    Masks(Arc<Band>),
    /// Nowhere: bytes of 0.
    Level,
}

impl Source {
    /// Calls `run(row, column, bytes)` for runs of stored samples that together are the window; rows and columns are
    /// counted from its corner. `name` is for messages, `scratch` is memory for windows read from the raster.
    pub(super) fn for_each_run(
        &self,
        name: &Path,
        window: Window,
        scratch: &mut Vec<u64>,
        mut run: impl FnMut(usize, usize, &[u8]) -> Result<(), FieldError>,
    ) -> Result<(), FieldError> {
        match self {
            Source::Blocks(store) => {
                if let Some((expected, found)) = store.truncated() {
                    return Err(FieldError::Truncated { path: name.to_path_buf(), expected, found });
                }
                store.for_each_run(window, run)
            }
            Source::Partial(partial) => partial.with(window)?.for_each_run(window, run),
            Source::Level => {
                scratch.clear();
                scratch.resize(window.width.div_ceil(8), 0);
                let row_bytes = &bytemuck::cast_slice(scratch)[..window.width];
                (0..window.height).try_for_each(|row| run(row, 0, row_bytes))
            }
            Source::Windows(windows) => {
                let row_bytes = window.width * windows.sample_type().bytes();
                let bytes = room(scratch, row_bytes * window.height);
                windows.read(window, bytes)?;
                bytes.chunks_exact(row_bytes).enumerate().try_for_each(|(row, bytes)| run(row, 0, bytes))
            }
            Source::Masks(windows) => {
                let bytes = room(scratch, window.len());
                windows.read_mask(window, bytes)?;
                bytes.chunks_exact(window.width).enumerate().try_for_each(|(row, bytes)| run(row, 0, bytes))
            }
        }
    }
}

/// So many bytes, aligned for every type of sample.
fn room(words: &mut Vec<u64>, bytes: usize) -> &mut [u8] {
    words.resize(bytes.div_ceil(8), 0);
    &mut bytemuck::cast_slice_mut(words)[..bytes]
}
