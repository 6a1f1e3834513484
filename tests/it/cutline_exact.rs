//! `--cutline-exact`: meshes that end at the polygons' own lines, and what `verify` says of them.

use std::fs;

use serde_json::{Value, json};

use crate::util::{Dem, Folder, hills, terrabite};

/// A polygon and its hole, in columns and rows of samples.
const OUTER: [(f64, f64); 4] = [(12.3, 5.1), (101.7, 20.4), (90.2, 80.9), (5.6, 70.3)];
const HOLE: [(f64, f64); 3] = [(40.2, 30.1), (60.9, 35.7), (50.5, 55.2)];

/// Hills with a void inside and one at the border.
fn heights(column: usize, row: usize) -> f64 {
    let is_void = (20..24).contains(&column) && (20..23).contains(&row) || (88..95).contains(&column) && row > 60;
    if is_void { -32768.0 } else { hills(column, row) }
}

struct Scene {
    folder: Folder,
    dem: String,
    tin: String,
}

impl Scene {
    fn new() -> Scene {
        let folder = Folder::new();
        let dem = Dem::new(120, 90).on_the_map().heights(heights).nodata(-32768.0).write(&folder, "dem.tif");
        let tin = folder.at("tin.ply");
        Scene { folder, dem, tin }
    }

    /// A layer with a polygon of these rings.
    fn polygon(&self, name: &str, rings: &[&[(f64, f64)]]) -> String {
        let at = |&(c, r): &(f64, f64)| json!([500_005.0 + c * 10.0, 5_199_995.0 - r * 10.0]);
        let rings: Vec<Vec<Value>> = rings.iter().map(|ring| ring.iter().chain(&ring[..1]).map(at).collect()).collect();
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        let geometry = json!({"type": "Polygon", "coordinates": rings});
        let features = json!([{"type": "Feature", "properties": {}, "geometry": geometry}]);
        self.folder.with(name, json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string())
    }

    fn simplify(&self, options: &[&str]) -> Value {
        let command = ["simplify", &self.dem, &self.tin, "--max-error", "3", "--overwrite", "--json"];
        terrabite([&command[..], options].concat()).succeeds().json()
    }

    fn verify(&self, options: &[&str]) -> (Option<i32>, Value) {
        self.verify_within("3", options)
    }

    fn verify_within(&self, max_error: &str, options: &[&str]) -> (Option<i32>, Value) {
        let command = ["verify", &self.dem, &self.tin, "--max-error", max_error, "--json"];
        let told = terrabite([&command[..], options].concat());
        (told.code, told.json())
    }
}

#[test]
fn the_mesh_ends_at_the_outlines_whatever_the_threads_the_memory_and_the_shards() {
    let scene = Scene::new();
    let area = scene.polygon("area.geojson", &[&OUTER, &HOLE]);
    let exact = ["--cutline", &area, "--cutline-exact"];
    let mut bytes = Vec::new();
    for (options, threads) in [
        (&["--tile", "16"][..], "1"),
        (&["--tile", "16", "--memory", "256MiB", "--access", "windows"], "3"),
        (&["--tile", "16", "--quality", "none"], "2"),
        (&["--tile", "23", "--quality", "best", "--heights", "fitted"], "2"),
        (&["--tile", "64", "--precision", "float"], "2"),
        (&["--tile", "0", "--quality", "fast"], "2"),
        (&["--tile", "32", "--max-triangles", "4000"], "2"),
    ] {
        let report = scene.simplify(&[&exact[..], options, &["--threads", threads]].concat());
        assert!(report["cutline"].is_null() && report["exact_cutline"]["lines"] == 2, "{report}");
        // With a budget errors may be larger.
        let most = report["error"]["max"].as_f64().unwrap().max(3.0);
        let (code, verdict) = scene.verify_within(&most.to_string(), &exact);
        assert_eq!(code, Some(0), "{verdict}");
        assert_eq!(verdict["double_area"], verdict["expected_double_area"]);
        for field in ["samples", "missing_samples", "isolated_samples"] {
            assert_eq!(report[field], verdict[field], "{field}: {report} {verdict}");
        }
        bytes.push(fs::read(&scene.tin).unwrap());
    }
    assert!(bytes[0] == bytes[1], "other bytes with other threads and another access");
    let header = String::from_utf8_lossy(&bytes[0][..1500]).to_string();
    assert!(header.contains("comment cutline exact area.geojson\n"), "{header}");

    let work = scene.folder.at("work");
    let plan = ["plan", &scene.dem, &work, "--max-error", "3", "--tile", "16"];
    terrabite([&plan[..], &exact].concat()).succeeds();
    for pass in ["1", "2", "3", "4"] {
        for shard in ["2/2", "1/2"] {
            terrabite(["run", &work, "--shard", shard, "--pass", pass]).succeeds();
        }
    }
    terrabite(["merge", &work, &scene.tin, "--overwrite"]).succeeds();
    assert!(fs::read(&scene.tin).unwrap() == bytes[0], "other bytes in shards");
}

#[test]
fn other_meshes_are_found_out_and_what_makes_no_sense_is_refused() {
    let scene = Scene::new();
    let area = scene.polygon("area.geojson", &[&OUTER, &HOLE]);
    let exact = ["--cutline", &area, "--cutline-exact"];
    for options in [&[][..], &["--cutline", &area]] {
        scene.simplify(options);
        let (code, verdict) = scene.verify(&exact);
        assert_eq!(code, Some(1), "{verdict}");
        let told = verdict["failures"].to_string();
        assert!(told.contains("cutline"), "{told}");
    }
    scene.simplify(&exact);
    assert_eq!(scene.verify(&["--cutline", &area]).0, Some(1));
    let without_hole = scene.polygon("whole.geojson", &[&OUTER]);
    let (code, verdict) = scene.verify(&["--cutline", &without_hole, "--cutline-exact"]);
    assert_eq!(code, Some(1));
    assert!(verdict["cutline"]["bare"]["count"].as_u64() > Some(9) && verdict["cutline"]["beyond"]["count"] == 0);

    let refused = |options: &[&str], code: i32, expected: &[&str]| {
        let command = ["simplify", &scene.dem, &scene.tin, "--max-error", "3", "--overwrite"];
        terrabite([&command[..], options].concat()).fails(code, expected);
    };
    refused(&["--cutline-exact"], 2, &["--cutline-exact requires --cutline", "use --cutline"]);
    refused(&[&exact[..], &["--trim", "2"]].concat(), 2, &["--cutline-exact cannot be combined with --trim"]);
    let outside = scene.polygon("outside.geojson", &[&[(-9.0, -9.0), (-3.0, -9.0), (-3.0, -3.0)]]);
    refused(
        &["--cutline", &outside, "--cutline-exact"],
        1,
        &["outside.geojson: expected a cutline around some of the raster", "--cutline"],
    );
    let void = scene.polygon("void.geojson", &[&[(20.2, 20.2), (22.8, 20.2), (22.8, 21.8), (20.2, 21.8)]]);
    refused(&["--cutline", &void, "--cutline-exact"], 1, &["--cutline", "if the raster has no void there"]);
}
