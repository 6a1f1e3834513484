//! `terrabite simplify --points`: critical points from a layer to the written mesh.

use std::collections::BTreeSet;
use std::fs;

use crate::util::{Dem, Folder, Run, terrabite, terrabite_with_fault};

/// A folder with a raster of 40 × 30 samples, ten metres a cell, to be cut into tiles of 16 cells.
struct Scene {
    folder: Folder,
    dem: String,
}

/// Corners of tiles, seams, rims, ground; two that fall to one sample, one outside.
const PLACES: [(f64, f64); 10] = [
    (0.0, 0.0),
    (16.0, 16.0),
    (16.0, 5.2),
    (7.4, 16.0),
    (39.3, 11.0),
    (3.0, 29.0),
    (8.0, 8.0),
    (8.1, 7.9),
    (31.0, 20.0),
    (50.0, 3.0),
];

impl Scene {
    fn new() -> Scene {
        let folder = Folder::new();
        let dem = Dem::new(40, 30).on_the_map().write(&folder, "dem.tif");
        Scene { folder, dem }
    }

    fn at(&self, (column, row): (f64, f64)) -> [f64; 2] {
        [500_000.0 + (column + 0.5) * 10.0, 5_200_000.0 - (row + 0.5) * 10.0]
    }

    /// A layer of points at samples, as GeoJSON in the raster's CRS.
    fn layer(&self, name: &str, places: &[(f64, f64)]) -> String {
        let points = places.iter().map(|&place| {
            let [x, y] = self.at(place);
            format!(r#"{{"type": "Point", "coordinates": [{x}, {y}]}}"#)
        });
        self.geometries(name, &points.collect::<Vec<_>>())
    }

    fn geometries(&self, name: &str, geometries: &[String]) -> String {
        let feature = |g: &String| format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {g}}}"#);
        let features = geometries.iter().map(feature).collect::<Vec<_>>().join(",");
        let crs = r#"{"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}"#;
        let text = format!(r#"{{"type": "FeatureCollection", "crs": {crs}, "features": [{features}]}}"#);
        self.folder.with(name, text)
    }

    /// The command that takes points, with an engine that can.
    fn command(&self, points: &str, options: &[&str]) -> Vec<String> {
        let (tin, engine) = (self.folder.at("tin.ply"), ["--engine", "greedy-insertion"]);
        let usual = ["simplify", &self.dem, &tin, "--max-error", "1000", "--tile", "16", "--json", "--points", points];
        usual.iter().chain(&engine).chain(options).map(|word| word.to_string()).collect()
    }

    fn run(&self, points: &str, options: &[&str]) -> Run {
        terrabite(self.command(points, options))
    }

    fn written(&self) -> Vec<u8> {
        fs::read(self.folder.join("tin.ply")).unwrap()
    }

    #[track_caller]
    fn refuses(&self, points: &str, options: &[&str], words: &[&str]) {
        let before = self.folder.names();
        self.run(points, options).fails(1, words);
        assert_eq!(self.folder.names(), before);
    }
}

/// Where the vertices of a written mesh lie: x and y, by their bits.
fn places_of(ply: &[u8]) -> BTreeSet<[u64; 2]> {
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let header = std::str::from_utf8(&ply[..end]).unwrap();
    let count = header.lines().find_map(|l| l.strip_prefix("element vertex ")).unwrap().parse().unwrap();
    let number = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().unwrap());
    ply[end..].chunks(24).take(count).map(|v| [number(&v[..8]), number(&v[8..16])]).collect()
}

#[test]
fn points_are_vertices_of_the_written_mesh() {
    let scene = Scene::new();
    let points = scene.layer("peaks.geojson", &PLACES);
    let report = scene.run(&points, &[]).succeeds().json();
    let expected = serde_json::json!({
        "file": points, "layer": "peaks", "read": 10, "used": 8, "merged": 1, "outside": 1,
    });
    assert_eq!(report["points"], expected);
    terrabite(["verify", &scene.dem, &scene.folder.at("tin.ply"), "--max-error", "1000"]).succeeds();
    let (ply, found) = (scene.written(), places_of(&scene.written()));
    assert!(ply.windows(30).any(|w| w.starts_with(b"\ncomment points peaks.geojson\n")));
    for (column, row) in &PLACES[..9] {
        let place = scene.at((column.round(), row.round()));
        assert!(found.contains(&place.map(f64::to_bits)), "{column}, {row}");
    }
}

#[test]
fn greedy_cuts_leave_points_uncovered_until_they_are_vertices() {
    let scene = Scene::new();
    let (points, tin) = (scene.layer("peaks.geojson", &PLACES), scene.folder.at("tin.ply"));
    for (cuts, quality) in [("plain", "none"), ("improved", "none"), ("plain", "balanced")] {
        let usual = ["simplify", &scene.dem, &tin, "--max-error", "1000", "--tile", "16", "--points", &points, "-q"];
        terrabite(usual.iter().chain(&["--cuts", cuts, "--quality", quality, "--overwrite"])).succeeds();
        terrabite(["verify", &scene.dem, &tin, "--max-error", "1000", "-q"]).succeeds();
        let found = places_of(&scene.written());
        for (column, row) in &PLACES[..9] {
            let place = scene.at((column.round(), row.round()));
            assert!(found.contains(&place.map(f64::to_bits)), "{cuts} {quality}: {column}, {row}");
        }
    }
}

#[test]
fn neither_threads_nor_the_order_of_points_change_a_byte() {
    let scene = Scene::new();
    let mut places = PLACES.to_vec();
    scene.run(&scene.layer("peaks.geojson", &places), &["--threads", "1"]).succeeds();
    let expected = scene.written();
    places.reverse();
    scene.run(&scene.layer("peaks.geojson", &places), &["--threads", "2", "--overwrite"]).succeeds();
    assert!(scene.written() == expected);
}

#[test]
fn layers_that_cannot_be_used() {
    let scene = Scene::new();
    let missing = scene.folder.at("none.geojson");
    scene.refuses(&missing, &[], &[&missing, "No such file"]);
    let peaks = scene.layer("peaks.geojson", &PLACES);
    scene.refuses(&peaks, &["--points-layer", "passes"], &[&peaks, "passes", "found peaks", "--points-layer"]);
    let outside = scene.layer("far.geojson", &[(-5.0, 3.0), (1.0, 99.0)]);
    scene.refuses(&outside, &[], &[&outside, "all 2 outside"]);
    let line = r#"{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}"#;
    let lines = scene.geometries("lines.geojson", &[line.to_string()]);
    scene.refuses(&lines, &[], &[&lines, "feature 0", "LINESTRING"]);
    scene.refuses(&scene.dem, &[], &["layer of points"]);
}

#[test]
fn the_points_are_never_the_output() {
    let scene = Scene::new();
    let points = scene.layer("tin.ply", &PLACES);
    let before = scene.written();
    scene.run(&points, &["--overwrite"]).fails(1, &["same file as the input"]);
    assert!(scene.written() == before);
}

#[test]
fn a_work_dir_belongs_to_its_points() {
    let scene = Scene::new();
    let work = scene.folder.at("work");
    let (some, others) = (scene.layer("some.geojson", &PLACES), scene.layer("others.geojson", &PLACES[..5]));
    let command = scene.command(&some, &["--work-dir", &work]);
    terrabite_with_fault("kill:chunk-renamed:2", command);
    scene.run(&others, &["--work-dir", &work]).fails(1, &["--points: 8 samples", "in the work dir, 5 samples"]);
    // The same samples from another file.
    let mut places = PLACES;
    places.reverse();
    let same = scene.layer("same.geojson", &places);
    let report = scene.run(&same, &["--work-dir", &work]).succeeds().json();
    assert!(report["tiles_found"].as_u64().unwrap() >= 1, "{report}");
}

#[test]
fn a_layer_of_no_points() {
    let scene = Scene::new();
    let tin = scene.folder.at("tin.ply");
    terrabite(["simplify", &scene.dem, &tin, "--max-error", "1", "--points-layer", "peaks"]).fails(2, &["--points"]);
    assert_eq!(scene.folder.names(), ["dem.tif"]);
}
