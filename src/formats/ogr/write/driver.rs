//! GDAL's formats: which of them give back what they are given.

use std::path::Path;

use super::flat;
use crate::formats::SinkError;

/// A format of GDAL that a mesh can be written in.
#[derive(Debug)]
pub(super) struct Driver {
    /// GDAL's short name.
    pub(super) name: &'static str,
    /// What its files end in; some drivers make folders under other names.
    pub(super) extension: &'static str,
    /// Whether it keeps metadata of a layer: the header, and with it how coordinates stand.
    pub(super) keeps_header: bool,
    /// Whether a file has more than one layer.
    pub(super) has_layers: bool,
    /// Whether it says that coordinates are degrees where it is given no CRS.
    pub(super) needs_crs: bool,
    /// Whether a file with so many features has its end, where that is not known by opening it.
    pub(super) has_end: fn(&Path, u64) -> std::io::Result<bool>,
    /// Whether it writes the features of a transaction together.
    pub(super) has_transactions: bool,
    pub(super) layer_options: &'static [&'static str],
    /// GDAL's settings while it writes.
    pub(super) settings: &'static [(&'static str, &'static str)],
}

/// The first is the usual one.
const DRIVERS: &[Driver] = &[
    Driver {
        name: "GPKG",
        extension: "gpkg",
        keeps_header: true,
        has_layers: true,
        needs_crs: true,
        has_end: |_, _| Ok(true),
        has_transactions: true,
        // It would take nine times as long as the rest, with GDAL 3.6.
        layer_options: &["SPATIAL_INDEX=NO"],
        settings: &[
            // The times of changes, which the format wants.
            ("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z"),
            // What is not complete is removed, so nothing is to be rolled back, and no file lies beside this one.
            ("OGR_SQLITE_PRAGMA", "journal_mode=OFF,synchronous=OFF"),
        ],
    },
    Driver {
        name: "FlatGeobuf",
        extension: "fgb",
        keeps_header: false,
        has_layers: false,
        needs_crs: false,
        has_end: flat::is_whole,
        has_transactions: false,
        // The index would hold all features in memory.
        layer_options: &["SPATIAL_INDEX=NO"],
        settings: &[],
    },
];

/// Formats that people may ask for, and why they get another.
const OTHERS: &[(&str, &str)] = &[
    ("ESRI Shapefile", "which is several files"),
    ("CSV", "which does not show it when its end is missing"),
    ("PGDump", "which cannot be read again, and so not verified"),
    ("OpenFileGDB", "which is a folder, and rounds coordinates"),
    ("GeoJSON", "which rounds coordinates, and has no geometry for a TIN"),
    ("GeoJSONSeq", "which rounds coordinates, and has no geometry for a TIN"),
    ("KML", "which has coordinates in degrees of WGS 84 alone"),
    ("LIBKML", "which has coordinates in degrees of WGS 84 alone"),
    ("MapInfo File", "which loses heights"),
    ("DXF", "which has one height for all corners of a polygon"),
];

/// GDAL's short name of a format, in upper or lower case, of those that a mesh can be written in or that are refused for a
/// reason; `None` for others.
pub fn named(name: &str) -> Option<&'static str> {
    let others = OTHERS.iter().map(|(name, _)| *name);
    DRIVERS.iter().map(|driver| driver.name).chain(others).find(|known| known.eq_ignore_ascii_case(name))
}

impl Driver {
    /// The driver of this name, in upper or lower case; without one, that of the extension, else the usual one.
    ///
    /// # Errors
    /// [`SinkError::Unfit`] for one that would lose something of the triangles.
    pub(super) fn choose(path: &Path, name: Option<&str>) -> Result<&'static Driver, SinkError> {
        let Some(name) = name else {
            let extension = path.extension().unwrap_or_default();
            let named = DRIVERS.iter().find(|driver| extension.eq_ignore_ascii_case(driver.extension));
            return Ok(named.unwrap_or(&DRIVERS[0]));
        };
        DRIVERS.iter().find(|driver| driver.name.eq_ignore_ascii_case(name)).ok_or_else(|| {
            let known = OTHERS.iter().find(|(other, _)| other.eq_ignore_ascii_case(name));
            let names: Vec<&str> = DRIVERS.iter().map(|driver| driver.name).collect();
            SinkError::Unfit {
                path: path.to_path_buf(),
                expected: format!("a format of GDAL that gives back triangles as they are ({})", names.join(", ")),
                found: known.map_or(format!("{name}, which is not known to"), |(name, why)| format!("{name}, {why}")),
            }
        })
    }
}

/// Settings of GDAL for this thread; dropped, they are what they were.
pub(super) struct Settings(Vec<(&'static str, String)>);

impl Settings {
    pub(super) fn of(driver: &Driver) -> Settings {
        let set = |&(key, value): &(&'static str, &str)| {
            let before = gdal::config::get_thread_local_config_option(key, "").unwrap_or_default();
            gdal::config::set_thread_local_config_option(key, value).expect("no zero byte");
            (key, before)
        };
        Settings(driver.settings.iter().map(set).collect())
    }
}

impl Drop for Settings {
    fn drop(&mut self) {
        for (key, before) in &self.0 {
            let _ = match before.as_str() {
                "" => gdal::config::clear_thread_local_config_option(key),
                before => gdal::config::set_thread_local_config_option(key, before),
            };
        }
    }
}
