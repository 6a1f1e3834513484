//! Layers of lines and polygons: opened, and brought to columns and rows.

mod error;
mod read;

pub use error::ShapesError;
pub(super) use read::{Placer, Wrong, for_each_geometry};
