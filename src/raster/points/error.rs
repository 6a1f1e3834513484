//! Why points cannot be used.

use std::path::PathBuf;

use crate::base::control::Cancelled;

/// Why points cannot be used. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PointsError {
    /// The file does not exist, is not readable, or no OGR driver takes it.
    #[error("{}: cannot be opened as a layer of points: {reason}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// What GDAL said.
        reason: String,
    },
    /// Points are placed on a raster that GDAL has opened, and the samples come from elsewhere.
    #[error("{}: expected a raster to place the points on, found samples of a program", path.display())]
    NoRaster {
        /// The file of the points.
        path: PathBuf,
    },
    /// The layer asked for is not there, or there is none at all.
    #[error("{}: expected {}, found {}", path.display(), expected(wanted.as_deref()), listed(there))]
    NoSuchLayer {
        /// The file.
        path: PathBuf,
        /// The layer asked for; `None` for any.
        wanted: Option<String>,
        /// Those that are there.
        there: Vec<String>,
    },
    /// A feature is no point.
    #[error("{}: layer {layer}, feature {feature}: expected {expected}, found {found}", path.display())]
    Feature {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
        /// The feature's id.
        feature: u64,
        /// What it should have.
        expected: &'static str,
        /// What it has.
        found: String,
    },
    /// Reading ended before the layer did.
    #[error("{}: layer {layer}: expected {expected} features, found {found}: the file is damaged", path.display())]
    Incomplete {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
        /// How many features the layer says it has.
        expected: u64,
        /// How many could be read.
        found: u64,
    },
    /// There is no way from the layer's CRS to the raster's.
    #[error("{}: layer {layer}: cannot be transformed from its CRS, {from}, to the raster's, {to}: {reason}", path.display())]
    Crs {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
        /// The layer's CRS.
        from: String,
        /// The raster's CRS.
        to: String,
        /// What GDAL said.
        reason: String,
    },
    /// The layer has no points.
    #[error("{}: layer {layer}: expected points, found none", path.display())]
    NoPoints {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
    },
    /// No point lies on the raster.
    #[error("{}: layer {layer}: expected points on the raster, found all {count} outside: {first}", path.display())]
    AllOutside {
        /// The file.
        path: PathBuf,
        /// The layer.
        layer: String,
        /// How many points there are.
        count: u64,
        /// Where the first one lies.
        first: String,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

fn expected(wanted: Option<&str>) -> String {
    wanted.map_or("a vector layer".to_string(), |name| format!("layer {name}"))
}

fn listed(there: &[String]) -> String {
    if there.is_empty() { "none".to_string() } else { there.join(", ") }
}
