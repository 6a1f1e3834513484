//! The number types of samples, and scale and offset.

/// The number type of the samples as they are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
}

/// Runs `$body` with `$t` as the Rust type of a [`SampleType`].
macro_rules! with_sample_type {
    ($sample_type:expr, $t:ident => $body:expr) => {
        match $sample_type {
            $crate::base::SampleType::U8 => {
                type $t = u8;
                $body
            }
            $crate::base::SampleType::I8 => {
                type $t = i8;
                $body
            }
            $crate::base::SampleType::U16 => {
                type $t = u16;
                $body
            }
            $crate::base::SampleType::I16 => {
                type $t = i16;
                $body
            }
            $crate::base::SampleType::U32 => {
                type $t = u32;
                $body
            }
            $crate::base::SampleType::I32 => {
                type $t = i32;
                $body
            }
            $crate::base::SampleType::U64 => {
                type $t = u64;
                $body
            }
            $crate::base::SampleType::I64 => {
                type $t = i64;
                $body
            }
            $crate::base::SampleType::F16 => {
                type $t = half::f16;
                $body
            }
            $crate::base::SampleType::F32 => {
                type $t = f32;
                $body
            }
            $crate::base::SampleType::F64 => {
                type $t = f64;
                $body
            }
        }
    };
}
pub(crate) use with_sample_type;

impl SampleType {
    /// Bytes of one sample.
    pub fn bytes(self) -> usize {
        with_sample_type!(self, T => size_of::<T>())
    }

    /// GDAL's name for it, as a user knows it.
    pub fn name(self) -> &'static str {
        match self {
            SampleType::U8 => "Byte",
            SampleType::I8 => "Int8",
            SampleType::U16 => "UInt16",
            SampleType::I16 => "Int16",
            SampleType::U32 => "UInt32",
            SampleType::I32 => "Int32",
            SampleType::U64 => "UInt64",
            SampleType::I64 => "Int64",
            SampleType::F16 => "Float16",
            SampleType::F32 => "Float32",
            SampleType::F64 => "Float64",
        }
    }

    /// Whether every value is also a single-precision number.
    pub fn fits_f32(self) -> bool {
        use SampleType::{F16, F32, I8, I16, U8, U16};
        matches!(self, U8 | I8 | U16 | I16 | F16 | F32)
    }
}

/// Height = stored value × scale + offset: one multiplication and one addition in doubles, never fused.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Scaling {
    /// GDAL's scale tag, 1 where there is none.
    pub scale: f64,
    /// GDAL's offset tag, 0 where there is none.
    pub offset: f64,
}

impl Scaling {
    /// Heights are the stored values.
    pub const NONE: Scaling = Scaling { scale: 1.0, offset: 0.0 };

    /// The height of a stored value.
    pub fn height(self, stored: f64) -> f64 {
        stored * self.scale + self.offset
    }

    /// Whether heights can follow by it: finite numbers, and a scale other than 0.
    pub fn is_usable(self) -> bool {
        self.scale.is_finite() && self.scale != 0.0 && self.offset.is_finite()
    }

    /// Whether heights are the stored values.
    pub fn is_none(self) -> bool {
        self == Scaling::NONE
    }
}
