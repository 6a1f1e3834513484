//! `--cutline`: the mesh of what is inside polygons.

use std::fs;

use serde_json::Value;

use crate::util::{Dem, Folder, Kind, hills, terrabite, terrabite_with_fault, without_comments};

/// A polygon and its hole, in columns and rows of samples: no side is level or upright.
const OUTER: [(f64, f64); 4] = [(12.3, 5.1), (101.7, 20.4), (90.2, 80.9), (5.6, 70.3)];
const HOLE: [(f64, f64); 3] = [(40.2, 30.1), (60.9, 35.7), (50.5, 55.2)];

fn crosses_left(ring: &[(f64, f64)], column: f64, row: f64) -> usize {
    let sides = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossed = |(a, b): &(&(f64, f64), &(f64, f64))| {
        (a.1 <= row) != (b.1 <= row) && a.0 + (b.0 - a.0) * (row - a.1) / (b.1 - a.1) <= column
    };
    sides.filter(crossed).count()
}

fn is_inside(column: usize, row: usize) -> bool {
    let (column, row) = (column as f64, row as f64);
    (crosses_left(&OUTER, column, row) + crosses_left(&HOLE, column, row)) % 2 == 1
}

/// What the polygon leaves, burned in by hand.
fn burned(column: usize, row: usize) -> f64 {
    if is_inside(column, row) { hills(column, row) } else { -32768.0 }
}

fn dem() -> Dem {
    Dem::new(120, 90).on_the_map()
}

fn ring(places: &[(f64, f64)]) -> String {
    let at = |&(c, r): &(f64, f64)| format!("[{}, {}]", 500_005.0 + c * 10.0, 5_199_995.0 - r * 10.0);
    let places: Vec<String> = places.iter().chain(&places[..1]).map(at).collect();
    format!("[{}]", places.join(", "))
}

fn layer(folder: &Folder, name: &str, kind: &str, coordinates: &str) -> String {
    let crs = r#"{"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::32633"}}"#;
    let geometry = format!(r#"{{"type": "{kind}", "coordinates": {coordinates}}}"#);
    let feature = format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {geometry}}}"#);
    let text = format!(r#"{{"type": "FeatureCollection", "name": "lake", "crs": {crs}, "features": [{feature}]}}"#);
    folder.with(name, text)
}

fn polygons(folder: &Folder) -> String {
    layer(folder, "lake.geojson", "Polygon", &format!("[{}, {}]", ring(&OUTER), ring(&HOLE)))
}

fn report(dem: &str, tin: &str, options: &[&str]) -> Value {
    let command = ["simplify", dem, tin, "--max-error", "3", "--overwrite", "--json"];
    terrabite(command.iter().chain(options)).succeeds().json()
}

/// As if the raster had no heights there, whatever the tiles and however samples are read.
#[test]
fn what_is_outside_is_as_nodata() {
    let folder = Folder::new();
    let (cutline, tin) = (polygons(&folder), folder.at("tin.ply"));
    let whole = dem().write(&folder, "dem.tif");
    let burned = dem().heights(burned).nodata(-32768.0).write(&folder, "burned.tif");
    let missing = (0..120 * 90).filter(|i| !is_inside(i % 120, i / 120)).count() as u64;
    for tile in ["16", "23", "64", "0"] {
        report(&burned, &tin, &["--tile", tile]);
        let expected = without_comments(&tin);
        for access in ["in-place", "windows", "decode"] {
            let told = report(&whole, &tin, &["--tile", tile, "--cutline", &cutline, "--access", access]);
            assert!(without_comments(&tin) == expected, "tiles of {tile}, {access}");
            assert_eq!(told["missing_samples"], missing);
            assert_eq!(told["cutline"], serde_json::json!({"file": cutline, "polygons": 1, "vertices": 7}));
        }
        let verify = ["verify", &whole, &tin, "--max-error", "3"];
        terrabite(verify.iter().chain(&["--cutline", &cutline])).succeeds();
        assert_eq!(terrabite(verify).code, Some(1));
    }
}

/// An image has no heights, and is cut all the same.
#[test]
fn images_are_cut_too() {
    let folder = Folder::new();
    let image = dem().kind(Kind::Byte).bands(3).write(&folder, "image.tif");
    let (cutline, tin) = (polygons(&folder), folder.at("tin.ply"));
    let missing = (0..120 * 90).filter(|i| !is_inside(i % 120, i / 120)).count() as u64;
    let told = report(&image, &tin, &["--image", "--cutline", &cutline, "--tile", "32"]);
    assert_eq!(told["missing_samples"], missing);
    let verify = ["verify", &image, &tin, "--max-error", "3", "--image"];
    terrabite(verify.iter().chain(&["--cutline", &cutline])).succeeds();
    assert_eq!(terrabite(verify).code, Some(1));
}

/// Budgets and a root mean square are for what is inside.
#[test]
fn goals_are_for_what_is_inside() {
    let folder = Folder::new();
    let (cutline, tin, dem) = (polygons(&folder), folder.at("tin.ply"), dem().write(&folder, "dem.tif"));
    let inside = (0..120 * 90).filter(|i| is_inside(i % 120, i / 120)).count() as u64;
    for goal in [["--max-points", "900"], ["--max-triangles", "1500"], ["--max-rms", "0.8"]] {
        let command = ["simplify", &dem, &tin, "--overwrite", "--json", "--tile", "32", "--cutline", &cutline];
        let told = terrabite(command.iter().chain(&goal)).succeeds().json();
        let (samples, most) = (told["samples"].as_u64().unwrap(), told["error"]["max"].as_f64().unwrap() + 1e-9);
        assert!(samples <= inside && samples + 20 >= inside, "{samples} of {inside}");
        match goal[0] {
            "--max-points" => assert!((700..=900).contains(&told["vertices"].as_u64().unwrap()), "{told}"),
            "--max-triangles" => assert!((1300..=1500).contains(&told["triangles"].as_u64().unwrap()), "{told}"),
            _ => assert!(told["error"]["rms"].as_f64().unwrap() <= 0.8, "{told}"),
        }
        let verify = ["verify", &dem, &tin, "--max-error", &most.to_string(), "--cutline", &cutline];
        terrabite(verify).succeeds();
    }
}

#[test]
fn both_engines_and_any_number_of_threads_write_the_same() {
    let folder = Folder::new();
    let (cutline, tin, dem) = (polygons(&folder), folder.at("tin.ply"), dem().write(&folder, "dem.tif"));
    for options in [["--engine", "greedy-cuts"], ["--engine", "greedy-insertion"], ["--heights", "fitted"]] {
        let run = |threads| {
            let all = ["--tile", "16", "--cutline", &cutline, "--threads", threads];
            report(&dem, &tin, &[&all[..], &options].concat());
            fs::read(&tin).unwrap()
        };
        let one = run("1");
        assert!(one == run("2") && one == run("5"), "{options:?}");
        terrabite(["verify", &dem, &tin, "--max-error", "3", "--cutline", &cutline]).succeeds();
    }
}

#[test]
fn what_is_written_tells_of_it() {
    let folder = Folder::new();
    let (cutline, tin, dem) = (polygons(&folder), folder.at("tin.ply"), dem().write(&folder, "dem.tif"));
    let command = ["simplify", &dem, &tin, "--max-error", "3", "--cutline", &cutline, "--cutline-layer", "lake"];
    let told = terrabite(command).succeeds().out;
    assert!(told.contains("1 polygon with 7 vertices, of ") && told.contains("missing"), "{told}");
    let header = String::from_utf8_lossy(&fs::read(&tin).unwrap()[..500]).into_owned();
    assert!(header.contains("comment cutline lake.geojson\ncomment cutline layer lake\n"), "{header}");
}

/// Windows move samples, not polygons.
#[test]
fn beside_a_window_weights_and_channels() {
    let folder = Folder::new();
    let (cutline, tin) = (polygons(&folder), folder.at("tin.ply"));
    let dem = dem().bands(2).kind(Kind::Float32).write(&folder, "dem.tif");
    let weights = Dem::new(120, 90).on_the_map().kind(Kind::Float32).heights(|c, _| f64::from(1 + u8::from(c > 60)));
    let weights = weights.write(&folder, "weights.tif");
    let of = |window: [usize; 4]| {
        let [left, top, width, height] = window;
        (top..top + height)
            .flat_map(|r| (left..left + width).map(move |c| (c, r)))
            .filter(|&(c, r)| !is_inside(c, r))
            .count()
    };
    for (options, missing) in [
        (&["--window", "30,10,70,60"][..], of([30, 10, 70, 60])),
        (&["--importance", &weights], of([0, 0, 120, 90])),
        (&["--attributes", "2"], of([0, 0, 120, 90])),
    ] {
        let options = [options, &["--cutline", &cutline]].concat();
        let told = report(&dem, &tin, &[&options[..], &["--tile", "32"]].concat());
        assert_eq!(told["missing_samples"], missing, "{options:?}");
        terrabite(["verify", &dem, &tin, "--max-error", "3"].iter().chain(&options)).succeeds();
    }
}

#[test]
fn heights_that_are_none_do_not_matter_outside() {
    fn infinite(column: usize, row: usize) -> f64 {
        if is_inside(column, row) { hills(column, row) } else { f64::INFINITY }
    }
    let folder = Folder::new();
    let (cutline, tin) = (polygons(&folder), folder.at("tin.ply"));
    let dem = dem().kind(Kind::Float32).heights(infinite).write(&folder, "dem.tif");
    report(&dem, &tin, &["--tile", "32", "--cutline", &cutline]);
    terrabite(["verify", &dem, &tin, "--max-error", "3", "--cutline", &cutline]).succeeds();
    terrabite(["verify", &dem, &tin, "--max-error", "3"]).fails(1, &["dem.tif", "inf"]);
}

#[test]
fn a_picture_leaves_out_what_is_outside() {
    let folder = Folder::new();
    let (cutline, tin, dem) = (polygons(&folder), folder.at("tin.ply"), dem().write(&folder, "dem.tif"));
    report(&dem, &tin, &["--cutline", &cutline]);
    let draw = |name: &str, options: &[&str]| {
        let picture = folder.at(name);
        terrabite(["preview", &dem, &tin, &picture, "--mode", "error"].iter().chain(options)).succeeds();
        fs::read(picture).unwrap()
    };
    assert!(draw("cut.png", &["--cutline", &cutline]) != draw("whole.png", &[]));
    let none = folder.at("none.gpkg");
    let picture = folder.at("other.png");
    terrabite(["preview", &dem, &tin, &picture, "--cutline", &none]).fails(1, &["none.gpkg", "--cutline"]);
    let over = ["preview", &dem, &tin, &cutline, "--overwrite", "--cutline", &cutline, "--format", "png"];
    terrabite(over).fails(1, &["lake.geojson"]);
}

#[test]
fn a_run_that_was_killed_continues_with_the_same_polygons_only() {
    let folder = Folder::new();
    let (cutline, tin, work) = (polygons(&folder), folder.at("tin.ply"), folder.at("work"));
    let other = layer(&folder, "other.geojson", "Polygon", &format!("[{}]", ring(&OUTER)));
    let dem = dem().write(&folder, "dem.tif");
    report(&dem, &tin, &["--tile", "32", "--cutline", &cutline]);
    let expected = fs::read(&tin).unwrap();
    fs::remove_file(&tin).unwrap();
    let plain = ["simplify", &dem, &tin, "--max-error", "3", "--tile", "32", "--work-dir", &work];
    let command = |cutline| plain.iter().chain(&["--cutline", cutline]).map(ToString::to_string).collect::<Vec<_>>();
    let killed = terrabite_with_fault("kill:vertices:1", command(&cutline));
    assert_eq!(killed.code, None, "{killed:#?}");
    terrabite(command(&other)).fails(1, &["another job", "--cutline: polygons"]);
    terrabite(plain).fails(1, &["another job", "--cutline: polygons", "not given now"]);
    terrabite(command(&cutline)).succeeds();
    assert!(fs::read(&tin).unwrap() == expected);
}

#[test]
fn what_cannot_be_used_is_refused_by_name() {
    let folder = Folder::new();
    let dem = dem().write(&folder, "dem.tif");
    let far: Vec<(f64, f64)> = OUTER.iter().map(|(c, r)| (c + 500.0, *r)).collect();
    let far = layer(&folder, "far.geojson", "Polygon", &format!("[{}]", ring(&far)));
    let points = layer(&folder, "points.geojson", "Point", "[500000, 5199000]");
    let empty = folder.with("empty.geojson", r#"{"type": "FeatureCollection", "features": []}"#);
    let good = polygons(&folder);
    let before = folder.names();
    let refuses = |cutline: &str, options: &[&str], code, words: &[&str]| {
        let tin = folder.at("tin.ply");
        let command = ["simplify", &dem, &tin, "--max-error", "3", "--cutline", cutline];
        terrabite(command.iter().chain(options)).fails(code, words);
        assert_eq!(folder.names(), before);
    };
    refuses(&dem, &[], 1, &["dem.tif: cannot be opened as a layer of polygons", "--cutline"]);
    refuses(&points, &[], 1, &["points.geojson", "expected a polygon", "found POINT", "--cutline-layer"]);
    refuses(&empty, &[], 1, &["empty.geojson", "expected polygons, found none"]);
    refuses(&good, &["--cutline-layer", "sea"], 1, &["expected layer sea, found lake", "--cutline-layer"]);
    refuses(&far, &[], 1, &["dem.tif", "no ground", "--cutline", "far.geojson"]);
    let (tin, work) = (folder.at("tin.ply"), folder.at("work"));
    let kept = ["simplify", &dem, &tin, "--max-error", "3", "--cutline", &far, "--work-dir", &work];
    let kept = terrabite(kept).fails(1, &["no ground", "--cutline", "far.geojson"]);
    assert!(!kept.err.contains("continues"), "{kept:?}");
    let verify = ["verify", &dem, &tin, "--max-error", "3", "--cutline", &points];
    terrabite(verify).fails(1, &["points.geojson", "found POINT"]);
}

/// Mars has no way to Earth.
#[test]
fn a_crs_without_a_way_to_the_rasters_is_refused() {
    let folder = Folder::new();
    let dem = dem().write(&folder, "dem.tif");
    let text = fs::read_to_string(polygons(&folder)).unwrap();
    let mars =
        folder.with("mars.geojson", text.replace("urn:ogc:def:crs:EPSG::32633", "urn:ogc:def:crs:IAU_2015::49900"));
    let tin = folder.at("tin.ply");
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "3", "--cutline", &mars]);
    run.fails(1, &["mars.geojson", "--cutline"]);
}
