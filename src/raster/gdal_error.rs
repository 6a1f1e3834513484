//! What GDAL says when it fails, as the end of a sentence. Some failures have no words at all, only a class or a code.

use std::path::Path;

use gdal::errors::GdalError;

use super::RasterError;
// A pixel function without enough sources says nothing, nor does a driver's worker thread, whose message is lost with it.
use crate::base::SILENT;

/// What GDAL refuses to tell about a file.
pub(super) fn failed(path: &Path, what: &'static str, error: &GdalError) -> RasterError {
    RasterError::Gdal { path: path.to_path_buf(), what, reason: reason(error) }
}

/// GDAL's own words, without the wrapper's decoration; where it has none, a sentence on what failed. Never empty.
pub(crate) fn reason(error: &GdalError) -> String {
    match error {
        GdalError::CplError { msg, .. } | GdalError::NullPointer { msg, .. } if !msg.trim().is_empty() => {
            msg.trim().to_string()
        }
        // 0 is "no error", which helps nobody.
        GdalError::CplError { number: 0, .. } => SILENT.to_string(),
        GdalError::CplError { number, .. } => format!("{SILENT} (error {number})"),
        GdalError::NullPointer { method_name, .. } => format!("{SILENT} ({method_name})"),
        GdalError::OgrError { method_name, .. } if is_of_a_crs(method_name) => {
            format!("GDAL does not understand the definition of the CRS ({method_name})")
        }
        GdalError::OgrError { err, method_name } => format!("{} ({method_name})", of_code(*err)),
        GdalError::InvalidCoordinateRange { msg, .. } => match msg.as_deref().map(str::trim) {
            Some(msg) if !msg.is_empty() => msg.to_string(),
            _ => "coordinates have no place in the other CRS".to_string(),
        },
        GdalError::BadArgument(what) if !what.trim().is_empty() => format!("an argument cannot be used: {what}"),
        GdalError::BadArgument(_) => "an argument cannot be used".to_string(),
        GdalError::FfiNulError(_) => "a name or value contains a zero byte".to_string(),
        GdalError::FfiIntoStringError(_) | GdalError::StrUtf8Error(_) => "a text in the file is not UTF-8".to_string(),
        GdalError::CastToF64Error => "a value is not a number".to_string(),
        other => other.to_string(),
    }
}

/// Whether a function reads the definition of a coordinate reference system.
fn is_of_a_crs(method: &str) -> bool {
    ["OSRSetFrom", "OSRImportFrom", "OSRAutoIdentify"].iter().any(|prefix| method.starts_with(prefix))
}

/// GDAL's constants `OGRERR_…`, which the bindings show as numbers.
fn of_code(code: u32) -> &'static str {
    match code {
        1 => "there are not enough data",
        2 => "there is not enough memory",
        3 => "the type of the geometry is not supported",
        4 => "the format does not support the operation",
        5 => "the data are damaged",
        7 => "the CRS is not supported",
        8 => "a handle is not valid",
        9 => "there is no such feature",
        _ => SILENT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_failure_without_words_is_a_sentence() {
        let nul = std::ffi::CString::new("a\0b").expect_err("a zero byte");
        let text = std::ffi::CString::new([0xff]).expect("no zero byte").into_string().expect_err("no UTF-8");
        let utf_8 = String::from_utf8(vec![0xff]).expect_err("no UTF-8").utf8_error();
        let range = |msg: Option<&str>| GdalError::InvalidCoordinateRange {
            from: "EPSG:4326".to_string(),
            to: "EPSG:32633".to_string(),
            msg: msg.map(str::to_string),
        };
        let cpl = |number, msg: &str| GdalError::CplError { class: 3, number, msg: msg.to_string() };
        let null = |msg: &str| GdalError::NullPointer { method_name: "GDALOpenEx", msg: msg.to_string() };
        let ogr = |err, method_name| GdalError::OgrError { err, method_name };
        for (error, expected) in [
            (cpl(0, ""), "GDAL gave no reason"),
            (cpl(0, " \n"), "GDAL gave no reason"),
            (cpl(3, ""), "GDAL gave no reason (error 3)"),
            (cpl(1, "no such tile\n"), "no such tile"),
            (null(""), "GDAL gave no reason (GDALOpenEx)"),
            (null("not recognized"), "not recognized"),
            (ogr(5, "OSRSetFromUserInput"), "GDAL does not understand the definition of the CRS (OSRSetFromUserInput)"),
            (ogr(5, "OGR_L_GetExtent"), "the data are damaged (OGR_L_GetExtent)"),
            (ogr(6, "OGR_L_GetExtent"), "GDAL gave no reason (OGR_L_GetExtent)"),
            (range(None), "coordinates have no place in the other CRS"),
            (range(Some("")), "coordinates have no place in the other CRS"),
            (range(Some("Point outside")), "Point outside"),
            (GdalError::BadArgument(String::new()), "an argument cannot be used"),
            (GdalError::BadArgument("size".to_string()), "an argument cannot be used: size"),
            (GdalError::FfiNulError(nul), "a name or value contains a zero byte"),
            (GdalError::FfiIntoStringError(text), "a text in the file is not UTF-8"),
            (GdalError::StrUtf8Error(utf_8), "a text in the file is not UTF-8"),
            (GdalError::CastToF64Error, "a value is not a number"),
        ] {
            assert_eq!(reason(&error), expected, "{error:?}");
        }
        for code in 0..=20 {
            let said = reason(&ogr(code, "OGR_L_GetExtent"));
            assert!(said.contains(' ') && !said.contains("error:"), "{said}");
        }
    }
}
