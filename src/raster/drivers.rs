//! What is known of formats as versions of GDAL read them: words by the name of the driver and the version.

use super::{Raster, xyz};
use crate::base::warning::{Warning, WarningCode};

/// The version of this GDAL, as 3060200 for 3.6.2.
pub(super) fn version() -> u32 {
    gdal::version::version_info("VERSION_NUM").parse().unwrap_or_default()
}

fn version_in_words(version: u32) -> String {
    format!("{}.{}.{}", version / 1_000_000, version / 10_000 % 100, version / 100 % 100)
}

/// What a user should know of heights that a driver reads.
pub(super) fn caveat(driver: &str, version: u32, open_options: &[String]) -> Option<(WarningCode, String)> {
    let as_heights = |option: &String| option.to_ascii_uppercase().starts_with("DEPTH_OR_ELEVATION=ELEVATION");
    match driver {
        // It takes the least positive number for the least one.
        "HF2" if version < 3_070_000 => {
            let version = version_in_words(version);
            let message = format!("GDAL {version} reads heights of 0 and below as 1.2e-38 from HF2 files");
            Some((WarningCode::Misread, message))
        }
        "S102" if !open_options.iter().any(as_heights) => Some((
            WarningCode::Depths,
            "the values are depths, positive downwards, so the terrain is upside down".to_string(),
        )),
        _ => None,
    }
}

/// Formats that not every GDAL reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unread {
    S102,
    Zarr3,
}

impl Unread {
    /// What a file is that GDAL has opened with `driver`, whose metadata say that it is of `product`.
    pub(super) fn of_product(driver: &str, product: &str) -> Option<Unread> {
        (driver.starts_with("HDF5") && product.contains("S-102")).then_some(Unread::S102)
    }

    /// Why it is not read by this version.
    pub(super) fn reason(self, version: u32) -> String {
        let version = version_in_words(version);
        match self {
            Unread::S102 => format!(
                "it holds S-102 bathymetry, which GDAL {version} does not read; GDAL 3.8 and newer do, as depths, positive \
                 downwards, or with the open option DEPTH_OR_ELEVATION=ELEVATION as heights"
            ),
            Unread::Zarr3 => format!(
                "it is Zarr 3, which GDAL {version} does not read; newer versions may, and zarr-python writes Zarr 2 with \
                 zarr_format=2"
            ),
        }
    }
}

impl Raster {
    /// What a user should know of the samples of a raster of this format, as this GDAL reads it.
    pub(super) fn caveats(&self) -> Vec<Warning> {
        let driver = self.driver();
        let warning = |code, count, message| Warning { code, file: self.path().to_path_buf(), count, message };
        let caveat = caveat(&driver, version(), self.open_options()).map(|(code, message)| warning(code, 1, message));
        let gaps = (driver == "XYZ" && self.tag().is_none()).then(|| self.samples_without_line()).flatten();
        let gaps = gaps.map(|count| {
            let message = format!("{count} samples have no line in the table; nothing marks them, and they count as 0");
            warning(WarningCode::XyzGaps, count, message)
        });
        caveat.into_iter().chain(gaps).collect()
    }

    /// Of a table: how many samples have no line, if some have none and the file can be read without GDAL.
    fn samples_without_line(&self) -> Option<u64> {
        let (width, height) = self.whole_size();
        let lines = xyz::lines(self.path()).ok().flatten()?;
        (width as u64 * height as u64).checked_sub(lines).filter(|missing| *missing > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_by_driver_and_version() {
        let said = |driver: &str, version| caveat(driver, version, &[]);
        assert_eq!(said("GTiff", 3_060_200), None);
        let (code, message) = said("HF2", 3_060_200).expect("a caveat");
        assert!(code == WarningCode::Misread && message.starts_with("GDAL 3.6.2 reads heights of 0 and below"));
        assert_eq!(said("HF2", 3_100_000), None);
        let (code, message) = said("S102", 3_080_000).expect("a caveat");
        assert!(code == WarningCode::Depths && message.contains("positive downwards"));
        assert_eq!(caveat("S102", 3_080_000, &["depth_or_elevation=elevation".to_string()]), None);
        assert_eq!(Unread::of_product("HDF5", "INT.IHO.S-102.2.1"), Some(Unread::S102));
        assert_eq!(Unread::of_product("S102", "INT.IHO.S-102.2.1"), None);
        assert!(Unread::S102.reason(3_060_200).contains("GDAL 3.6.2 does not read; GDAL 3.8 and newer do, as depths"));
        assert!(Unread::Zarr3.reason(3_060_200).contains("Zarr 3, which GDAL 3.6.2 does not read"));
    }
}
