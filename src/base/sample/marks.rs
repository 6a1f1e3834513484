//! Which stored values and heights count as missing: the raster's nodata tag, and what the caller says.

use std::path::Path;

use super::{SampleType, with_sample_type};
use crate::base::decimal::is_too_large;
use crate::base::warning::{Warning, WarningCode};

/// A stored value that marks samples without a height.
///
/// - Integers of up to 32 bits: a mark within the type's range is truncated toward zero; another marks nothing.
/// - 64-bit integers: equality of integers.
/// - Float32: the mark is rounded to single precision first. A value v is missing if it equals the mark m or if
///   |v − m| < 2⁻²²·|v + m|, in single precision; a sum that overflows makes that true.
/// - Float64: the same in double precision, with 2⁻²², too. That is how GDAL compares them: tags are often rounded when
///   they are written.
/// - Half precision: as Float32.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Mark {
    /// For all types but 64-bit integers. NaN marks NaN, which is missing in any case.
    Real(f64),
    /// For 64-bit signed samples.
    I64(i64),
    /// For 64-bit unsigned samples.
    U64(u64),
}

/// 2⁻²²: how near a stored value of a float type is to a mark that it counts as, relative to their sum.
pub const NEARNESS: f64 = 1.0 / (1u64 << 22) as f64;

/// Heights beyond which samples count as missing; both ends are valid.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ValidRange {
    /// The least valid height.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl ValidRange {
    /// Whether a height is valid.
    pub fn contains(self, height: f64) -> bool {
        self.min <= height && height <= self.max
    }
}

/// What marks samples of a band as missing.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Marks {
    /// Stored values.
    pub values: Vec<Mark>,
    /// Heights, with scale and offset applied.
    pub valid: Option<ValidRange>,
}

/// The word that stands for the raster's own tag among marks.
pub const TAG: &str = "tag";

/// The word that stands for no mark at all.
pub const NO_MARK: &str = "none";

impl Mark {
    /// The value a text stands for, if samples of this type can be missing by it.
    pub fn parse(text: &str, sample_type: SampleType) -> Option<Mark> {
        match sample_type {
            SampleType::I64 => text.parse().ok().or_else(|| whole(text)?.try_into().ok()).map(Mark::I64),
            SampleType::U64 => text.parse().ok().or_else(|| whole(text)?.try_into().ok()).map(Mark::U64),
            // A number that no double can have is none; a word stands for infinity.
            _ if is_too_large(text) => None,
            _ => text.parse().ok().map(Mark::Real).filter(|mark| mark.is_reachable(sample_type)),
        }
    }

    /// Whether a sample of this type can have the value.
    pub fn is_reachable(self, sample_type: SampleType) -> bool {
        let Mark::Real(value) = self else { return true };
        match sample_type {
            SampleType::F64 => true,
            SampleType::F32 => !value.is_finite() || (value as f32).is_finite(),
            SampleType::F16 => !value.is_finite() || half::f16::from_f64(value).is_finite(),
            SampleType::I64 | SampleType::U64 => false,
            integer => with_sample_type!(integer, T => in_range::<T>(value)),
        }
    }
}

/// A whole number that is written as a real one, such as -9999.0.
fn whole(text: &str) -> Option<i128> {
    let value: f64 = text.parse().ok()?;
    (value.fract() == 0.0).then_some(value as i128)
}

/// The types whose ranges are asked for.
trait Limits {
    const LEAST: f64;
    const LARGEST: f64;
}
macro_rules! limits {
    ($($t:ty: $least:expr, $largest:expr);*) => {$(
        impl Limits for $t {
            const LEAST: f64 = $least;
            const LARGEST: f64 = $largest;
        }
    )*};
}
limits!(
    u8: 0.0, 255.0; i8: -128.0, 127.0; u16: 0.0, 65535.0; i16: -32768.0, 32767.0; u32: 0.0, 4294967295.0;
    i32: -2147483648.0, 2147483647.0; u64: 0.0, u64::MAX as f64; i64: i64::MIN as f64, i64::MAX as f64;
    f32: f64::NEG_INFINITY, f64::INFINITY; f64: f64::NEG_INFINITY, f64::INFINITY;
    half::f16: f64::NEG_INFINITY, f64::INFINITY
);

fn in_range<T: Limits>(value: f64) -> bool {
    T::LEAST <= value && value <= T::LARGEST
}

impl Mark {
    /// Whether it is 0. Formats and writers make up tags of 0, and then the sea goes missing.
    pub fn is_zero(self) -> bool {
        match self {
            Mark::Real(value) => value == 0.0,
            Mark::I64(value) => value == 0,
            Mark::U64(value) => value == 0,
        }
    }

    /// What is said of a raster's own tag that marks nothing; `None` for one that samples can have.
    pub fn unreachable(self, sample_type: SampleType, file: &Path) -> Option<Warning> {
        let message = || {
            let name = sample_type.name();
            format!("the nodata tag {self} marks nothing: samples of type {name} cannot have that value")
        };
        let (code, file) = (WarningCode::UnreachableNodata, file.to_path_buf());
        (!self.is_reachable(sample_type)).then(|| Warning { code, file, count: 1, message: message() })
    }
}

/// Where a nodata tag of 0 that counts comes from, as the end of a sentence, empty where nothing is known; `None` for another
/// tag. `driver` is GDAL's name of the format. (Of a table, GDAL marks samples without a line by 0 where no line has that
/// height.)
pub(crate) fn zero_tag(driver: &str, tag: Option<Mark>) -> Option<&'static str> {
    tag.filter(|tag| tag.is_zero() && driver != "XYZ").map(|_| match driver {
        "Zarr" => " (Zarr's fill_value, which zarr-python sets to 0 unless told otherwise)",
        _ => "",
    })
}

impl std::fmt::Display for Mark {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Mark::Real(value) => crate::base::decimal::Decimal(*value).fmt(f),
            Mark::I64(value) => value.fmt(f),
            Mark::U64(value) => value.fmt(f),
        }
    }
}

impl Marks {
    /// The marks that words stand for: numbers, `inf`, `-inf`, `nan`, `tag` for the raster's own tag, if there is one, and
    /// `none` for nothing. Without any word there is the tag alone.
    ///
    /// # Errors
    /// The word that is no number, or that stands for a value which samples of this type cannot have.
    pub fn of_words(words: &[String], tag: Option<Mark>, sample_type: SampleType) -> Result<Marks, &str> {
        if words.is_empty() {
            return Ok(Marks { values: tag.into_iter().collect(), valid: None });
        }
        let mut values = Vec::new();
        for word in words {
            match word.as_str() {
                TAG => values.extend(tag),
                NO_MARK => {}
                number => values.push(Mark::parse(number, sample_type).ok_or(number)?),
            }
        }
        values.dedup();
        Ok(Marks { values, valid: None })
    }

    /// Whether nothing but NaN is missing by them.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty() && self.valid.is_none()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_a_type_holds() {
        let parse = |text: &str, sample_type| Mark::parse(text, sample_type);
        assert_eq!(parse("255", SampleType::U8), Some(Mark::Real(255.0)));
        assert_eq!(parse("-9999", SampleType::U8), None);
        assert_eq!(parse("255.5", SampleType::U8), None);
        // Truncated toward zero, where it is compared.
        assert_eq!(parse("-9999.5", SampleType::I16), Some(Mark::Real(-9999.5)));
        assert_eq!(parse("nan", SampleType::I32), None);
        assert_eq!(parse("-inf", SampleType::F32), Some(Mark::Real(f64::NEG_INFINITY)));
        assert_eq!((parse("1e400", SampleType::F64), parse("-1e400", SampleType::F32)), (None, None));
        assert_eq!(parse("-9223372036854775808", SampleType::I64), Some(Mark::I64(i64::MIN)));
        assert_eq!(parse("-1", SampleType::U64), None);
        assert_eq!(parse("-9999.0", SampleType::I64), Some(Mark::I64(-9999)));
        assert_eq!((parse("0.5", SampleType::I64), parse("1e30", SampleType::U64)), (None, None));
        assert_eq!((parse("nan", SampleType::I64), parse("-inf", SampleType::I64)), (None, None));
        assert_eq!(parse("0.1", SampleType::F32), Some(Mark::Real(0.1)));
        assert_eq!(parse("-inf", SampleType::F32), Some(Mark::Real(f64::NEG_INFINITY)));
        assert_eq!(parse("1e300", SampleType::F32), None);
        assert!(matches!(parse("nan", SampleType::F32), Some(Mark::Real(v)) if v.is_nan()));
        assert_eq!(parse("high", SampleType::F64), None);
    }
}
