//! Reading the polygons of a layer.

use std::path::PathBuf;

use gdal::spatial_ref::CoordTransform;
use gdal::vector::{Geometry, LayerAccess, OGRwkbGeometryType, geometry_type_flatten};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};

use super::CutlineError;
use crate::base::Cutline;
use crate::base::GeoTransform;
use crate::base::Polygon;
use crate::base::control::CancelToken;
use crate::raster::crs::{transform, transformed};
use crate::raster::open::crs_name;
use crate::raster::reason;
use crate::raster::{About, GdalName, Raster};

/// Where the polygons come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CutlineSource {
    /// A file, or any name OGR opens.
    pub path: PathBuf,
    /// The layer; the first where none is named.
    pub layer: Option<String>,
}

/// How far a side in another CRS may be from its straight line, in cells, before it is given another vertex.
const BENT_CELLS: f64 = 0.1;

/// How often a side is halved at most.
const HALVINGS: u32 = 12;

/// Features between two looks at the cancellation token.
const FEATURES_BETWEEN_CHECKS: u64 = 256;

/// Reads a layer of polygons (Polygon or MultiPolygon; z and m are ignored) and brings them to the samples of `raster`, or
/// of the window of it that is looked at.
///
/// Vertices are transformed to the raster's CRS where both have one, and sides that are bent there are given further
/// vertices, a tenth of a cell exact; where one has none, coordinates are taken as they are.
///
/// Memory: 32 bytes per vertex, and what OGR's driver takes.
///
/// # Errors
/// [`CutlineError`]: nothing to open, no such layer, a feature that is no polygon, a CRS there is no way from.
pub fn read_cutline(raster: &Raster, source: &CutlineSource, cancel: &CancelToken) -> Result<Cutline, CutlineError> {
    let path = &source.path;
    let options = DatasetOptions {
        open_flags: GdalOpenFlags::GDAL_OF_READONLY
            | GdalOpenFlags::GDAL_OF_VECTOR
            | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
        ..DatasetOptions::default()
    };
    let _about = About::opening(path);
    let failed = |reason| CutlineError::Open { path: path.clone(), reason };
    let file = GdalName::of(path).map_err(|e| failed(format!("its name is no UTF-8, and no link to it: {e}")))?;
    let dataset = Dataset::open_ex(file.path(), options)
        .map_err(|e| failed(reason(&e).trim_start_matches(&format!("{}: ", file.path().display())).to_string()))?;
    let layer = source.layer.as_ref().map_or_else(|| dataset.layer(0), |name| dataset.layer_by_name(name));
    let mut layer = layer.map_err(|_| {
        let there: Vec<String> = dataset.layers().map(|l| l.name()).collect();
        CutlineError::NoSuchLayer {
            path: path.clone(),
            expected: source.layer.as_ref().map_or("a vector layer".to_string(), |name| format!("layer {name}")),
            found: if there.is_empty() { "none".to_string() } else { there.join(", ") },
        }
    })?;
    let name = layer.name();
    let wrong = |expected: String, found: String| CutlineError::Layer {
        path: path.clone(),
        layer: name.clone(),
        expected,
        found,
    };
    let crs = layer.spatial_ref();
    let transform = match (&crs, raster.dataset.spatial_ref()) {
        (Some(from), Ok(to)) => transform(from, &to).map_err(|e| CutlineError::Crs {
            path: path.clone(),
            layer: name.clone(),
            from: crs_name(from),
            to: raster.crs_name(),
            reason: reason(&e),
        })?,
        _ => None,
    };
    let rings = Rings { transform, geo_transform: raster.geo_transform() };
    let expected = layer.try_feature_count();
    let (mut polygons, mut found) = (Vec::new(), 0);
    for feature in layer.features() {
        if found % FEATURES_BETWEEN_CHECKS == 0 {
            cancel.check()?;
        }
        let id = feature.fid().unwrap_or(found);
        // Null, where a feature has no geometry.
        let geometry = feature.geometry_by_index(0).map_err(|_| "no geometry".to_string());
        geometry
            .and_then(|geometry| rings.polygons(geometry, &mut polygons))
            .map_err(|found| wrong(format!("a polygon or polygons in feature {id}"), found))?;
        found += 1;
    }
    // The end of a layer and a failure to read on look the same.
    if let Some(expected) = expected.filter(|expected| found < *expected) {
        return Err(wrong(format!("{expected} features"), format!("{found}: the file is damaged")));
    }
    if polygons.is_empty() {
        return Err(wrong("polygons".to_string(), "none".to_string()));
    }
    Ok(Cutline::new(polygons))
}

/// Brings rings to columns and rows.
struct Rings {
    transform: Option<CoordTransform>,
    geo_transform: GeoTransform,
}

impl Rings {
    fn polygons(&self, geometry: &Geometry, polygons: &mut Vec<Polygon>) -> Result<(), String> {
        let flat = geometry_type_flatten(geometry.geometry_type());
        if flat == OGRwkbGeometryType::wkbMultiPolygon {
            let mut parts = (0..geometry.geometry_count()).map(|i| geometry.get_geometry(i));
            return parts.try_for_each(|part| self.polygons(&part, polygons));
        }
        if flat != OGRwkbGeometryType::wkbPolygon {
            return Err(geometry.geometry_name());
        }
        let mut polygon = Polygon::default();
        for i in 0..geometry.geometry_count() {
            polygon.add_ring(&self.ring(&geometry.get_geometry(i))?);
        }
        polygons.push(polygon);
        Ok(())
    }

    fn ring(&self, ring: &Geometry) -> Result<Vec<(f64, f64)>, String> {
        let mut points = Vec::new();
        ring.get_points(&mut points);
        let mut places = Vec::with_capacity(points.len());
        let mut before: Option<((f64, f64), (f64, f64))> = None;
        for (x, y, _) in points {
            if !(x.is_finite() && y.is_finite()) {
                return Err(format!("a vertex at {x}, {y}"));
            }
            let place =
                self.place((x, y)).ok_or_else(|| format!("{x}, {y}, which has no place in the raster's CRS"))?;
            if let (Some(before), true) = (before, self.transform.is_some()) {
                self.bend(before, ((x, y), place), HALVINGS, &mut places);
            }
            places.push(place);
            before = Some(((x, y), place));
        }
        Ok(places)
    }

    fn place(&self, at: (f64, f64)) -> Option<(f64, f64)> {
        let (x, y) = transformed(self.transform.as_ref(), at)?;
        let (column, row) = self.geo_transform.sample_coordinates(x, y);
        (column.is_finite() && row.is_finite()).then_some((column, row))
    }

    /// Adds vertices between two, each as it is in the layer and its place, where the side is not straight there.
    fn bend(
        &self,
        a: ((f64, f64), (f64, f64)),
        b: ((f64, f64), (f64, f64)),
        halvings: u32,
        places: &mut Vec<(f64, f64)>,
    ) {
        let half = |a: (f64, f64), b: (f64, f64)| (a.0 + (b.0 - a.0) / 2.0, a.1 + (b.1 - a.1) / 2.0);
        let middle = half(a.0, b.0);
        let Some(place) = self.place(middle) else { return };
        let straight = half(a.1, b.1);
        let bent = (place.0 - straight.0).hypot(place.1 - straight.1) > BENT_CELLS;
        if halvings == 0 || !bent {
            return;
        }
        self.bend(a, (middle, place), halvings - 1, places);
        places.push(place);
        self.bend((middle, place), b, halvings - 1, places);
    }
}
