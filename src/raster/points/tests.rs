//! Points of layers as samples, and what is refused.

use std::path::{Path, PathBuf};

use gdal::DriverManager;
use gdal::spatial_ref::{AxisMappingStrategy, CoordTransform, SpatialRef};
use gdal::vector::{Geometry, LayerAccess, LayerOptions, OGRwkbGeometryType};
use tempfile::TempDir;

use super::*;
use crate::base::PointCounts;
use crate::base::control::CancelToken;
use crate::raster::Raster;

const NORTH_UP: [f64; 6] = [500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0];
const TURNED: [f64; 6] = [5e5, 8.0, 6.0, 5.2e6, 6.0, -8.0];
const UTM: u32 = 32633;

/// A folder with a raster of 20 × 15 samples.
struct Scene {
    folder: TempDir,
    raster: Raster,
}

impl Scene {
    fn new(geo_transform: [f64; 6], epsg: Option<u32>) -> Scene {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("dem.tif");
        let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
        let mut dataset = driver.create_with_band_type::<u8, _>(&path, 20, 15, 1).expect("a raster");
        dataset.set_geo_transform(&geo_transform).expect("a geotransform");
        if let Some(epsg) = epsg {
            dataset.set_spatial_ref(&SpatialRef::from_epsg(epsg).expect("known")).expect("a CRS");
        }
        dataset.close().expect("closed");
        let raster = Raster::open(&path, 1).expect("opens");
        Scene { folder, raster }
    }

    fn on_the_map() -> Scene {
        Scene::new(NORTH_UP, Some(UTM))
    }

    /// Map coordinates of a place between samples.
    fn at(&self, column: f64, row: f64) -> (f64, f64) {
        let [x0, xp, xl, y0, yp, yl] = self.raster.geo_transform().coefficients();
        let (p, l) = (column + 0.5, row + 0.5);
        (x0 + p * xp + l * xl, y0 + p * yp + l * yl)
    }

    /// GeoJSON of the raster's CRS.
    fn geojson(&self, geometries: &[String]) -> PathBuf {
        let crs = format!("urn:ogc:def:crs:EPSG::{UTM}");
        self.json(&format!(r#""crs": {{"type": "name", "properties": {{"name": "{crs}"}}}},"#), geometries)
    }

    fn json(&self, crs: &str, geometries: &[String]) -> PathBuf {
        let feature = |g: &String| format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {g}}}"#);
        let features: Vec<String> = geometries.iter().map(feature).collect();
        let text = format!(r#"{{"type": "FeatureCollection", {crs} "features": [{}]}}"#, features.join(",\n"));
        let path = self.folder.path().join("points.geojson");
        std::fs::write(&path, text).expect("written");
        path
    }

    /// A file of any OGR driver with layers of geometries as WKT, in the raster's CRS.
    fn vector(&self, driver: &str, name: &str, layers: &[(&str, &[&str])]) -> PathBuf {
        let path = self.folder.path().join(name);
        let driver = DriverManager::get_driver_by_name(driver).expect("a driver");
        let mut dataset = driver.create_vector_only(&path).expect("a file");
        let srs = SpatialRef::from_epsg(UTM).expect("known");
        for (name, geometries) in layers {
            let ty = if geometries.iter().all(|g| g.starts_with("POINT")) {
                OGRwkbGeometryType::wkbPoint
            } else {
                OGRwkbGeometryType::wkbUnknown
            };
            let options = LayerOptions { name, srs: Some(&srs), ty, ..LayerOptions::default() };
            let mut layer = dataset.create_layer(options).expect("a layer");
            for wkt in *geometries {
                layer.create_feature(Geometry::from_wkt(wkt).expect("WKT")).expect("a feature");
            }
        }
        dataset.close().expect("closed");
        path
    }

    fn read(&self, path: &Path, layer: Option<&str>) -> Result<Points, PointsError> {
        let source = PointSource { path: path.to_path_buf(), layer: layer.map(str::to_string) };
        read_points(&self.raster, &source, &CancelToken::default())
    }

    fn samples(&self, path: &Path) -> Vec<(usize, usize)> {
        self.read(path, None).expect("points").set.iter().collect()
    }

    #[track_caller]
    fn refuses(&self, path: &Path, layer: Option<&str>, words: &[&str]) {
        let message = self.read(path, layer).expect_err("no points").to_string();
        for word in words.iter().chain([&path.to_str().expect("UTF-8")]) {
            assert!(message.contains(word), "expected {word:?} in {message:?}");
        }
    }
}

fn point((x, y): (f64, f64)) -> String {
    format!(r#"{{"type": "Point", "coordinates": [{x}, {y}]}}"#)
}

#[test]
fn points_fall_to_the_nearest_sample() {
    for geo_transform in [NORTH_UP, TURNED] {
        let scene = Scene::new(geo_transform, Some(UTM));
        // On it, beside it, between four, and on the rim of the outermost pixels.
        let places = [(3.0, 4.0), (6.4, 7.6), (9.5, 2.5), (-0.45, 14.45), (19.45, -0.45), (9.0, 2.0)];
        let path = scene.geojson(&places.map(|(c, r)| point(scene.at(c, r))));
        let points = scene.read(&path, None).expect("points");
        assert_eq!(points.set.iter().collect::<Vec<_>>(), [(19, 0), (9, 2), (3, 4), (6, 8), (0, 14)]);
        assert_eq!(points.counts, PointCounts { read: 6, used: 5, merged: 1, outside: 0 });
        assert_eq!(points.layer, "points");
    }
}

#[test]
fn points_outside_are_counted() {
    let scene = Scene::on_the_map();
    let places = [(3.0, 4.0), (-0.6, 4.0), (19.6, 4.0), (3.0, -0.6), (3.0, 14.6), (1e9, -1e9)];
    let path = scene.geojson(&places.map(|(c, r)| point(scene.at(c, r))));
    let points = scene.read(&path, None).expect("points");
    assert_eq!(points.counts, PointCounts { read: 6, used: 1, merged: 0, outside: 5 });
    let path = scene.geojson(&places[1..3].iter().map(|&(c, r)| point(scene.at(c, r))).collect::<Vec<_>>());
    scene.refuses(&path, None, &["layer points", "all 2 outside", "column -0.6, row 4.0 of 20 × 15"]);
}

#[test]
fn many_points_in_one_feature_and_heights() {
    let scene = Scene::on_the_map();
    let ((ax, ay), (bx, by), (cx, cy)) = (scene.at(1.0, 1.0), scene.at(2.0, 1.0), scene.at(0.0, 9.0));
    let many = format!(r#"{{"type": "MultiPoint", "coordinates": [[{ax}, {ay}, 7], [{bx}, {by}, 8]]}}"#);
    let high = format!(r#"{{"type": "Point", "coordinates": [{cx}, {cy}, 1e9]}}"#);
    assert_eq!(scene.samples(&scene.geojson(&[many, high])), [(1, 1), (2, 1), (0, 9)]);
}

#[test]
fn layers_by_name_and_other_formats() {
    let scene = Scene::on_the_map();
    let at = |column, row| {
        let (x, y) = scene.at(column, row);
        format!("POINT ({x} {y})")
    };
    let (a, b, c) = (at(1.0, 2.0), at(3.0, 4.0), at(5.0, 6.0));
    let layers: [(&str, &[&str]); 2] = [("peaks", &[&a, &b]), ("pits", &[&c])];
    let path = scene.vector("GPKG", "points.gpkg", &layers);
    assert_eq!(scene.samples(&path), [(1, 2), (3, 4)]);
    let pits = scene.read(&path, Some("pits")).expect("points");
    assert_eq!((pits.set.iter().collect::<Vec<_>>(), pits.layer.as_str()), (vec![(5, 6)], "pits"));
    scene.refuses(&path, Some("passes"), &["expected layer passes", "found peaks, pits"]);
    scene.refuses(&path, Some("pa\0sses"), &["found peaks, pits"]);
    assert_eq!(scene.samples(&scene.vector("ESRI Shapefile", "points.shp", &layers[..1])), [(1, 2), (3, 4)]);
}

#[test]
fn what_is_no_point_is_refused() {
    let scene = Scene::on_the_map();
    let good = point(scene.at(1.0, 1.0));
    for (geometry, found) in [
        (r#"{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}"#, "expected a point or points, found LINESTRING"),
        (r#"{"type": "GeometryCollection", "geometries": []}"#, "found GEOMETRYCOLLECTION"),
        (r#"{"type": "MultiPoint", "coordinates": []}"#, "found an empty geometry"),
        (r#"{"type": "Point", "coordinates": []}"#, "found "),
        ("null", "found no geometry"),
    ] {
        let path = scene.geojson(&[good.clone(), geometry.to_string()]);
        scene.refuses(&path, None, &["layer points", "feature 1", found]);
    }
    let path = scene.vector("GPKG", "holes.gpkg", &[("holes", &["POINT (500005 5199995)", "POINT EMPTY"])]);
    scene.refuses(&path, None, &["layer holes, feature 2"]);
    let path = scene.folder.path().join("far.csv");
    std::fs::write(&path, "id,WKT\n1,\"POINT (500005 5199995)\"\n2,\"POINT (inf 5199995)\"\n").expect("written");
    scene.refuses(&path, None, &["layer far, feature 2"]);
}

#[test]
fn tables_of_coordinates() {
    let scene = Scene::on_the_map();
    let table = |rows: &str| {
        let path = scene.folder.path().join("table.csv");
        std::fs::write(&path, format!("name,X,Y\n{rows}")).expect("written");
        path
    };
    // The columns go east by ten metres, the rows south.
    assert_eq!(scene.samples(&table("a,500035,5199955\nb,500155,5199995\n")), [(15, 0), (3, 4)]);
    scene.refuses(&table("a,500035,5199955\nb,nan,5199995\n"), None, &["layer table, feature 2"]);
    scene.refuses(&table("a,,\n"), None, &["layer table, feature 1", "no geometry"]);
}

#[test]
fn files_that_are_missing_or_hold_no_layer() {
    let scene = Scene::on_the_map();
    scene.refuses(&scene.folder.path().join("none.geojson"), None, &["cannot be opened", "No such file"]);
    scene.refuses(scene.raster.path(), None, &["cannot be opened"]);
    scene.refuses(&scene.geojson(&[]), None, &["expected points, found none"]);
}

#[test]
fn places_are_brought_to_the_crs_of_the_raster() {
    let scene = Scene::on_the_map();
    // GeoJSON without a CRS is in longitude and latitude, in this order.
    let geographic = |epsg: u32| {
        let mut crs = SpatialRef::from_epsg(epsg).expect("known");
        crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
        crs
    };
    let transform = CoordTransform::new(&geographic(UTM), &geographic(4326)).expect("a way");
    let degrees = |column, row| {
        let (x, y) = scene.at(column, row);
        let (mut x, mut y) = ([x], [y]);
        transform.transform_coords(&mut x, &mut y, &mut []).expect("a place");
        point((x[0], y[0]))
    };
    let path = scene.json("", &[degrees(3.1, 4.0), degrees(17.0, 11.2), degrees(40.0, 4.0)]);
    let points = scene.read(&path, None).expect("points");
    assert_eq!(points.set.iter().collect::<Vec<_>>(), [(3, 4), (17, 11)]);
    assert_eq!(points.counts.outside, 1);
    // Where the raster has no CRS, numbers are taken as they are.
    let scene = Scene::new(NORTH_UP, None);
    let path = scene.json("", &[point(scene.at(3.0, 4.0))]);
    assert_eq!(scene.samples(&path), [(3, 4)]);
}

/// Another celestial body; a datum of which nothing is known but the ellipsoid.
#[test]
fn a_crs_without_a_way_to_the_rasters_is_refused() {
    let scene = Scene::on_the_map();
    for (name, definition) in
        [("moon", "+proj=longlat +R=1737400 +no_defs"), ("old", "+proj=longlat +ellps=bessel +no_defs")]
    {
        let path = scene.folder.path().join(name).with_extension("gpkg");
        let driver = DriverManager::get_driver_by_name("GPKG").expect("GPKG");
        let mut dataset = driver.create_vector_only(&path).expect("a file");
        let srs = SpatialRef::from_proj4(definition).expect("known");
        let options = LayerOptions { name, srs: Some(&srs), ..LayerOptions::default() };
        let mut layer = dataset.create_layer(options).expect("a layer");
        layer.create_feature(Geometry::from_wkt("POINT (15.001 46.9)").expect("WKT")).expect("a feature");
        dataset.close().expect("closed");
        scene.refuses(&path, None, &[&format!("layer {name}: cannot be transformed"), "EPSG:32633"]);
    }
}

#[test]
fn a_cancelled_reading_says_so() {
    let scene = Scene::on_the_map();
    let source = PointSource { path: scene.geojson(&[point(scene.at(1.0, 1.0))]), layer: None };
    let cancel = CancelToken::default();
    cancel.cancel();
    let run = read_points(&scene.raster, &source, &cancel);
    assert!(matches!(run, Err(PointsError::Cancelled(_))), "{run:?}");
}
