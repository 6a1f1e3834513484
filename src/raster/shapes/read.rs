//! Reading lines and rings of a layer.

use std::path::Path;

use gdal::spatial_ref::CoordTransform;
use gdal::vector::{Feature, Geometry, LayerAccess};
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};

use super::ShapesError;
use crate::base::GeoTransform;
use crate::base::control::CancelToken;
use crate::base::plainly::Plainly;
use crate::raster::crs::{transform, transformed};
use crate::raster::open::crs_name;
use crate::raster::reason;
use crate::raster::{About, GdalName, Raster};

/// How far a side in another CRS may be from its straight line, in cells, before it is given another vertex.
const BENT_CELLS: f64 = 0.1;

/// Where along a side its bend is looked for. A curve that meets its chord in the middle, as a side does that is turned about its
/// middle, is seen at a quarter; one that meets it at all three places and both ends is no polynomial below the fifth degree.
const LOOKED_AT: [f64; 3] = [0.25, 0.5, 0.75];

/// How often a side is halved at most.
const HALVINGS: u32 = 12;

/// Features between two looks at the cancellation token.
const FEATURES_BETWEEN_CHECKS: u64 = 256;

/// What is wrong with a feature.
#[derive(Debug)]
pub(in crate::raster) struct Wrong {
    /// `None`: another kind of shape.
    expected: Option<String>,
    found: String,
}

impl Wrong {
    pub(in crate::raster) fn new(expected: String, found: String) -> Wrong {
        Wrong { expected: Some(expected), found }
    }
}

impl From<String> for Wrong {
    fn from(found: String) -> Wrong {
        Wrong { expected: None, found }
    }
}

/// Calls `take` with the geometry of every feature of a layer and the feature with its number, and with what brings its vertices to the samples of `raster`, or of the
/// window of it that is looked at. `take` adds shapes to those of a feature, at least one in all, or says what it found in place of one; `keep`
/// is given one after the other. The `shapes` are called `one` in a feature. Features without geometry are passed over; gives how many there are.
///
/// # Errors
/// [`ShapesError`]: nothing to open, no such layer, a feature of another kind, a CRS there is no way from.
pub(in crate::raster) fn for_each_geometry<S, W: Into<Wrong>>(
    raster: &Raster,
    (path, layer): (&Path, Option<&str>),
    (shapes, one): (&'static str, &str),
    cancel: &CancelToken,
    take: impl Fn(&Placer, &Geometry, (u64, &Feature<'_>), &mut Vec<S>) -> Result<(), W>,
    mut keep: impl FnMut(S) -> Result<(), ShapesError>,
) -> Result<u64, ShapesError> {
    let options = DatasetOptions {
        open_flags: GdalOpenFlags::GDAL_OF_READONLY
            | GdalOpenFlags::GDAL_OF_VECTOR
            | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
        ..DatasetOptions::default()
    };
    let _about = About::opening(path);
    let failed = |reason| ShapesError::Open { path: path.to_path_buf(), shapes, reason };
    let file = GdalName::of(path).map_err(|e| failed(format!("its name is no UTF-8, and no link to it: {e}")))?;
    let dataset = Dataset::open_ex(file.path(), options)
        .map_err(|e| failed(reason(&e).trim_start_matches(&format!("{}: ", file.path().display())).to_string()))?;
    let found = layer.map_or_else(|| dataset.layer(0), |name| dataset.layer_by_name(name));
    let mut there = found.map_err(|_| {
        let names: Vec<String> = dataset.layers().map(|l| l.name()).collect();
        ShapesError::NoSuchLayer {
            path: path.to_path_buf(),
            expected: layer.map_or("a vector layer".to_string(), |name| format!("layer {name}")),
            found: if names.is_empty() { "none".to_string() } else { names.join(", ") },
        }
    })?;
    let name = there.name();
    let wrong = |expected: String, found: String| ShapesError::Layer {
        path: path.to_path_buf(),
        layer: name.clone(),
        expected,
        found,
    };
    let crs = there.spatial_ref();
    let transform = match (&crs, raster.dataset.spatial_ref()) {
        (Some(from), Ok(to)) => transform(from, &to).map_err(|e| ShapesError::Crs {
            path: path.to_path_buf(),
            layer: name.clone(),
            from: crs_name(from),
            to: raster.crs_name(),
            reason: reason(&e),
        })?,
        _ => None,
    };
    let placer = Placer { transform, geo_transform: raster.geo_transform() };
    let expected = there.try_feature_count();
    let (mut shapes_of, mut is_empty, mut found, mut without_geometry) = (Vec::new(), true, 0, 0);
    for feature in there.features() {
        if found % FEATURES_BETWEEN_CHECKS == 0 {
            cancel.check()?;
        }
        let id = feature.fid().unwrap_or(found);
        // Null, where a feature has no geometry.
        match feature.geometry_by_index(0) {
            Ok(geometry) => take(&placer, geometry, (id, &feature), &mut shapes_of).map_err(Into::into).map_err(
                |Wrong { expected, found }| wrong(expected.unwrap_or(format!("{one} in feature {id}")), found),
            )?,
            Err(_) => without_geometry += 1,
        }
        is_empty &= shapes_of.is_empty();
        shapes_of.drain(..).try_for_each(&mut keep)?;
        found += 1;
    }
    // The end of a layer and a failure to read on look the same.
    if let Some(expected) = expected.filter(|expected| found < *expected) {
        return Err(wrong(format!("{expected} features"), format!("{found}: the file is damaged")));
    }
    if is_empty {
        let found = match without_geometry {
            0 => "none".to_string(),
            count => format!("none; features without geometry: {count}"),
        };
        return Err(wrong(shapes.to_string(), found));
    }
    Ok(without_geometry)
}

/// Places of vertices, and their heights.
pub(in crate::raster) type Places = (Vec<(f64, f64)>, Vec<f64>);

/// A vertex as it is in the layer, and its place.
#[derive(Clone, Copy)]
struct Corner {
    map: (f64, f64),
    place: (f64, f64),
    height: f64,
}

/// Brings vertices of a layer to columns and rows.
pub(in crate::raster) struct Placer {
    transform: Option<CoordTransform>,
    geo_transform: GeoTransform,
}

impl Placer {
    /// The vertices of a line or a ring (z and m are ignored). In another CRS lines that are bent in the raster's are given further ones,
    /// a tenth of a cell exact.
    pub(in crate::raster) fn vertices(&self, line: &Geometry) -> Result<Vec<(f64, f64)>, String> {
        Ok(self.vertices_with_heights(line)?.0)
    }

    /// The same, and the z of each vertex, 0 where a line has none. Between two vertices it is on a straight line.
    pub(in crate::raster) fn vertices_with_heights(&self, line: &Geometry) -> Result<Places, String> {
        let mut points = Vec::new();
        line.get_points(&mut points);
        let mut places = Vec::with_capacity(points.len());
        let mut before: Option<Corner> = None;
        for (x, y, height) in points {
            if !(x.is_finite() && y.is_finite()) {
                return Err(format!("a vertex at {}, {}", Plainly(x), Plainly(y)));
            }
            let place = self
                .place((x, y))
                .ok_or_else(|| format!("{}, {}, which has no place in the raster's CRS", Plainly(x), Plainly(y)))?;
            let here = Corner { map: (x, y), place, height };
            if let (Some(before), true) = (before, self.transform.is_some()) {
                self.bend(before, here, HALVINGS, &mut places);
            }
            places.push((place, height));
            before = Some(here);
        }
        Ok(places.into_iter().unzip())
    }

    fn place(&self, at: (f64, f64)) -> Option<(f64, f64)> {
        let (x, y) = transformed(self.transform.as_ref(), at)?;
        let (column, row) = self.geo_transform.sample_coordinates(x, y);
        (column.is_finite() && row.is_finite()).then_some((column, row))
    }

    /// Adds vertices between two, where the side is not straight.
    fn bend(&self, a: Corner, b: Corner, halvings: u32, places: &mut Vec<((f64, f64), f64)>) {
        let part = |a: (f64, f64), b: (f64, f64), t: f64| (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t);
        let is_bent = |&t: &f64| {
            let straight = part(a.place, b.place, t);
            let place = self.place(part(a.map, b.map, t));
            place.is_some_and(|place| (place.0 - straight.0).hypot(place.1 - straight.1) > BENT_CELLS)
        };
        let map = part(a.map, b.map, 0.5);
        let Some(place) = self.place(map).filter(|_| halvings > 0 && LOOKED_AT.iter().any(is_bent)) else { return };
        let middle = Corner { map, place, height: a.height + (b.height - a.height) / 2.0 };
        self.bend(a, middle, halvings - 1, places);
        places.push((place, middle.height));
        self.bend(middle, b, halvings - 1, places);
    }
}
