//! Which GDAL this is.

use gdal::{DriverManager, Metadata};

/// The versions of GDAL and PROJ at work, and the raster formats that this GDAL reads, by their short names in alphabetical order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Libraries {
    /// GDAL's version.
    pub gdal: String,
    /// PROJ's version; empty where GDAL does not say it.
    pub proj: String,
    /// The drivers.
    pub drivers: Vec<String>,
}

impl Libraries {
    /// Those of this process.
    pub fn here() -> Libraries {
        let is_of_rasters = |driver: &gdal::Driver| driver.metadata_item("DCAP_RASTER", "").as_deref() == Some("YES");
        let drivers = (0..DriverManager::count()).filter_map(|i| DriverManager::get_driver(i).ok());
        let mut drivers: Vec<String> = drivers.filter(is_of_rasters).map(|driver| driver.short_name()).collect();
        drivers.sort();
        let built = gdal::version::VersionInfo::build_info();
        Libraries {
            gdal: gdal::version::version_info("RELEASE_NAME"),
            proj: built.get("PROJ_RUNTIME_VERSION").cloned().unwrap_or_default(),
            drivers,
        }
    }
}
