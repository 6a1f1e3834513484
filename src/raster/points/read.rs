//! Reading the points of a layer.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gdal::vector::{Geometry, Layer, LayerAccess, OGRwkbGeometryType, geometry_type_flatten};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};

use super::PointsError;
use super::place::Placer;
use crate::base::control::CancelToken;
use crate::base::key;
use crate::base::{PointCounts, PointSet};
use crate::raster::open::crs_name;
use crate::raster::reason;
use crate::raster::{About, GdalName, Raster};

/// Where points come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointSource {
    /// A file, or any name OGR opens.
    pub path: PathBuf,
    /// The layer; the first where none is named.
    pub layer: Option<String>,
}

/// The points of a layer, as samples of a raster.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Points {
    /// The samples nearest to the points.
    pub set: Arc<PointSet>,
    /// The layer's name.
    pub layer: String,
    /// What became of the points.
    pub counts: PointCounts,
}

/// Features between two looks at the cancellation token.
const FEATURES_BETWEEN_CHECKS: u64 = 1024;

/// The columns of a CSV file that are coordinates; its driver guesses none but WKT.
const CSV_COLUMNS: &[&str] = &["X_POSSIBLE_NAMES=x", "Y_POSSIBLE_NAMES=y"];

/// What a feature must be.
const POINTS: &str = "a point or points";

/// Reads a layer of points (Point or MultiPoint; z and m are ignored) and finds for each the nearest sample of `raster`.
/// Of a CSV file the columns x and y are taken, in either case, or one named WKT.
///
/// Places are brought to the raster's CRS where both have one; where one has none, they are taken as they are. A point
/// between samples falls to the nearest, of several to the one of the lowest column and row. Points more than half a
/// cell outside the samples' centres, or without a place in the raster's CRS, are counted and left out.
///
/// Memory: 8 bytes per point while they gather (16 while a list grows), 8 per sample in the end; and what OGR's driver
/// takes, which for GeoJSON is the whole layer.
///
/// # Errors
/// [`PointsError`]: nothing to open, no such layer, a feature that is no point or has coordinates that are no numbers,
/// a CRS there is no way from, no point on the raster.
pub fn read_points(raster: &Raster, source: &PointSource, cancel: &CancelToken) -> Result<Points, PointsError> {
    let (dataset, _name) = open(&source.path)?;
    let mut layer = choose(&dataset, source)?;
    let name = layer.name();
    let crs = layer.spatial_ref();
    let placer = Placer::new(raster, crs.as_ref()).map_err(|e| PointsError::Crs {
        path: source.path.clone(),
        layer: name.clone(),
        from: crs.as_ref().map_or("none".to_string(), crs_name),
        to: raster.crs_name(),
        reason: reason(&e),
    })?;
    let mut samples = Vec::new();
    let mut counts = PointCounts::default();
    let mut first = None;
    for_each_point(&mut layer, &source.path, cancel, |at| {
        counts.read += 1;
        first.get_or_insert(at);
        match placer.sample(at) {
            Some((column, row)) => samples.push(key(column, row)),
            None => counts.outside += 1,
        }
    })?;
    let Some(first) = first else { return Err(PointsError::NoPoints { path: source.path.clone(), layer: name }) };
    if samples.is_empty() {
        let first = describe(raster, placer.on_the_map(first));
        return Err(PointsError::AllOutside { path: source.path.clone(), layer: name, count: counts.read, first });
    }
    let set = PointSet::of_keys(samples);
    counts.used = set.len() as u64;
    counts.merged = counts.read - counts.outside - counts.used;
    Ok(Points { set: Arc::new(set), layer: name, counts })
}

/// Opens a file; its name is to be kept as long.
fn open(path: &Path) -> Result<(Dataset, GdalName), PointsError> {
    let csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let options = DatasetOptions {
        open_options: csv.then_some(CSV_COLUMNS),
        open_flags: GdalOpenFlags::GDAL_OF_READONLY
            | GdalOpenFlags::GDAL_OF_VECTOR
            | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
        ..DatasetOptions::default()
    };
    let _about = About::opening(path);
    let failed = |reason| PointsError::Open { path: path.to_path_buf(), reason };
    let name = GdalName::of(path).map_err(|e| failed(format!("its name is no UTF-8, and no link to it: {e}")))?;
    let dataset = Dataset::open_ex(name.path(), options)
        .map_err(|e| failed(reason(&e).trim_start_matches(&format!("{}: ", name.path().display())).to_string()))?;
    Ok((dataset, name))
}

fn choose<'a>(dataset: &'a Dataset, source: &PointSource) -> Result<Layer<'a>, PointsError> {
    let layer = match &source.layer {
        Some(name) => dataset.layer_by_name(name),
        None => dataset.layer(0),
    };
    layer.map_err(|_| PointsError::NoSuchLayer {
        path: source.path.clone(),
        wanted: source.layer.clone(),
        there: dataset.layers().map(|l| l.name()).collect(),
    })
}

/// Calls `take` with x and y of every point of a layer, in its order.
fn for_each_point(
    layer: &mut Layer<'_>,
    path: &Path,
    cancel: &CancelToken,
    mut take: impl FnMut((f64, f64)),
) -> Result<(), PointsError> {
    let (name, expected) = (layer.name(), layer.try_feature_count());
    let mut found = 0;
    for feature in layer.features() {
        if found % FEATURES_BETWEEN_CHECKS == 0 {
            cancel.check()?;
        }
        // Null, where a feature has no geometry.
        let geometry = feature.geometry_by_index(0).ok();
        geometry.map_or_else(|| Err(wrong(POINTS, "no geometry")), |g| points(g, &mut take)).map_err(|wrong| {
            let feature = feature.fid().unwrap_or(found);
            PointsError::Feature {
                path: path.to_path_buf(),
                layer: name.clone(),
                feature,
                expected: wrong.expected,
                found: wrong.found,
            }
        })?;
        found += 1;
    }
    // The end of a layer and a failure to read on look the same.
    match expected {
        Some(expected) if found < expected => {
            Err(PointsError::Incomplete { path: path.to_path_buf(), layer: name, expected, found })
        }
        _ => Ok(()),
    }
}

/// What is wrong with a geometry.
struct Wrong {
    expected: &'static str,
    found: String,
}

fn wrong(expected: &'static str, found: impl ToString) -> Wrong {
    Wrong { expected, found: found.to_string() }
}

fn points(geometry: &Geometry, take: &mut impl FnMut((f64, f64))) -> Result<(), Wrong> {
    let flat = geometry_type_flatten(geometry.geometry_type());
    if flat != OGRwkbGeometryType::wkbPoint && flat != OGRwkbGeometryType::wkbMultiPoint {
        return Err(wrong(POINTS, geometry.geometry_name()));
    }
    if geometry.is_empty() {
        return Err(wrong(POINTS, "an empty geometry"));
    }
    if flat == OGRwkbGeometryType::wkbMultiPoint {
        return (0..geometry.geometry_count()).try_for_each(|i| points(&geometry.get_geometry(i), take));
    }
    let (x, y, _) = geometry.get_point(0);
    if !(x.is_finite() && y.is_finite()) {
        return Err(wrong("finite coordinates", format!("{x}, {y}")));
    }
    take((x, y));
    Ok(())
}

/// Where a point outside the raster lies.
fn describe(raster: &Raster, at: Option<(f64, f64)>) -> String {
    let Some((x, y)) = at else { return "the first has no place in the raster's CRS".to_string() };
    let (column, row) = raster.geo_transform().sample_coordinates(x, y);
    let (width, height) = (raster.width(), raster.height());
    format!("the first lies at {x}, {y}, column {column:.1}, row {row:.1} of {width} × {height} samples")
}
