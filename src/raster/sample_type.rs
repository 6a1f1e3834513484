//! GDAL's types of samples as ours.

use gdal::raster::GdalDataType;

use crate::base::SampleType;

/// `signed_byte` tells the bytes of GDAL before 3.7 that are marked `PIXELTYPE=SIGNEDBYTE`.
pub(super) fn of_gdal(gdal_type: GdalDataType, signed_byte: bool) -> Option<SampleType> {
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
