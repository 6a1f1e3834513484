//! Why a layer of lines or polygons cannot be used.

use std::path::PathBuf;

use crate::base::control::Cancelled;
use crate::base::external::ScratchError;

/// Why a layer of lines or polygons cannot be used. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ShapesError {
    /// The file does not exist, is not readable, or no OGR driver takes it.
    #[error("{}: cannot be opened as a layer of {shapes}: {reason}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// "polygons" or "lines".
        shapes: &'static str,
        /// What GDAL said.
        reason: String,
    },
    /// The layer asked for is not there, or there is none at all.
    #[error("{}: expected {expected}, found {found}", path.display())]
    NoSuchLayer {
        /// The file.
        path: PathBuf,
        /// The layer asked for.
        expected: String,
        /// Those that are there.
        found: String,
    },
    /// A feature is of another kind, or there is none at all.
    #[error("{}: layer {layer}: expected {expected}, found {found}", path.display())]
    Layer {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
        /// What it should have.
        expected: String,
        /// What it has.
        found: String,
    },
    /// There is no way from the layer's CRS to the raster's.
    #[error("{}: layer {layer}: cannot be transformed from its CRS, {from}, to the raster's, {to}: {reason}", path.display())]
    Crs {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
        /// The layer's CRS.
        from: String,
        /// The raster's CRS.
        to: String,
        /// What GDAL said.
        reason: String,
    },
    /// The raster is no file: nothing says where it lies.
    #[error("{}: expected a raster that GDAL has opened, to find where shapes lie on it", path.display())]
    NoRaster {
        /// The layer's file.
        path: PathBuf,
    },
    /// Shapes cannot be kept beside memory.
    #[error(transparent)]
    Scratch(ScratchError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<ScratchError> for ShapesError {
    fn from(error: ScratchError) -> ShapesError {
        match error {
            ScratchError::Cancelled(stopped) => ShapesError::Cancelled(stopped),
            file => ShapesError::Scratch(file),
        }
    }
}
