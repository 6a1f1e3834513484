use super::{Raster, RasterError, SampleType, with_sample_type};

/// The value that marks samples without a height, in the type it is stored in.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(untagged)]
pub enum Nodata {
    /// The raster has no such value.
    None,
    /// Compared with the stored value as a double; NaN marks NaN.
    Real(f64),
    /// For 64-bit signed samples.
    I64(i64),
    /// For 64-bit unsigned samples.
    U64(u64),
}

impl Nodata {
    /// The value a text stands for, if samples of this type can hold it. To a float type it is rounded, as by GDAL; what
    /// GDAL would clamp or cut off is none.
    pub fn parse(text: &str, sample_type: SampleType) -> Option<Nodata> {
        match sample_type {
            SampleType::I64 => text.parse().ok().map(Nodata::I64),
            SampleType::U64 => text.parse().ok().map(Nodata::U64),
            SampleType::F64 => text.parse().ok().map(Nodata::Real),
            SampleType::F32 => {
                let value: f64 = text.parse().ok()?;
                let fits = !value.is_finite() || (value as f32).is_finite();
                fits.then_some(Nodata::Real(value))
            }
            integer => {
                let value: f64 = text.parse().ok()?;
                #[allow(clippy::unnecessary_cast)]
                let holds = with_sample_type!(integer, T => (value as T) as f64 == value);
                holds.then_some(Nodata::Real(value))
            }
        }
    }
}

impl Raster {
    /// The same raster with another nodata value than its tag says.
    ///
    /// # Errors
    /// [`RasterError::NodataValue`] where the samples cannot hold the value.
    pub fn with_nodata(mut self, text: &str) -> Result<Raster, RasterError> {
        let Some(nodata) = Nodata::parse(text, self.sample_type()) else {
            let (path, found, sample_type) = (self.path().to_path_buf(), text.to_string(), self.sample_type().name());
            return Err(RasterError::NodataValue { path, found, sample_type });
        };
        self.given_nodata = Some(nodata);
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_a_type_holds() {
        let parse = |text: &str, sample_type| Nodata::parse(text, sample_type);
        assert_eq!(parse("255", SampleType::U8), Some(Nodata::Real(255.0)));
        assert_eq!(parse("-9999", SampleType::U8), None);
        assert_eq!(parse("0.5", SampleType::I16), None);
        assert_eq!(parse("nan", SampleType::I32), None);
        assert_eq!(parse("-9223372036854775808", SampleType::I64), Some(Nodata::I64(i64::MIN)));
        assert_eq!(parse("-1", SampleType::U64), None);
        assert_eq!(parse("0.1", SampleType::F32), Some(Nodata::Real(0.1)));
        assert_eq!(parse("1e300", SampleType::F32), None);
        assert!(matches!(parse("nan", SampleType::F32), Some(Nodata::Real(v)) if v.is_nan()));
        assert_eq!(parse("high", SampleType::F64), None);
    }
}
