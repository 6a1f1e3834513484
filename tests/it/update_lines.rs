//! `terrabite plan --update` with lines: what is taken over becomes the same mesh, whatever has changed.

use std::fs;

use serde_json::{Value, json};

use crate::resume::{dem, ground};
use crate::util::{Folder, terrabite};

/// A raster of 2 × 6 tiles, and layers over it.
struct Scene {
    folder: Folder,
}

impl Scene {
    /// Writes a layer of lines, or of outlines, each vertex with a height.
    fn layer(&self, name: &str, kind: &str, shapes: &[&[(f64, f64)]]) {
        let place = |&(c, r): &(f64, f64)| json!([500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0, 50.0]);
        let feature = |shape: &&[(f64, f64)]| {
            let places: Vec<Value> = shape.iter().map(place).collect();
            let coordinates = if kind == "Polygon" { json!([places]) } else { json!(places) };
            json!({"type": "Feature", "properties": {}, "geometry": {"type": kind, "coordinates": coordinates}})
        };
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        let features: Vec<Value> = shapes.iter().map(feature).collect();
        self.folder.with(name, json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string());
    }

    /// The lines, the last of which is a ring over several tiles; all of them so far to the right.
    fn lines(&self, shift: f64) {
        let ring = [(20.3, 150.2), (180.7, 160.1), (140.2, 260.9), (20.3, 150.2)];
        let road = [(30.2 + shift, 20.4), (60.0, 40.1), (70.6, 90.3)];
        self.layer("roads.geojson", "LineString", &[&road, &[(5.0, 310.0), (190.0, 330.5)], &ring]);
    }

    fn heights(&self, heights: fn(usize, usize) -> f64) {
        dem().on_the_map().heights(heights).write(&self.folder, "dem.tif");
    }

    /// How many tiles of how many are taken over, and whether the mesh is that of a run of its own.
    fn updated(&self, options: &[&str]) -> [u64; 2] {
        let at = |name: &str| self.folder.at(name);
        let [dem, tin, old, work] = ["dem.tif", "tin.ply", "old", "work"].map(at);
        let options = [&["--max-error", "3", "--tile", "100"], options].concat();
        terrabite([["simplify", &dem, &tin, "--overwrite"].as_slice(), &options].concat()).succeeds();
        let expected = fs::read(&tin).unwrap();
        let planned = terrabite([["plan", &dem, &work, "--update", &old, "--json"].as_slice(), &options].concat());
        let taken = planned.succeeds().json()["taken_over"].clone();
        terrabite(["run", &work]).succeeds();
        terrabite(["merge", &work, &tin, "--overwrite", "--keep-work-dir"]).succeeds();
        assert!(fs::read(&tin).unwrap() == expected, "other bytes: {options:?}");
        fs::remove_dir_all(&old).unwrap();
        fs::rename(&work, &old).unwrap();
        ["taken", "tiles"].map(|name| taken[name].as_u64().unwrap())
    }

    /// The first run, whose work dir stays.
    fn first(&self, options: &[&str]) {
        let [dem, old, tin] = ["dem.tif", "old", "tin.ply"].map(|name| self.folder.at(name));
        terrabite([["plan", &dem, &old, "--max-error", "3", "--tile", "100"].as_slice(), options].concat()).succeeds();
        terrabite(["run", &old]).succeeds();
        terrabite(["merge", &old, &tin, "--overwrite", "--keep-work-dir"]).succeeds();
    }
}

fn with_hill(column: usize, row: usize) -> f64 {
    ground(column, row) + if (40..60).contains(&column) && (280..300).contains(&row) { 40.0 } else { 0.0 }
}

#[test]
fn tiles_that_no_change_of_raster_or_lines_concerns_are_taken_over() {
    let scene = Scene { folder: Folder::new() };
    let [roads, lakes, area] = ["roads.geojson", "lakes.geojson", "area.geojson"].map(|name| scene.folder.at(name));
    let square = |c: f64, r: f64, side: f64| [(c, r), (c + side, r), (c + side, r + side), (c, r + side), (c, r)];
    scene.layer("area.geojson", "Polygon", &[&square(10.3, 8.2, 175.0), &square(20.1, 300.0, 170.0)]);
    for options in [
        &["--breaklines", &roads][..],
        &["--breaklines", &roads, "--breakline-z", "line", "--lake-polygons", &lakes, "--quality", "none"],
        &["--breaklines", &roads, "--cutline", &area, "--cutline-exact", "--quality", "fast"],
    ] {
        scene.heights(ground);
        scene.lines(0.0);
        scene.layer("lakes.geojson", "Polygon", &[&square(120.2, 20.3, 14.0)]);
        scene.first(options);
        // The same once more, then a road and a lake elsewhere, then a hill, then both as they were.
        let [taken, tiles] = scene.updated(options);
        assert_eq!(taken, tiles, "{options:?}");
        let lake = if options.contains(&"--lake-polygons") { &["a lake"][..] } else { &[] };
        for what in ["a road", "a hill", "all"].iter().chain(lake) {
            match *what {
                "a road" => scene.lines(1.0),
                "a hill" => scene.heights(with_hill),
                "a lake" => scene.layer("lakes.geojson", "Polygon", &[&square(121.2, 20.3, 14.0)]),
                _ => {
                    scene.heights(ground);
                    scene.lines(0.0);
                }
            }
            let [taken, tiles] = scene.updated(options);
            assert!(0 < taken && taken < tiles, "{what}: {taken} of {tiles}: {options:?}");
        }
        fs::remove_dir_all(scene.folder.join("old")).unwrap();
    }
    // Other kinds of lines are another job.
    scene.first(&["--breaklines", &roads]);
    let [dem, old, work] = ["dem.tif", "old", "work"].map(|name| scene.folder.at(name));
    let plan = ["plan", &dem, &work, "--update", &old, "--max-error", "3", "--tile", "100", "--breaklines", &roads];
    terrabite(plan.iter().chain(&["--breakline-shift", "1"])).fails(1, &["another job", "--breaklines"]);
}
