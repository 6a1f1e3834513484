//! Reading heights that are stored as colours.

use super::gdal_error;
use super::{Raster, RasterError};
use crate::base::{Encoding, SampleType, Scaling, Window, bands_of_colours};

/// An encoding, and the bands that have red, green and blue, from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Encoded {
    pub(super) encoding: Encoding,
    pub(super) bands: [usize; 3],
}

impl Raster {
    /// The same raster, whose heights are those that its colours stand for. Red, green and blue are the first bands that
    /// are said to have them, or bands 1 to 3. What marks samples is an alpha band or a mask of the file; no nodata tag,
    /// scale or offset applies.
    ///
    /// # Errors
    /// [`RasterError::NotEncoded`] if there are no three bands of bytes.
    pub(super) fn with_encoding(mut self, encoding: Encoding) -> Result<Raster, RasterError> {
        let bands = bands_of_colours(self.band_count(), |number| self.colour_of(number));
        let is_byte = |n: usize| {
            let band = self.dataset.rasterband(n).ok();
            band.and_then(|b| super::open::sample_type(&b)) == Some(SampleType::U8)
        };
        if self.band_count() < 3 || !bands.iter().all(|n| is_byte(*n)) {
            let (path, encoding) = (self.path().to_path_buf(), encoding.name());
            let found = match (self.band_count(), self.sample_type().name()) {
                (1, name) => format!("one band of {name}"),
                (count, name) => format!("{count} bands, band 1 of {name}"),
            };
            return Err(RasterError::NotEncoded { path, encoding, found });
        }
        self.encoded = Some(Encoded { encoding, bands });
        self.band = bands[0];
        self.sample_type = SampleType::F64;
        self.scaling = Scaling::NONE;
        self.tag = None;
        self.marks.values.clear();
        Ok(self)
    }

    /// The encoding of its heights, if they are stored as colours.
    pub fn encoding(&self) -> Option<Encoding> {
        self.encoded.map(|e| e.encoding)
    }

    pub(super) fn read_encoded(&self, encoded: Encoded, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        let mut colours = [const { Vec::new() }; 3];
        for (values, number) in colours.iter_mut().zip(encoded.bands) {
            let band = self.dataset.rasterband(number).map_err(|e| gdal_error::failed(self.path(), "band", &e))?;
            values.resize(window.len(), 0u8);
            self.read_from(&band, window, values)?;
        }
        let [red, green, blue] = &colours;
        for (height, ((r, g), b)) in out.iter_mut().zip(red.iter().zip(green).zip(blue)) {
            *height = encoded.encoding.height([*r, *g, *b]);
        }
        Ok(())
    }
}
