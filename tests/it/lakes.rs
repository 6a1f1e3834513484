//! `--lake-polygons`: polygons that are level in the written mesh, and what `verify` says of them.

use serde_json::json;

use crate::breaklines::{LINES, Scene};
use crate::util::terrabite;

#[test]
fn lakes_are_level_and_islands_are_not() {
    let scene = Scene::new();
    let (lakes, roads) = (scene.lakes(), scene.layer("roads.geojson", &LINES));
    let mut bytes = Vec::new();
    for (z, options, threads) in [
        ("min", &[][..], "1"),
        ("min", &[], "3"),
        ("median", &["--quality", "none"], "2"),
        ("field:level", &["--heights", "fitted"], "2"),
        ("field:level", &["--precision", "float"], "2"),
        ("field:level", &["--breaklines", &roads], "2"),
        ("field:level", &["--breaklines", &roads, "--breakline-z", "line"], "2"),
    ] {
        let of_lakes = ["--lake-polygons", &lakes, "--lake-z", z];
        let made = [&["--tile", "16", "--overwrite", "--threads", threads], &of_lakes[..], options].concat();
        let report = terrabite(scene.command("simplify", &made)).succeeds().json();
        assert_eq!((&report["lakes"]["z"], &report["lakes"]["lines"]), (&json!(z), &json!(3)), "{report}");
        let inside = report["samples_in_lakes"].as_u64().unwrap();
        assert!((15 * 15 - 4 * 4 + 6 * 12..16 * 16 + 8 * 13).contains(&inside), "{inside}");
        let lines: Vec<&str> = options.iter().copied().skip_while(|word| *word != "--breaklines").collect();
        let verdict = terrabite(scene.command("verify", &[&of_lakes[..], &lines].concat())).succeeds().json();
        assert_eq!(
            (&verdict["breaklines"]["lakes"], &verdict["breaklines"]["not_level"]["count"]),
            (&json!(2), &json!(0))
        );
        assert_eq!(report["beside_lines"], verdict["beside_lines"]);
        assert!(report["shape"].is_null() || report["shape"]["overshoot_max"].as_f64() < Some(1e3), "{report}");
        bytes.push(scene.written());
    }
    assert!(bytes[0] == bytes[1], "other bytes with other threads");
    let header = String::from_utf8_lossy(&bytes[0][..1000]).to_string();
    assert!(header.contains("comment lake polygons lakes.geojson\ncomment lake z min\n"), "{header}");
    terrabite(scene.command("simplify", &["--overwrite"])).succeeds();
    let failed = terrabite(scene.command("verify", &["--lake-polygons", &lakes]));
    assert_eq!(failed.code, Some(1), "{failed:#?}");
    assert!(failed.json()["failures"].to_string().contains("vertices in lakes are not level with it"));
}

#[test]
fn lakes_that_cannot_be_level_are_refused_by_name() {
    let scene = Scene::new();
    let (lakes, roads) = (scene.lakes(), scene.layer("roads.geojson", &LINES));
    let refused = |options: &[&str], code: i32, expected: &[&str]| {
        for name in ["simplify", "verify"] {
            let overwrite = if name == "simplify" { &["--overwrite"][..] } else { &[] };
            terrabite(scene.command(name, &[options, overwrite].concat())).fails(code, expected);
        }
    };
    terrabite(scene.command("simplify", &[])).succeeds();
    let with = |z: &'static str| ["--lake-polygons", lakes.as_str(), "--lake-z", z];
    refused(
        &with("field:depth"),
        1,
        &[
            "lakes.geojson: layer lakes: expected a number in field depth of feature 0, found no such field among ",
            "--lake-z",
        ],
    );
    refused(&with("field:name"), 1, &["in field name"]);
    refused(&with("mean"), 2, &["expected min, median or field:NAME"]);
    refused(&["--lake-polygons", &roads], 1, &["roads.geojson", "found LINESTRING", "--lake-polygons-layer"]);
    terrabite(scene.command("simplify", &["--lake-z", "min"])).fails(2, &["--lake-polygons"]);
    let at = |c: f64, r: f64| [500_000.0 + (c + 0.5) * 10.0, 5_200_000.0 - (r + 0.5) * 10.0];
    let pond =
        |c: f64| json!({"type": "Polygon", "coordinates": [[at(c, 3.0), at(c + 6.0, 3.0), at(c, 9.0), at(c, 3.0)]]});
    let both = scene.geometries("both.geojson", vec![pond(3.0), pond(5.5)]);
    refused(
        &["--lake-polygons", &both],
        1,
        &["both.geojson: expected lakes apart from each other, found features 0 and 1 that overlap"],
    );
    // A dam at seven metres through a lake at another level.
    let dam = ["--breaklines", &roads, "--breakline-z", "line"];
    let expected = ["expected one height at column", "feature 0 of the lakes", "of the breaklines"];
    terrabite(scene.command(
        "simplify",
        &[&dam[..], &["--lake-polygons", &scene.geometries("pond.geojson", vec![pond(2.0)]), "--overwrite"]].concat(),
    ))
    .fails(1, &expected);
}
