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

    pub(crate) fn geometries(&self, name: &str, geometries: Vec<Value>) -> String {
        let feature = |g| json!({"type": "Feature", "properties": {}, "geometry": g});
        let features: Vec<Value> = geometries.into_iter().map(feature).collect();
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        self.folder.with(name, json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string())
    }

    /// Two lakes, one with an island, across seams and the raster's rim.
    pub(crate) fn lakes(&self) -> String {
        let feature = |level: f64, rings: Value| {
            let geometry = json!({"type": "Polygon", "coordinates": rings});
            json!({"type": "Feature", "properties": {"level": level, "name": "pond"}, "geometry": geometry})
        };
        let square = |c: f64, r: f64, side: f64| {
            let corners = [(c, r), (c + side, r), (c + side, r + side), (c, r + side), (c, r)];
            corners.map(|(c, r)| [500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0])
        };
        let features = [
            feature(7.0, json!([square(4.3, 12.2, 15.5), square(8.1, 16.3, 3.5)])),
            feature(7.0, json!([square(33.2, 4.4, 12.0)])),
        ];
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        let layer = json!({"type": "FeatureCollection", "crs": crs, "features": features});
        self.folder.with("lakes.geojson", layer.to_string())
    }

    pub(crate) fn command(&self, name: &str, options: &[&str]) -> Vec<String> {
        let tin = self.folder.at("tin.ply");
        let words = [&[name, &self.dem, &tin, "--max-error", "3", "--json"], options].concat();
        words.into_iter().map(str::to_string).collect()
    }

    pub(crate) fn simplify(&self, lines: &str, options: &[&str]) -> Run {
        let usual = ["--tile", "16", "--overwrite", "--breaklines", lines];
        terrabite(self.command("simplify", &[&usual, options].concat()))
    }

    pub(crate) fn verify(&self, lines: &str, options: &[&str]) -> Run {
        terrabite(self.command("verify", &[&["--breaklines", lines], options].concat()))
    }

    pub(crate) fn written(&self) -> Vec<u8> {
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
        let limit = if options.contains(&"none") { Value::Null } else { json!(1.5) };
        assert_eq!(report["max_stray"], limit);
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
    let lakes = scene.lakes();
    for options in [&[][..], &["--breakline-z", "line"], &["--lake-polygons", &lakes, "--lake-z", "field:level"]] {
        killed_continued_and_in_shards(options);
    }
}

fn killed_continued_and_in_shards(options: &[&str]) {
    let scene = Scene::new();
    let (lines, other) = (scene.layer("roads.geojson", &LINES), scene.layer("other.geojson", &LINES[..1]));
    scene.simplify(&lines, options).succeeds();
    let expected = scene.written();
    let work = scene.folder.at("work");
    let command = |lines: &str| {
        let usual = ["--tile", "16", "--overwrite", "--work-dir", &work, "--breaklines", lines];
        scene.command("simplify", &[&usual, options].concat())
    };
    assert_eq!(terrabite_with_fault("kill:vertices:1", command(&lines)).code, None);
    terrabite(command(&other)).fails(1, &["another job", "segments of lines: "]);
    terrabite(command(&lines)).succeeds();
    assert!(scene.written() == expected);

    let usual = ["plan", &scene.dem, &work, "--max-error", "3", "--tile", "16", "--breaklines", &lines];
    terrabite(usual.iter().chain(options)).succeeds();
    for pass in ["1", "2", "3", "4"] {
        for shard in ["2/2", "1/2"] {
            terrabite(["run", &work, "--shard", shard, "--pass", pass]).succeeds();
        }
    }
    terrabite(["merge", &work, &scene.folder.at("tin.ply"), "--overwrite"]).succeeds();
    assert!(scene.written() == expected, "other bytes in shards");
}

/// The layer's lines are level, seven metres up; its raster is not.
#[test]
fn edges_have_the_heights_of_lines_and_samples_beside_them_are_told() {
    let scene = Scene::new();
    let lines = scene.layer("dams.geojson", &LINES);
    let own = ["--breakline-z", "line"];
    for options in [&["--threads", "1"][..], &["--heights", "fitted"], &["--quality", "none", "--precision", "float"]] {
        let report = scene.simplify(&lines, &[&own, options].concat()).succeeds().json();
        let verdict = scene.verify(&lines, &own).succeeds().json();
        assert_eq!(
            (&report["breaklines"]["z"], &verdict["breaklines"]["broken"]["count"]),
            (&json!("line"), &json!(0))
        );
        assert!(report["beside_lines"].as_u64() > Some(100), "{report}");
        assert_eq!(report["beside_lines"], verdict["beside_lines"]);
        assert!(report["error"]["max"].as_f64() <= Some(3.0), "{report}");
        // Samples beside the lines are too far from the surface, and so are edges, if nobody says why.
        assert_eq!(scene.verify(&lines, &[]).code, Some(1));
        assert_eq!(terrabite(scene.command("verify", &[])).code, Some(1));
    }
    let header = String::from_utf8_lossy(&scene.written()[..1000]).to_string();
    assert!(header.contains("comment breakline z line\n"), "{header}");
    scene.simplify(&lines, &[]).succeeds();
    assert_eq!(scene.verify(&lines, &own).code, Some(1));
}

#[test]
fn lines_without_one_height_at_every_place_are_refused_by_name() {
    let scene = Scene::new();
    let line = |coordinates: Value| json!({"type": "LineString", "coordinates": coordinates});
    let at = |c: f64, r: f64| (500_005.0 + c * 10.0, 5_199_995.0 - r * 10.0);
    let [(w, n), (e, s)] = [at(4.0, 4.0), at(14.0, 14.0)];
    let flat =
        scene.geometries("flat.geojson", vec![line(json!([[w, n, 3.0], [e, s, 3.0]])), line(json!([[w, s], [e, n]]))]);
    let own = ["--breakline-z", "line"];
    let expected = [
        "flat.geojson: layer flat: expected a line or lines with heights in feature 1, found LINESTRING without heights (2-D)",
        "--breakline-z raster",
    ];
    scene.simplify(&flat, &own).fails(1, &expected);
    let two = scene.geometries(
        "two.geojson",
        vec![line(json!([[w, n, 3.0], [e, s, 3.0]])), line(json!([[w, s, 9.0], [e, n, 9.0]]))],
    );
    let expected = [
        "two.geojson: expected one height at column 9, row 9, where lines meet, found 3 in feature 0 of the breaklines and 9 in feature 1",
        "--breakline-z raster",
    ];
    scene.simplify(&two, &own).fails(1, &expected);
    scene.simplify(&two, &[]).succeeds();
    scene.verify(&two, &own).fails(1, &expected);
    let loose = scene.command("simplify", &["--breaklines", &two, "--breakline-z", "line", "--overwrite"]);
    terrabite(loose.into_iter().map(|word| if word == "3" { "6".to_string() } else { word })).succeeds();
    // The tolerance is found later: heights must be the same.
    let budget = ["simplify", &scene.dem, &scene.folder.at("tin.ply"), "--overwrite", "--tile", "16", "--breaklines"];
    let of_budget = |lines: &str, goal: [&str; 2]| terrabite([&budget[..], &[lines, "--json"], &own, &goal].concat());
    of_budget(&two, ["--max-triangles", "900"]).fails(1, &["expected one height at column 9, row 9", "under a budget"]);
    let agreeing = scene.layer("agreeing.geojson", &LINES);
    for goal in [["--max-triangles", "900"], ["--max-rms", "0.4"], ["--max-points", "400"]] {
        let told = of_budget(&agreeing, goal).succeeds().json();
        let found = told["tolerance"].to_string();
        let verdict =
            ["verify", &scene.dem, &scene.folder.at("tin.ply"), "--max-error", &found, "--breaklines", &agreeing];
        terrabite(verdict.iter().chain(&own)).succeeds();
        assert!(told["triangles"].as_u64() <= Some(900) || goal[0] == "--max-rms", "{told}");
    }
    terrabite(scene.command("simplify", &own)).fails(2, &["--breakline-z line requires --breaklines"]);
}

#[test]
fn a_field_says_whose_heights_count() {
    let scene = Scene::new();
    let layer = |name: &str, from: [Value; 2]| {
        // An empty line has no heights, whatever the field says.
        let lines: [&[(f64, f64)]; 3] = [&[(3.2, 4.4), (36.0, 6.0)], &[(4.0, 24.5), (37.5, 20.0)], &[]];
        let from = from.iter().chain([&Value::from("line")]).cloned().collect::<Vec<_>>();
        let feature = |(line, from): (&&[(f64, f64)], &Value)| {
            let at = |&(c, r): &(f64, f64)| json!([500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0, 40.0]);
            let geometry = json!({"type": "LineString", "coordinates": line.iter().map(at).collect::<Vec<_>>()});
            json!({"type": "Feature", "properties": {"z_from": from, "width": 3}, "geometry": geometry})
        };
        let features: Vec<Value> = lines.iter().zip(&from).map(feature).collect();
        let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}});
        scene.folder.with(name, json!({"type": "FeatureCollection", "crs": crs, "features": features}).to_string())
    };
    let both = layer("both.geojson", [json!("line"), json!("raster")]);
    let field = ["--breakline-z", "field:z_from"];
    let report = scene.simplify(&both, &field).succeeds().json();
    assert_eq!((&report["breaklines"]["z"], &report["breaklines"]["lines"]), (&json!("field:z_from"), &json!(3)));
    assert!(report["beside_lines"].as_u64().is_some_and(|beside| beside > 20), "{report}");
    let verdict = scene.verify(&both, &field).succeeds().json();
    assert_eq!(verdict["breaklines"]["segments"], report["breaklines"]["segments"]);
    let header = String::from_utf8_lossy(&scene.written()[..2000]).into_owned();
    assert!(header.contains("comment breakline z field:z_from\n"), "{header}");
    // One line is on the ground, the other is not: neither all nor none of them have heights.
    for other in [&["--breakline-z", "line"][..], &[]] {
        let verdict = scene.verify(&both, other);
        assert!(verdict.code == Some(1), "{other:?}: {verdict:?}");
    }
    for from in ["line", "raster"] {
        let all = layer("all.geojson", [json!(from), json!(from)]);
        let meshes = [&field, &["--breakline-z", from]].map(|options| {
            let report = scene.simplify(&all, options).succeeds().json();
            (report["triangles"].clone(), report["breaklines"]["chains"].clone())
        });
        assert_eq!(meshes[0], meshes[1]);
    }
    let odd = layer("odd.geojson", [json!("line"), json!("both")]);
    scene.simplify(&odd, &field).fails(
        1,
        &["expected the text raster or line in field z_from of feature 1, found the text \"both\"", "--breakline-z"],
    );
    scene.simplify(&both, &["--breakline-z", "field:width"]).fails(
        1,
        &["expected the text raster or line in field width of feature 0, found no text, but", "--breakline-z"],
    );
    scene
        .simplify(&both, &["--breakline-z", "field:level"])
        .fails(1, &["in field level of feature 0, found no such field among width, z_from"]);
    scene.simplify(&both, &["--breakline-z", "feet"]).fails(2, &["expected raster, line or field:NAME"]);
}

/// Houses, one with a yard, one across a seam and one at the raster's rim, together with roads or alone.
#[test]
fn edges_follow_the_outlines_of_footprints_together_with_breaklines() {
    let scene = Scene::new();
    let roads = scene.layer("roads.geojson", &LINES);
    let ring = |corners: &[(f64, f64)]| {
        let at = |&(c, r): &(f64, f64)| json!([500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0]);
        corners.iter().chain(&corners[..1]).map(at).collect::<Vec<_>>()
    };
    let square = |c: f64, r: f64, side: f64| ring(&[(c, r), (c + side, r), (c + side, r + side), (c, r + side)]);
    let houses = scene.geometries(
        "houses.geojson",
        vec![
            json!({"type": "Polygon", "coordinates": [square(4.3, 11.2, 9.0), square(6.1, 13.3, 3.5)]}),
            json!({"type": "MultiPolygon", "coordinates": [[square(13.7, 20.4, 4.0)], [square(36.2, 5.5, 9.0)]]}),
        ],
    );
    let mut bytes = Vec::new();
    for (options, threads) in
        [(&[][..], "1"), (&[], "3"), (&["--quality", "none"], "2"), (&["--breakline-z", "line"], "2")]
    {
        let usual = [&["--footprints", &houses, "--threads", threads], options].concat();
        let report = scene.simplify(&roads, &usual).succeeds().json();
        let of = |name: &str| [&report[name]["lines"], &report[name]["z"]].map(Value::clone);
        let z = if options.contains(&"line") { "line" } else { "raster" };
        assert_eq!((of("breaklines"), of("footprints")), ([json!(4), json!(z)], [json!(4), json!("raster")]));
        assert!(report["footprints"]["chains"]["edges"].as_u64() >= Some(13), "{report}");
        let z = ["--breakline-z", z];
        scene.verify(&roads, &[&["--footprints", &houses], &z[..]].concat()).succeeds();
        bytes.push(scene.written());
    }
    assert!(bytes[0] == bytes[1], "other bytes with other threads");
    let header = String::from_utf8_lossy(&bytes[0][..1000]).to_string();
    assert!(header.contains("comment footprints houses.geojson\ncomment breakline shift 0.5\n"), "{header}");

    let alone = ["--footprints", &houses, "--overwrite", "--tile", "16", "--breakline-shift", "1"];
    let report = terrabite(scene.command("simplify", &alone)).succeeds().json();
    assert_eq!(report["breaklines"], Value::Null);
    terrabite(scene.command("verify", &["--footprints", &houses, "--breakline-shift", "1"])).succeeds();
    let failed = scene.verify(&roads, &["--footprints", &houses]);
    assert_eq!(failed.code, Some(1), "{failed:#?}");

    let refused = |options: &[&str], expected: &[&str]| {
        terrabite(scene.command("simplify", options))
            .fails(if expected[0].starts_with("--") { 2 } else { 1 }, expected);
    };
    refused(
        &["--footprints", &roads],
        &[
            "roads.geojson: layer roads: expected a polygon or polygons in feature 0, found LINESTRING",
            "--footprints-layer",
        ],
    );
    let far =
        scene.geometries("far.geojson", vec![json!({"type": "Polygon", "coordinates": [square(900.0, 900.0, 9.0)]})]);
    refused(
        &["--footprints", &far],
        &["far.geojson: expected footprints on the raster, found none of 1", "--footprints"],
    );
    terrabite(scene.command("verify", &["--footprints", &far])).fails(1, &["far.geojson: expected footprints on"]);
    refused(&["--footprints", &houses, "--breakline-z", "line"], &["--breakline-z line requires --breaklines"]);
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
    scene.simplify(&lines, &[]).succeeds();
    for far_off in [scene.simplify(&far, &[]), scene.verify(&far, &[])] {
        far_off.fails(1, &["far.geojson: expected breaklines on the raster, found none of 1", "ogr2ogr"]);
    }
    let curve = scene
        .folder
        .with("curve.csv", "id,WKT\n1,\"CIRCULARSTRING (500020 5199970, 500100 5199900, 500300 5199800)\"\n");
    scene.simplify(&curve, &[]).fails(1, &["curve.csv", "found CIRCULARSTRING", "-nlt CONVERT_TO_LINEAR"]);
    let both =
        json!({"type": "GeometryCollection", "geometries": [{"type": "LineString", "coordinates": [[0, 0], [1, 1]]}]});
    let both = scene.geometries("both.geojson", vec![both]);
    scene.simplify(&both, &[]).fails(1, &["both.geojson", "found GEOMETRYCOLLECTION", "-explodecollections"]);
    scene.simplify(&lines, &["--breaklines-layer", "sea"]).fails(1, &["expected layer sea, found roads"]);
    scene.simplify(&lines, &["--breakline-shift", "99"]).fails(2, &["from 0 to 16"]);
    scene.simplify(&lines, &["--engine", "hitting-set"]).fails(2, &["--breaklines", "squares take no given edges"]);
    scene.verify(&lines, &["--trim", "2"]).fails(2, &["--breaklines cannot be combined with --trim"]);
    terrabite(scene.command("simplify", &["--breakline-shift", "1"])).fails(2, &["--breaklines"]);
}

/// A road across ground that is rough at every other sample: where triangles end is decided between samples.
#[test]
fn straying_is_limited_but_near_lines() {
    let scene = Scene::new();
    let rough = |c: usize, r: usize| if (c * 7 + r * 5) % 11 < 2 { 60.0 } else { (c + r) as f64 };
    let dem = Dem::new(40, 30).on_the_map().heights(rough).write(&scene.folder, "rough.tif");
    let (lines, tin) = (scene.layer("roads.geojson", &LINES), scene.folder.at("rough.ply"));
    let usual = ["--max-error", "8", "--breaklines", &lines, "--json"];
    let simplify = |options: &[&str]| {
        terrabite([&["simplify", &dem, &tin, "--overwrite"], &usual[..], options].concat()).succeeds().json()
    };
    let verify =
        |options: &[&str]| terrabite([&["verify", &dem, &tin], &usual[..], options].concat()).json()["passed"].clone();
    assert_eq!(simplify(&["--quality", "none"])["max_stray"], Value::Null);
    assert_eq!((verify(&[]), verify(&["--max-stray", "1"])), (json!(true), json!(false)));
    for (options, limit) in [(&["--quality", "none", "--max-stray", "1"][..], 1.0), (&[], 1.5)] {
        assert_eq!(simplify(options)["max_stray"], json!(limit));
        assert_eq!(verify(&["--max-stray", &limit.to_string()]), json!(true), "{options:?}");
    }
}
