//! `--breaklines`: lines from a layer to edges of the written mesh, and what `verify` says of them.

use std::fs;

use serde_json::{Value, json};

use crate::util::{Dem, Folder, Run, terrabite, terrabite_with_fault};

/// A folder with a raster of 40 × 30 samples, ten metres a cell, to be cut into tiles of 16 cells.
pub(crate) struct Scene {
    pub(crate) folder: Folder,
    pub(crate) dem: String,
}

/// Across seams and corners of tiles, one of them along a seam, one outside.
pub(crate) const LINES: [&[(f64, f64)]; 4] = [
    &[(1.3, 2.7), (16.0, 9.2), (38.9, 27.4)],
    &[(16.0, 20.3), (16.0, 3.1), (20.0, 3.1)],
    &[(30.0, -4.0), (30.2, 40.0)],
    &[(-9.0, 3.0), (-3.0, 8.0)],
];

impl Scene {
    pub(crate) fn new() -> Scene {
        let folder = Folder::new();
        let dem = Dem::new(40, 30).on_the_map().write(&folder, "dem.tif");
        Scene { folder, dem }
    }

    pub(crate) fn layer(&self, name: &str, lines: &[&[(f64, f64)]]) -> String {
        let at = |&(c, r): &(f64, f64)| json!([500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0, 7.0]);
        let line = |line: &&[(f64, f64)]| json!({"type": "LineString", "coordinates": line.iter().map(at).collect::<Vec<_>>()});
        self.geometries(name, lines.iter().map(line).collect())
    }

    fn geometries(&self, name: &str, geometries: Vec<Value>) -> String {
        let feature = |g| json!({"type": "Feature", "properties": {}, "geometry": g});
        let features: Vec<Value> = geometries.into_iter().map(feature).collect();
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        self.folder.with(name, json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string())
    }

    fn command(&self, name: &str, options: &[&str]) -> Vec<String> {
        let tin = self.folder.at("tin.ply");
        let words = [&[name, &self.dem, &tin, "--max-error", "3", "--json"], options].concat();
        words.into_iter().map(str::to_string).collect()
    }

    fn simplify(&self, lines: &str, options: &[&str]) -> Run {
        let usual = ["--tile", "16", "--overwrite", "--breaklines", lines];
        terrabite(self.command("simplify", &[&usual, options].concat()))
    }

    fn verify(&self, lines: &str, options: &[&str]) -> Run {
        terrabite(self.command("verify", &[&["--breaklines", lines], options].concat()))
    }

    fn written(&self) -> Vec<u8> {
        fs::read(self.folder.join("tin.ply")).unwrap()
    }
}

/// The lines hold at the tolerance that is found; what they take at the least is told where a budget is too small for it.
#[test]
fn a_budget_has_room_for_the_lines_or_is_refused() {
    let scene = Scene::new();
    let lines = scene.layer("roads.geojson", &LINES);
    let [dem, tin] = [&scene.dem, &scene.folder.at("tin.ply")];
    let fixed = ["simplify", dem, tin, "--tile", "16", "--overwrite", "--json", "--breaklines", &lines];
    let told = terrabite(fixed.iter().chain(&["--max-triangles", "450"])).succeeds().json();
    assert!((350..=450).contains(&told["triangles"].as_u64().unwrap()), "{told}");
    let tolerance = told["tolerance"].to_string();
    terrabite(["verify", dem, tin, "--max-error", &tolerance, "--breaklines", &lines]).succeeds();
    terrabite(fixed.iter().chain(&["--max-triangles", "20"]))
        .fails(2, &["expected a budget of at least", "breaklines"]);
}

#[test]
fn edges_follow_lines_and_verify_finds_them() {
    let scene = Scene::new();
    let lines = scene.layer("roads.geojson", &LINES);
    let mut bytes = Vec::new();
    for (options, threads) in
        [(&[][..], "1"), (&[], "3"), (&["--heights", "fitted"], "2"), (&["--quality", "none"], "2")]
    {
        let report = scene.simplify(&lines, &[options, &["--threads", threads]].concat()).succeeds().json();
        let told = &report["breaklines"];
        assert_eq!((&told["lines"], &told["left_out"], &told["shift"]), (&json!(4), &json!(1), &json!(0.5)), "{told}");
        assert_eq!(told["chains"]["off_ground"], 0);
        assert_eq!(report["max_stray"], Value::Null);
        let verdict = scene.verify(&lines, &[]).succeeds().json();
        assert_eq!(verdict["breaklines"]["segments"], told["segments"]);
        assert_eq!(verdict["breaklines"]["broken"]["count"], 0);
        assert!(verdict["breaklines"]["edges"].as_u64() <= told["chains"]["edges"].as_u64());
        bytes.push(scene.written());
    }
    assert!(bytes[0] == bytes[1], "other bytes with other threads");
    let header = String::from_utf8_lossy(&bytes[0][..1000]).to_string();
    assert!(header.contains("comment breaklines roads.geojson\ncomment breakline shift 0.5\n"), "{header}");
    // Every place of the lines as a vertex, for a tighter shift.
    let tight = scene.simplify(&lines, &["--breakline-shift", "0"]).succeeds().json();
    scene.verify(&lines, &["--breakline-shift", "0"]).succeeds();
    let edges = |report: &Value| report["breaklines"]["chains"]["edges"].as_u64();
    let usual = scene.simplify(&lines, &[]).succeeds().json();
    assert!(edges(&tight) > edges(&usual), "{tight} and {usual}");
    let other = scene.verify(&scene.layer("other.geojson", &[&[(3.3, 25.2), (22.1, 27.9)]]), &[]);
    assert_eq!(other.code, Some(1), "{other:#?}");
    terrabite(scene.command("simplify", &["--overwrite"])).succeeds();
    let failed = scene.verify(&lines, &[]);
    assert_eq!(failed.code, Some(1), "{failed:#?}");
    let failed = failed.json();
    assert!(failed["failures"][0].as_str().unwrap().contains("breaklines are not followed by edges"), "{failed}");
}

#[test]
fn a_run_that_was_killed_continues_with_the_same_lines_only_and_shards_make_the_same_bytes() {
    let scene = Scene::new();
    let (lines, other) = (scene.layer("roads.geojson", &LINES), scene.layer("other.geojson", &LINES[..1]));
    scene.simplify(&lines, &[]).succeeds();
    let expected = scene.written();
    let work = scene.folder.at("work");
    let command = |lines: &str| {
        scene.command("simplify", &["--tile", "16", "--overwrite", "--work-dir", &work, "--breaklines", lines])
    };
    assert_eq!(terrabite_with_fault("kill:vertices:1", command(&lines)).code, None);
    terrabite(command(&other)).fails(1, &["another job", "breaklines: expected"]);
    terrabite(command(&lines)).succeeds();
    assert!(scene.written() == expected);

    let usual = ["plan", &scene.dem, &work, "--max-error", "3", "--tile", "16", "--breaklines", &lines];
    terrabite(usual).succeeds();
    for pass in ["1", "2", "3", "4"] {
        for shard in ["2/2", "1/2"] {
            terrabite(["run", &work, "--shard", shard, "--pass", pass]).succeeds();
        }
    }
    terrabite(["merge", &work, &scene.folder.at("tin.ply"), "--overwrite"]).succeeds();
    assert!(scene.written() == expected, "other bytes in shards");
}

#[test]
fn features_without_geometry_are_told() {
    let scene = Scene::new();
    let line = json!({"type": "LineString", "coordinates": [[500_020.0, 5_199_970.0], [500_300.0, 5_199_800.0]]});
    let lines = scene.geometries("roads.geojson", vec![Value::Null, line, Value::Null]);
    for report in [scene.simplify(&lines, &[]).succeeds().json(), scene.verify(&lines, &[]).succeeds().json()] {
        let told = report["warnings"].as_array().unwrap().iter().find(|told| told["code"] == "no_geometry").unwrap();
        assert!(told["count"] == 2 && told["file"].as_str().unwrap().ends_with("roads.geojson"), "{told}");
    }
    let nothing = scene.geometries("nothing.geojson", vec![Value::Null]);
    scene
        .simplify(&nothing, &[])
        .fails(1, &["nothing.geojson", "expected lines, found none; features without geometry: 1"]);
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    let scene = Scene::new();
    let lines = scene.layer("roads.geojson", &LINES);
    let points =
        scene.geometries("points.geojson", vec![json!({"type": "Point", "coordinates": [500_100.0, 5_199_900.0]})]);
    let far = scene.layer("far.geojson", &[&[(900.0, 900.0), (999.0, 950.0)]]);
    scene.simplify(&scene.dem, &[]).fails(1, &["dem.tif: cannot be opened as a layer of lines", "--breaklines"]);
    scene.simplify(&points, &[]).fails(1, &["points.geojson", "expected a line", "found POINT", "--breaklines-layer"]);
    scene.simplify(&far, &[]).fails(1, &["far.geojson: expected lines on the raster, found none of 1", "ogr2ogr"]);
    scene.simplify(&lines, &["--breaklines-layer", "sea"]).fails(1, &["expected layer sea, found roads"]);
    scene.simplify(&lines, &["--breakline-shift", "99"]).fails(2, &["from 0 to 16"]);
    scene.simplify(&lines, &["--engine", "greedy-cuts"]).fails(2, &["--breaklines", "greedy cuts take no given edges"]);
    scene.simplify(&lines, &["--max-stray", "2"]).fails(2, &["--breaklines cannot be combined with --max-stray"]);
    scene.verify(&lines, &["--trim", "2"]).fails(2, &["--breaklines cannot be combined with --trim"]);
    terrabite(scene.command("simplify", &["--breakline-shift", "1"])).fails(2, &["--breaklines"]);
}
