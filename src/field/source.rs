use std::path::Path;
use std::sync::Arc;

use super::FieldError;
use super::store::Store;
use super::windows::Windows;
use crate::base::Window;

/// Where the samples of a field come from.
pub(super) enum Source {
    /// Blocks in memory or mapped.
    Blocks(Store),
    /// The raster itself, through GDAL.
    Windows(Arc<Windows>),
    /// The raster's mask, through GDAL: a byte for every sample, 0 where it is invalid.
    Masks(Arc<Windows>),
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
            Source::Level => {
                scratch.clear();
                scratch.resize(window.width.div_ceil(8), 0);
                let row_bytes = &bytemuck::cast_slice(scratch)[..window.width];
                (0..window.height).try_for_each(|row| run(row, 0, row_bytes))
            }
            Source::Windows(windows) => {
                let bytes = windows.read(window, scratch)?;
                let row_bytes = bytes.len() / window.height;
                bytes.chunks_exact(row_bytes).enumerate().try_for_each(|(row, bytes)| run(row, 0, bytes))
            }
            Source::Masks(windows) => {
                let bytes = windows.read_mask(window, scratch)?;
                bytes.chunks_exact(window.width).enumerate().try_for_each(|(row, bytes)| run(row, 0, bytes))
            }
        }
    }
}
