//! The way to a raster's samples from any thread.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::ThreadId;

use super::plain::plain_layout;
use super::remote::is_remote;
use super::{Opening, Raster, RasterError};
use crate::base::{Band, PlainLayout, SampleType, Window, Windows};

/// Samples read through GDAL window by window, when they are wanted: nothing is decoded beforehand.
///
/// A GDAL dataset serves one thread at a time and keeps its own blocks in GDAL's cache, so every thread has a handle of its
/// own: tiles are worked on in runs, and the blocks that a tile shares with the one before it are mostly still there. The
/// lock is held for a moment only, never while something is read.
struct Handles {
    opening: Opening,
    shape: (usize, usize, SampleType),
    handles: Mutex<HashMap<ThreadId, Raster>>,
}

impl Handles {
    /// What a panic leaves here are handles.
    fn lock(&self) -> MutexGuard<'_, HashMap<ThreadId, Raster>> {
        self.handles.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A handle more. By now there may be another raster under the name.
    fn reopened(&self) -> Result<Raster, RasterError> {
        let raster = self.opening.open()?;
        let said = |(width, height, sample_type): (usize, usize, SampleType)| {
            format!("{width} × {height} of type {}", sample_type.name())
        };
        let (expected, found) = (said(self.shape), said(shape(&raster)));
        if expected == found {
            return Ok(raster);
        }
        let (path, what) = (raster.path().to_path_buf(), "samples".to_string());
        Err(RasterError::Changed { path, what, expected, found })
    }

    fn with_handle<T>(&self, read: impl FnOnce(&Raster) -> Result<T, RasterError>) -> Result<T, RasterError> {
        let thread = std::thread::current().id();
        let own = self.lock().remove(&thread);
        let raster = match own {
            Some(raster) => raster,
            None => self.reopened()?,
        };
        let found = read(&raster)?;
        self.lock().insert(thread, raster);
        Ok(found)
    }
}

impl Windows for Handles {
    fn read(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.with_handle(|raster| raster.read_native(window, out))
    }

    fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.with_handle(|raster| raster.read_mask(window, out))
    }

    fn plain_layout(&self) -> Result<PlainLayout, String> {
        self.with_handle(|raster| Ok(plain_layout(raster))).map_err(|e| e.to_string())?
    }

    fn release(&self) {
        self.lock().clear();
    }
}

/// What windows depend on.
fn shape(raster: &Raster) -> (usize, usize, SampleType) {
    (raster.width(), raster.height(), raster.sample_type())
}

impl Raster {
    /// The raster as engines and `verify` take it: readable from any thread. Each thread that reads opens it once more.
    ///
    /// # Errors
    /// [`RasterError::Gdal`] when GDAL cannot tell whether there is a mask.
    pub fn to_band(&self) -> Result<Band, RasterError> {
        let handles = Handles { opening: self.opening(), shape: shape(self), handles: Mutex::default() };
        let mut view = Vec::new();
        view.extend(self.encoding().map(|encoding| ("encoding", encoding.name().to_string())));
        let options = self.open_options();
        view.extend((!options.is_empty()).then(|| ("open options", options.join(" "))));
        // A window that happens to have the samples of another is not the same place.
        view.extend(self.window().map(|w| ("window", w.to_string())));
        Ok(Band {
            path: self.path().to_path_buf(),
            size: (self.width(), self.height()),
            number: self.band(),
            bands: self.band_count(),
            block: self.block_size(),
            sample_type: self.sample_type(),
            scaling: self.scaling(),
            marks: self.marks().clone(),
            marks_are_said: self.marks_are_said,
            nodata_words: self.nodata_words.clone(),
            tag: self.tag(),
            zero_tag: self.zero_tag(),
            has_mask: self.has_mask()?,
            cutline: self.cutline().cloned(),
            geo_transform: self.own_geo_transform(),
            first: self.window().map_or((0, 0), |w| (w.column, w.row)),
            reference: self.reference(),
            crs: self.crs_definition(),
            description: self.description(),
            title: self.band_description(),
            encoding: self.encoding(),
            window: self.window(),
            esri_wkt: self.crs_esri_wkt(),
            warnings: self.warnings().to_vec(),
            colour: self.colour(),
            is_remote: is_remote(self.path()),
            view,
            windows: Arc::new(handles),
        })
    }

    /// Opens these bands of the same file, from 1, in the same window, see [`Opening::open_band`], with these marks of missing
    /// values ([`Raster::with_nodata`]).
    ///
    /// # Errors
    /// [`RasterError`], for a band that is not there among others.
    pub fn other_bands(&self, numbers: &[usize], nodata: &[String]) -> Result<Vec<Band>, RasterError> {
        numbers.iter().map(|&number| self.opening().open_band(number)?.with_nodata(nodata)?.to_band()).collect()
    }
}
