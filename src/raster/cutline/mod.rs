//! Cutlines: polygons of a vector layer, as the samples inside them.
//!
//! In come a layer of polygons of any format OGR reads and a raster; out goes a [`Cutline`], which tells of the samples of
//! any window whether they are inside a polygon. `read` takes polygons from features and brings them to columns and rows.

mod read;

pub use read::{CutlineSource, read_cutline};

use std::sync::Arc;

use super::Raster;
use crate::base::Cutline;

impl Raster {
    /// The same raster, in which samples outside of the cutline have no height. The cutline is one that was read for this
    /// raster, or for the same window of it.
    pub fn with_cutline(mut self, cutline: Cutline) -> Raster {
        self.cutline = Some(Arc::new(cutline));
        self
    }

    /// What is outside of it has no height.
    pub fn cutline(&self) -> Option<&Arc<Cutline>> {
        self.cutline.as_ref()
    }
}

#[cfg(test)]
mod tests;
