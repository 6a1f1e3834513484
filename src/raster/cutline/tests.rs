//! Cutlines against naive ones, and what is refused.

use proptest::prelude::*;

use super::*;
use crate::base::LineType;
use crate::base::control::CancelToken;
use crate::base::{Polygon, Window};
use crate::raster::{LineAsk, LineMemory, LineSource, Raster, Said, ShapesError, read_lines};

const ALL: Window = Window { column: 0, row: 0, width: 20, height: 15 };

fn polygon(rings: &[&[(f64, f64)]]) -> Polygon {
    let mut polygon = Polygon::default();
    rings.iter().for_each(|ring| polygon.add_ring(ring));
    polygon
}

fn square(left: f64, top: f64, right: f64, bottom: f64) -> [(f64, f64); 5] {
    [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]
}

fn inside(cutline: &Cutline, window: Window) -> Vec<(usize, usize)> {
    let mut mask = vec![true; 3];
    cutline.mask(window, &mut mask);
    let at = |i: usize| (window.column + i % window.width, window.row + i / window.width);
    (0..mask.len()).filter(|&i| mask[i]).map(at).collect()
}

#[test]
fn squares_holes_and_samples_on_sides() {
    let cutline = Cutline::new(vec![polygon(&[&square(2.0, 3.0, 7.0, 8.0), &square(3.5, 4.5, 5.5, 6.5)])]);
    let expected = |c: usize, r: usize| {
        (2..7).contains(&c) && (3..8).contains(&r) && !((4..6).contains(&c) && (5..7).contains(&r))
    };
    let all = (0..15).flat_map(|r| (0..20).map(move |c| (c, r)));
    assert_eq!(inside(&cutline, ALL), all.filter(|&(c, r)| expected(c, r)).collect::<Vec<_>>());
    assert_eq!(cutline.counts(), (1, 4));
}

#[test]
fn polygons_that_share_a_side_share_no_sample_and_leave_none_out() {
    let (left, right) = ([(0.0, 0.0), (9.0, 0.0), (4.0, 14.0)], [(9.0, 0.0), (19.0, 3.0), (4.0, 14.0)]);
    let reversed: Vec<(f64, f64)> = right.iter().rev().copied().collect();
    let alone = |ring: &[(f64, f64)]| inside(&Cutline::new(vec![polygon(&[ring])]), ALL);
    let mut both = [alone(&left), alone(&right)].concat();
    both.sort_by_key(|&(c, r)| (r, c));
    assert!(both.windows(2).all(|w| w[0] != w[1]));
    let whole = Cutline::new(vec![polygon(&[&[(0.0, 0.0), (9.0, 0.0), (19.0, 3.0), (4.0, 14.0)]])]);
    assert_eq!(both, inside(&whole, ALL));
    assert_eq!(alone(&right), alone(&reversed));
    // One over the other is inside, not cut out.
    let twice = Cutline::new(vec![polygon(&[&left]), polygon(&[&left])]);
    assert_eq!(inside(&twice, ALL), alone(&left));
}

/// By definition: sides to the left of the sample, counted.
fn odd(ring: &[(f64, f64)], column: f64, row: f64) -> bool {
    let sides = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossed = sides.filter(|(a, b)| {
        let (a, b) = if a.1 < b.1 { (a, b) } else { (b, a) };
        a.1 <= row && row < b.1 && a.0 + (b.0 - a.0) * ((row - a.1) / (b.1 - a.1)) <= column
    });
    crossed.count() % 2 == 1
}

proptest! {
    #[test]
    fn a_window_has_what_counting_sides_finds(
        ring in prop::collection::vec((-40i32..120, -40i32..100), 3..600),
        (column, row) in (0usize..15, 0usize..12), (width, height) in (1usize..9, 1usize..9),
    ) {
        // Quarters: many sides pass through samples.
        let ring: Vec<(f64, f64)> = ring.iter().map(|&(x, y)| (f64::from(x) / 4.0, f64::from(y) / 4.0)).collect();
        let cutline = Cutline::new(vec![polygon(&[&ring])]);
        let mut mask = Vec::new();
        cutline.mask(Window { column, row, width, height }, &mut mask);
        for (i, inside) in mask.into_iter().enumerate() {
            let (c, r) = ((column + i % width) as f64, (row + i / width) as f64);
            prop_assert_eq!(inside, odd(&ring, c, r), "at {} {}", c, r);
        }
    }
}

/// 20 × 15 samples of 10 m in UTM zone 33 north; a layer beside it.
fn scene(layer: &str) -> (tempfile::TempDir, Raster, CutlineSource) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dem.tif");
    let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let mut dataset = driver.create_with_band_type::<u8, _>(&path, 20, 15, 1).expect("a raster");
    dataset.set_geo_transform(&[500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0]).expect("a geotransform");
    dataset.set_spatial_ref(&gdal::spatial_ref::SpatialRef::from_epsg(32633).expect("known")).expect("a CRS");
    dataset.close().expect("closed");
    let raster = Raster::open(&path, 1).expect("opens");
    let source = CutlineSource { path: folder.path().join("cut.geojson"), layer: None };
    std::fs::write(&source.path, layer).expect("written");
    (folder, raster, source)
}

fn geojson(crs: &str, geometry: &str) -> String {
    let crs = if crs.is_empty() {
        String::new()
    } else {
        format!(r#""crs": {{"type": "name", "properties": {{"name": "{crs}"}}}},"#)
    };
    let feature = format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {geometry}}}"#);
    format!(r#"{{"type": "FeatureCollection", {crs} "features": [{feature}]}}"#)
}

const UTM: &str = "urn:ogc:def:crs:EPSG::32633";

fn read(raster: &Raster, source: &CutlineSource) -> Result<Cutline, ShapesError> {
    Ok(read_cutline(raster, source, &CancelToken::default())?.0)
}

#[test]
fn polygons_of_a_layer_and_windows_of_a_raster() {
    let rings = "[[[500020, 5199970], [500070, 5199970], [500070, 5199920], [500020, 5199920], [500020, 5199970]]]";
    let geometry = format!(r#"{{"type": "MultiPolygon", "coordinates": [{rings}, {rings}]}}"#);
    let (_folder, raster, source) = scene(&geojson(UTM, &geometry));
    let expected: Vec<(usize, usize)> = (3..8).flat_map(|r| (2..7).map(move |c| (c, r))).collect();
    let cutline = read(&raster, &source).expect("polygons");
    assert_eq!(inside(&cutline, ALL), expected);
    assert_eq!(cutline.counts(), (2, 4));
    let raster = raster.clip(Window { column: 2, row: 3, width: 5, height: 6 }).expect("inside");
    let found = inside(&read(&raster, &source).expect("polygons"), Window { column: 0, row: 0, width: 5, height: 6 });
    assert_eq!(found, (0..5).flat_map(|r| (0..5).map(move |c| (c, r))).collect::<Vec<_>>());
}

#[test]
fn sides_in_another_crs_are_bent() {
    // A parallel of latitude across the zone, 300 km long: its middle lies far off its chord.
    let rings = "[[[13.0, 46.0], [17.0, 46.0], [17.0, 46.953], [13.0, 46.953], [13.0, 46.0]]]";
    let (_folder, raster, source) = scene(&geojson("", &format!(r#"{{"type": "Polygon", "coordinates": {rings}}}"#)));
    let cutline = read(&raster, &source).expect("polygons");
    assert!(cutline.counts().1 > 50, "{:?}", cutline.counts());
    // 46.953° is at 5 199 941 m on the zone's meridian, and 5.4 km farther north at its chord's middle.
    let rows: Vec<usize> = inside(&cutline, ALL).iter().map(|&(_, r)| r).collect();
    assert_eq!(rows.first(), Some(&6));
    assert_eq!(rows.len(), 20 * 9);
}

/// A line that is turned about its middle, where a meridian and the equator cross: there it meets its chord.
#[test]
fn sides_that_are_bent_to_both_sides_are_bent() {
    let crs = gdal::spatial_ref::SpatialRef::from_epsg(32633).expect("UTM");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dem.tif");
    let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let mut dataset = driver.create_with_band_type::<f32, _>(&path, 40, 40, 1).expect("a raster");
    dataset.set_geo_transform(&[300_000.0, 10_000.0, 0.0, 200_000.0, 0.0, -10_000.0]).expect("placed");
    dataset.set_spatial_ref(&crs).expect("a CRS");
    dataset.close().expect("closed");
    let raster = Raster::open(&path, 1).expect("opens");
    let line = r#"{"type": "LineString", "coordinates": [[3.0, -14.0], [27.0, 14.0]]}"#;
    let source = LineSource { path: folder.path().join("line.geojson"), layer: None };
    std::fs::write(&source.path, geojson("", line)).expect("written");
    let lines = read_lines(
        &raster,
        &source,
        &LineAsk { with_heights: Said::Of(false), types: Said::Of(LineType::Hard) },
        &LineMemory { temp_dir: None, vertices: usize::MAX },
        &CancelToken::default(),
    )
    .expect("a line");
    let line = &lines[0].lines()[0];
    assert!(line.len() > 5, "{line:?}");
    let turned = |(column, row): (f64, f64)| (39.0 - column, 39.0 - row);
    for (&(column, row), &other) in line.iter().zip(line.iter().rev()) {
        let (c, r) = turned(other);
        assert!((c - column).abs() < 1e-3 && (r - row).abs() < 1e-3, "{line:?}");
    }
}

#[test]
fn features_without_geometry_are_counted() {
    let rings = "[[[500020, 5199970], [500070, 5199970], [500070, 5199920], [500020, 5199920], [500020, 5199970]]]";
    let polygon = format!(
        r#"{{"type": "Feature", "properties": {{}}, "geometry": {{"type": "Polygon", "coordinates": {rings}}}}}"#
    );
    let nothing = r#"{"type": "Feature", "properties": {}, "geometry": null}"#;
    let crs = format!(r#""crs": {{"type": "name", "properties": {{"name": "{UTM}"}}}}"#);
    let layer = format!(r#"{{"type": "FeatureCollection", {crs}, "features": [{nothing}, {polygon}, {nothing}]}}"#);
    let (_folder, raster, source) = scene(&layer);
    let (cutline, without) = read_cutline(&raster, &source, &CancelToken::default()).expect("a polygon");
    // Two of its sides are level.
    assert_eq!((cutline.counts(), without), ((1, 2), 2));
}

#[test]
fn what_is_no_polygon_is_refused() {
    for (geometry, expected) in [
        (r#"{"type": "Point", "coordinates": [1, 2]}"#, "feature 0, found POINT"),
        (r#"{"type": "LineString", "coordinates": [[1, 2], [3, 4]]}"#, "found LINESTRING"),
        ("null", "expected polygons, found none; features without geometry: 1"),
    ] {
        let (_folder, raster, source) = scene(&geojson(UTM, geometry));
        let message = read(&raster, &source).expect_err("refused").to_string();
        assert!(message.contains(expected) && message.contains("cut.geojson: layer cut"), "{message}");
    }
    let (_folder, raster, source) = scene(r#"{"type": "FeatureCollection", "features": []}"#);
    assert!(read(&raster, &source).expect_err("refused").to_string().contains("expected polygons, found none"));
    let missing = CutlineSource { layer: Some("coast".to_string()), ..source.clone() };
    assert!(read(&raster, &missing).expect_err("refused").to_string().contains("expected layer coast, found cut"));
    let none = CutlineSource { path: "none.gpkg".into(), layer: None };
    assert!(read(&raster, &none).expect_err("refused").to_string().contains("none.gpkg: cannot be opened"));
}
