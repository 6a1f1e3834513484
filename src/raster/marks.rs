//! Marks of a raster's missing samples, in place of its nodata tag.

use super::{Raster, RasterError};
use crate::base::warning::{Warning, WarningCode};
use crate::base::{Mark, Marks, NO_MARK, TAG, ValidRange};

impl Raster {
    /// The same raster with these marks in place of its tag: numbers, `inf`, `-inf`, `nan`, `tag` for the tag itself, if
    /// there is one, and `none` for nothing. Without any word the tag stays.
    ///
    /// # Errors
    /// [`RasterError::NodataValue`] for what is no number, or where the samples cannot have the value.
    pub fn with_nodata<S: AsRef<str>>(mut self, texts: &[S]) -> Result<Raster, RasterError> {
        if texts.is_empty() {
            return Ok(self);
        }
        let mut values = Vec::new();
        for text in texts.iter().map(AsRef::as_ref) {
            if text == TAG {
                values.extend(self.tag);
                continue;
            }
            if text == NO_MARK {
                continue;
            }
            let Some(mark) = Mark::parse(text, self.sample_type()) else {
                let (path, found, sample_type) =
                    (self.path().to_path_buf(), text.to_string(), self.sample_type().name());
                return Err(RasterError::NodataValue { path, found, sample_type });
            };
            values.push(mark);
        }
        values.dedup();
        self.tag_counts = texts.iter().any(|text| text.as_ref() == TAG);
        self.marks.values = values;
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
        let tag = self.tag.filter(|_| self.tag_counts)?;
        let message = || {
            let name = self.sample_type().name();
            format!("the nodata tag {tag} marks nothing: samples of type {name} cannot have that value")
        };
        let (code, file) = (WarningCode::UnreachableNodata, self.path().to_path_buf());
        (!tag.is_reachable(self.sample_type())).then(|| Warning { code, file, count: 1, message: message() })
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
    /// Whether the raster's nodata tag is 0 and counts, without the caller having named that value: formats and writers make it up, and then the sea goes missing.
    pub fn has_zero_tag(&self) -> bool {
        // Of a table, GDAL marks samples without a line by 0 where no line has that height.
        self.driver() != "XYZ" && self.tag_counts && self.tag().is_some_and(is_zero)
    }
}

fn is_zero(mark: Mark) -> bool {
    match mark {
        Mark::Real(value) => value == 0.0,
        Mark::I64(value) => value == 0,
        Mark::U64(value) => value == 0,
    }
}
