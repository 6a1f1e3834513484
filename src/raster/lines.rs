//! Lines of a vector layer, in columns and rows of a raster.

use std::path::PathBuf;

use gdal::vector::{Geometry, OGRwkbGeometryType, geometry_type_flatten};

use super::Raster;
use super::shapes::{Placer, ShapesError, for_each_geometry};
use crate::base::Polylines;
use crate::base::control::CancelToken;

/// Where lines come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineSource {
    /// A file, or any name OGR opens.
    pub path: PathBuf,
    /// The layer; the first where none is named.
    pub layer: Option<String>,
}

/// Reads a layer of lines (LineString or MultiLineString; z and m are ignored) and brings them to the samples of `raster`, or of the
/// window of it that is looked at. An empty line is one without vertices; features without geometry are counted.
///
/// Vertices are transformed to the raster's CRS where both have one, and lines that are bent there are given further ones, a tenth
/// of a cell exact; where one has none, coordinates are taken as they are.
///
/// Memory: 16 bytes per vertex, and what OGR's driver takes.
///
/// # Errors
/// [`ShapesError`]: nothing to open, no such layer, a feature that is no line, a CRS there is no way from.
pub fn read_lines(raster: &Raster, source: &LineSource, cancel: &CancelToken) -> Result<Polylines, ShapesError> {
    let from = (source.path.as_path(), source.layer.as_deref());
    let (found, without_geometry) = for_each_geometry(raster, from, ("lines", "a line or lines"), cancel, lines)?;
    Ok(Polylines::new(found).beside(without_geometry))
}

fn lines(placer: &Placer, geometry: &Geometry, found: &mut Vec<Vec<(f64, f64)>>) -> Result<(), String> {
    let flat = geometry_type_flatten(geometry.geometry_type());
    if flat == OGRwkbGeometryType::wkbMultiLineString {
        let mut parts = (0..geometry.geometry_count()).map(|i| geometry.get_geometry(i));
        return parts.try_for_each(|part| lines(placer, &part, found));
    }
    if flat != OGRwkbGeometryType::wkbLineString {
        return Err(geometry.geometry_name());
    }
    found.push(placer.vertices(geometry)?);
    Ok(())
}
