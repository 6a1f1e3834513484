//! Marks of a raster's missing samples, in place of its nodata tag.

use super::{Raster, RasterError};
use crate::base::warning::Warning;
use crate::base::{Mark, Marks, TAG, ValidRange, zero_tag};

impl Raster {
    /// The same raster with these marks in place of its tag: numbers, `inf`, `-inf`, `nan`, `tag` for the tag itself, if
    /// there is one, and `none` for nothing. Without any word the tag stays.
    ///
    /// # Errors
    /// [`RasterError::NodataValue`] for what is no number, or where the samples cannot have the value.
    pub fn with_nodata(mut self, words: &[String]) -> Result<Raster, RasterError> {
        if words.is_empty() {
            return Ok(self);
        }
        let marks = Marks::of_words(words, self.tag, self.sample_type()).map_err(|found| {
            let (path, sample_type) = (self.path().to_path_buf(), self.sample_type().name());
            RasterError::NodataValue { path, found: found.to_string(), sample_type }
        })?;
        self.tag_counts = words.iter().any(|word| word == TAG);
        self.marks.values = marks.values;
        self.nodata_words = words.to_vec();
        self.marks_are_said = true;
        Ok(self)
    }

    /// The same raster, in which only heights within this range are valid, beside what other marks say.
    pub fn with_valid_range(mut self, valid: ValidRange) -> Raster {
        self.marks.valid = Some(valid);
        self.marks_are_said = true;
        self
    }

    /// A tag that marks nothing, as a warning.
    pub(super) fn unreachable_tag(&self) -> Option<Warning> {
        self.tag.filter(|_| self.tag_counts)?.unreachable(self.sample_type(), self.path())
    }

    /// What marks samples as missing.
    pub fn marks(&self) -> &Marks {
        &self.marks
    }

    /// The raster's own nodata tag.
    pub fn tag(&self) -> Option<Mark> {
        self.tag
    }
}

impl Raster {
    /// Where a nodata tag of 0 comes from that counts without the caller having named that value, see [`zero_tag`].
    pub(super) fn zero_tag(&self) -> Option<&'static str> {
        zero_tag(&self.driver(), self.tag().filter(|_| self.tag_counts))
    }
}
