//! Reading the polygons of a layer.

use std::path::PathBuf;

use gdal::vector::{Feature, Geometry, OGRwkbGeometryType, geometry_type_flatten};

use crate::base::Cutline;
use crate::base::Polygon;
use crate::base::control::CancelToken;
use crate::raster::Raster;
use crate::raster::shapes::{Placer, ShapesError, for_each_geometry};

/// Where the polygons come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CutlineSource {
    /// A file, or any name OGR opens.
    pub path: PathBuf,
    /// The layer; the first where none is named.
    pub layer: Option<String>,
}

/// Reads a layer of polygons (Polygon or MultiPolygon; z and m are ignored) and brings them to the samples of `raster`, or
/// of the window of it that is looked at. Gives also how many features have no geometry, which are passed over.
///
/// Vertices are transformed to the raster's CRS where both have one, and sides that are bent there are given further
/// vertices, a tenth of a cell exact; where one has none, coordinates are taken as they are.
///
/// Memory: 32 bytes per vertex, and what OGR's driver takes.
///
/// # Errors
/// [`ShapesError`]: nothing to open, no such layer, a feature that is no polygon, a CRS there is no way from.
pub fn read_cutline(
    raster: &Raster,
    source: &CutlineSource,
    cancel: &CancelToken,
) -> Result<(Cutline, u64), ShapesError> {
    let from = (source.path.as_path(), source.layer.as_deref());
    let take = |placer: &Placer, geometry: &Geometry, _: (u64, &Feature<'_>), found: &mut Vec<Polygon>| {
        polygons(placer, geometry, found)
    };
    let mut found = Vec::new();
    let keep = |polygon: Polygon| {
        found.push(polygon);
        Ok(())
    };
    let without_geometry = for_each_geometry(raster, from, ("polygons", "a polygon or polygons"), cancel, take, keep)?;
    Ok((Cutline::new(found), without_geometry))
}

fn polygons(placer: &Placer, geometry: &Geometry, found: &mut Vec<Polygon>) -> Result<(), String> {
    let flat = geometry_type_flatten(geometry.geometry_type());
    if flat == OGRwkbGeometryType::wkbMultiPolygon {
        let mut parts = (0..geometry.geometry_count()).map(|i| geometry.get_geometry(i));
        return parts.try_for_each(|part| polygons(placer, &part, found));
    }
    if flat != OGRwkbGeometryType::wkbPolygon {
        return Err(geometry.geometry_name());
    }
    let mut polygon = Polygon::default();
    for i in 0..geometry.geometry_count() {
        polygon.add_ring(&placer.vertices(&geometry.get_geometry(i))?);
    }
    found.push(polygon);
    Ok(())
}
