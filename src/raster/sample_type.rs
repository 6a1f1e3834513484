use gdal::raster::GdalDataType;

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
            $crate::raster::SampleType::U8 => {
                type $t = u8;
                $body
            }
            $crate::raster::SampleType::I8 => {
                type $t = i8;
                $body
            }
            $crate::raster::SampleType::U16 => {
                type $t = u16;
                $body
            }
            $crate::raster::SampleType::I16 => {
                type $t = i16;
                $body
            }
            $crate::raster::SampleType::U32 => {
                type $t = u32;
                $body
            }
            $crate::raster::SampleType::I32 => {
                type $t = i32;
                $body
            }
            $crate::raster::SampleType::U64 => {
                type $t = u64;
                $body
            }
            $crate::raster::SampleType::I64 => {
                type $t = i64;
                $body
            }
            $crate::raster::SampleType::F16 => {
                type $t = half::f16;
                $body
            }
            $crate::raster::SampleType::F32 => {
                type $t = f32;
                $body
            }
            $crate::raster::SampleType::F64 => {
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

    /// `signed_byte` tells the bytes of GDAL before 3.7 that are marked `PIXELTYPE=SIGNEDBYTE`.
    pub(super) fn from_gdal(gdal_type: GdalDataType, signed_byte: bool) -> Option<SampleType> {
        Some(match gdal_type {
            GdalDataType::UInt8 if signed_byte => SampleType::I8,
            GdalDataType::UInt8 => SampleType::U8,
            GdalDataType::UInt16 => SampleType::U16,
            GdalDataType::Int16 => SampleType::I16,
            GdalDataType::UInt32 => SampleType::U32,
            GdalDataType::Int32 => SampleType::I32,
            GdalDataType::UInt64 => SampleType::U64,
            GdalDataType::Int64 => SampleType::I64,
            GdalDataType::Float32 => SampleType::F32,
            GdalDataType::Float64 => SampleType::F64,
            // From GDAL 3.11 on.
            other if other.name() == "Float16" => SampleType::F16,
            // Int8 exists from GDAL 3.7 on; its name is the same with every version of the bindings.
            other if other.name() == "Int8" => SampleType::I8,
            _ => return None,
        })
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

    /// Whether heights are the stored values.
    pub fn is_none(self) -> bool {
        self == Scaling::NONE
    }
}
