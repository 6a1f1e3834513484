//! Decoding a raster when it is wanted, a unit at a time, for whoever needs a part of it.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::FieldError;
use super::decode::{Decoding, unit_size};
use super::store::Store;
use crate::base::{Band, Window};

/// Samples of a band, or bytes of its mask, in a temporary file of the raster's size that is filled where windows are asked for.
///
/// Memory: some bytes for every unit, which has about [`super::UNIT_BYTES`] of samples, and a unit for each thread that reads one.
pub(super) struct Partial {
    band: Arc<Band>,
    decoding: Decoding,
    store: Store,
    /// Samples across and down in a unit.
    unit: (usize, usize),
    /// Whether a unit is in the file. Who finds one missing reads it, and others that want it wait.
    is_there: Vec<Mutex<bool>>,
}

impl Partial {
    /// Makes the file.
    ///
    /// # Errors
    /// [`FieldError::Temporary`].
    pub(super) fn new(band: Arc<Band>, is_mask: bool, folder: &Path) -> Result<Partial, FieldError> {
        let decoding = Decoding::new(&band, is_mask, folder)?;
        let (store, unit) = (decoding.mapped()?, unit_size(&band));
        let units = band.width().div_ceil(unit.0) * band.height().div_ceil(unit.1);
        let is_there = std::iter::repeat_with(Mutex::default).take(units).collect();
        Ok(Partial { band, decoding, store, unit, is_there })
    }

    /// The file, in which a window is there now.
    ///
    /// # Errors
    /// [`FieldError`]; what is not there is read when it is asked for again.
    pub(super) fn with(&self, window: Window) -> Result<&Store, FieldError> {
        let ((width, height), across) = (self.unit, self.band.width().div_ceil(self.unit.0));
        for row in window.row / height..(window.row + window.height).div_ceil(height) {
            for column in window.column / width..(window.column + window.width).div_ceil(width) {
                let unit = &self.is_there[row * across + column];
                // One whose reading has panicked is not there.
                let mut is_there = unit.lock().unwrap_or_else(PoisonError::into_inner);
                if !*is_there {
                    self.decoding.fill(&self.band, self.unit_at(column, row))?;
                    *is_there = true;
                }
            }
        }
        Ok(&self.store)
    }

    fn unit_at(&self, column: usize, row: usize) -> Window {
        let (column, row) = (column * self.unit.0, row * self.unit.1);
        let (width, height) = (self.band.width() - column, self.band.height() - row);
        Window { column, row, width: width.min(self.unit.0), height: height.min(self.unit.1) }
    }
}
