//! `verify --report` and `simplify --report`: pages whose figures are those of the run.

use std::fs;
use std::process::Command;

use gdal::Dataset;
use serde_json::Value;

use crate::util::{Dem, Folder, Kind, flat, hills, terrabite};

/// The JSON inside of a page.
fn embedded(page: &str) -> Value {
    let (_, after) = page.split_once("<script type=\"application/json\" id=\"report\">").unwrap();
    serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
}

/// What is to be seen of a page but for the lines that say when and how it was made.
fn undated(page: &str) -> String {
    let (seen, _) = page.split_once("<h2>For programs</h2>").unwrap();
    let is_dated = |line: &&str| line.contains("\">Command<") || line.contains("\">Made<");
    let lines: Vec<&str> = seen.lines().filter(|line| !is_dated(line)).collect();
    assert_eq!(lines.len() + 2, seen.lines().count());
    lines.join("\n")
}

fn with_gaps(column: usize, row: usize) -> f64 {
    let is_missing = (40..56).contains(&column) && (10..18).contains(&row) || (column, row) == (50, 40);
    if is_missing { -9999.0 } else { hills(column, row) }
}

/// A raster with voids and a mesh of it.
fn scene(folder: &Folder) -> (String, String) {
    let dem = Dem::new(700, 70).kind(Kind::Float64).nodata(-9999.0).heights(with_gaps).on_the_map();
    let (dem, tin) = (dem.write(folder, "dem.tif"), folder.at("tin.ply"));
    terrabite(["simplify", &dem, &tin, "--max-error", "4", "--tile", "64"]).succeeds();
    (dem, tin)
}

fn sha256(path: &str) -> String {
    let said = Command::new("sha256sum").arg(path).output().unwrap().stdout;
    String::from_utf8(said).unwrap().split(' ').next().unwrap().to_string()
}

/// The text of the element that begins so.
fn element<'p>(page: &'p str, start: &str) -> &'p str {
    page.split_once(start).unwrap().1.split_once("</script>").unwrap().0
}

/// Nothing is fetched, and nothing runs but the program of the view.
fn assert_stands_alone(page: &str) {
    let (whole, program) = (page, element(page, "<script type=\"module\">"));
    let page = &page.replace(program, "");
    for (attribute, allowed) in [("href=\"", &["#", "data:image/png;base64,", "data:,"][..]), ("src=\"", &[])] {
        for (at, _) in page.match_indices(attribute) {
            let value = &page[at + attribute.len()..];
            assert!(allowed.iter().any(|start| value.starts_with(start)), "{}", &value[..40]);
        }
    }
    assert!(!page.contains("url(") && !page.contains("@import") && page.matches("<script").count() == 4);
    assert!(whole.len() < 3_000_000, "{} bytes", whole.len());
}

#[test]
fn a_page_says_what_the_run_found() {
    let folder = Folder::new();
    let (dem, tin) = scene(&folder);
    let judged = |tolerance: &str, page: &str, threads: &str| {
        let page = folder.at(page);
        let run = ["verify", &dem, &tin, "--max-error", tolerance, "--report", &page, "--json", "--threads", threads];
        let run = terrabite(run);
        (run.code, run.json(), fs::read_to_string(page).unwrap())
    };
    let (code, mut report, page) = judged("4", "one.html", "1");
    assert_eq!(code, Some(0));
    assert_stands_alone(&page);
    for words in ["<b>PASS</b>", "EPSG:32633", &sha256(&dem), &sha256(&tin), "not said by the raster", "--max-error 4"]
    {
        assert!(page.contains(words), "{words}");
    }
    let mut inside = embedded(&page);
    assert_eq!(inside["command"][1], "verify");
    for value in [&mut inside, &mut report] {
        ["command", "version"].iter().for_each(|key| drop(value.as_object_mut().unwrap().remove(*key)));
    }
    assert_eq!(inside, report);
    let worst = report["worst"]["error"].as_f64().unwrap();
    assert!(page.contains(&format!(">{worst}<")), "the largest error with all its digits");
    assert!(undated(&page) == undated(&judged("4", "two.html", "3").2), "whatever the threads");

    let (code, report, page) = judged("3", "bad.html", "2");
    assert_eq!(code, Some(1));
    let failure = report["failures"][0].as_str().unwrap();
    assert!(page.contains("<b>FAIL</b>") && page.contains(&format!("<li>{failure}</li>")), "{failure}");
    assert_stands_alone(&page);
}

/// Every figure again, from the raster and the raster of errors.
#[test]
fn figures_are_those_of_all_samples() {
    let folder = Folder::new();
    let (dem, tin) = scene(&folder);
    for tolerance in [4.0, 2.5] {
        let (page, raster) = (folder.at("qa.html"), folder.at("e.tif"));
        let text = tolerance.to_string();
        let run = ["verify", &dem, &tin, "--max-error", &text, "--report", &page, "--error-raster", &raster];
        let report = terrabite(run.iter().chain(&["--json", "--overwrite"])).json();
        let survey = &report["survey"];
        let errors = Dataset::open(&raster).unwrap();
        let errors = errors.rasterband(1).unwrap().read_as::<f64>((0, 0), (700, 70), (700, 70), None).unwrap();
        let errors = errors.data();
        let at = |column: usize, row: usize| errors[row * 700 + column];
        let mut distances: Vec<f64> = errors.iter().filter(|e| !e.is_nan()).map(|e| e.abs()).collect();
        distances.sort_by(f64::total_cmp);
        let count = distances.len();
        assert_eq!(survey["measured"].as_u64(), Some(count as u64));
        for (name, share) in [("p50", 0.5), ("p90", 0.9), ("p95", 0.95), ("p99", 0.99), ("p100", 1.0)] {
            let (found, exact) =
                (survey[name].as_f64().unwrap(), distances[(share * count as f64).ceil() as usize - 1]);
            let most = if exact <= tolerance { exact + tolerance / 999.0 } else { exact * (1.0 + 1.0 / 32.0) };
            assert!(exact <= found + 1e-6 && found <= most, "{name}: {found}, {exact}");
        }
        let mean = errors.iter().filter(|e| !e.is_nan()).sum::<f64>() / count as f64;
        assert!((mean - survey["mean_error"].as_f64().unwrap()).abs() < 1e-6);
        // What is at it but for rounding may count or not.
        let [most, least] =
            [-1e-6, 1e-6].map(|off| distances.iter().filter(|d| **d > 0.9 * tolerance + off).count() as u64);
        assert!((least..=most).contains(&survey["above_nine_tenths"].as_u64().unwrap()));
        let signed: Vec<u64> =
            survey["signed_errors"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect();
        let of = |test: &dyn Fn(f64) -> bool| errors.iter().filter(|e| test(**e)).count() as u64;
        assert_eq!(signed.iter().sum::<u64>(), count as u64);
        assert_eq!((signed[0], signed[41]), (of(&|e| e < -tolerance), of(&|e| e > tolerance)));
        assert!(signed[1..21].iter().sum::<u64>().abs_diff(of(&|e| (-tolerance..-1e-9).contains(&e))) <= 1);

        // Classes by the slope of the samples beside and above; the first row has none above.
        let height = |column: isize, row: isize| -> Option<f64> {
            let there = (0..700).contains(&column) && (0..70).contains(&row);
            there.then(|| with_gaps(column as usize, row as usize)).filter(|h| *h != -9999.0)
        };
        let class = |column: isize, row: isize| -> Option<usize> {
            let here = height(column, row)?;
            let across = match (height(column - 1, row), height(column + 1, row)) {
                (Some(left), Some(right)) => (right - left) / 2.0,
                (Some(left), None) => here - left,
                (None, Some(right)) => right - here,
                (None, None) => return None,
            };
            let down = here - if row == 0 { here } else { height(column, row - 1)? };
            let degrees = (across / 10.0).hypot(down / 10.0).atan().to_degrees();
            [2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0].iter().position(|from| degrees < *from).or(Some(7))
        };
        let mut expected = [(0u64, 0.0f64, 0.0f64, 0u64); 8];
        for (column, row) in (0..70).flat_map(|row| (0..700).map(move |column| (column, row))) {
            let error = at(column, row).abs();
            if let (false, Some(class)) = (error.is_nan(), class(column as isize, row as isize)) {
                let (samples, max, squares, above) = &mut expected[class];
                (*samples, *max, *squares) = (*samples + 1, max.max(error), *squares + error * error);
                *above += u64::from(error > tolerance);
            }
        }
        for (found, (samples, max, squares, above)) in survey["slopes"].as_array().unwrap().iter().zip(expected) {
            assert_eq!((found["samples"].as_u64(), found["above_tolerance"].as_u64()), (Some(samples), Some(above)));
            let rms = (squares / samples.max(1) as f64).sqrt();
            let [found_max, found_rms] = ["max", "rms"].map(|name| found[name].as_f64().unwrap());
            assert!((-1e-6..tolerance / 999.0).contains(&(found_max - max)), "{found}: {max}");
            assert!((found_rms - rms).abs() < tolerance / 1000.0, "{found}: {rms}");
        }
        let angles = survey["smallest_angles"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).sum::<u64>();
        assert_eq!(Some(angles), report["triangles"].as_u64());
    }
}

#[test]
fn names_are_no_markup_and_what_is_read_is_not_replaced() {
    let folder = Folder::new();
    let dem = Dem::new(9, 9).heights(|_, _| 0.0).write(&folder, "<b>a&'.tif");
    let tin = folder.with("tin.ply", flat(9, 9, 0.0));
    let page = folder.at("qa.html");
    let judge = |page: &str, more: &[&str]| {
        terrabite(["verify", &dem, &tin, "--max-error", "1", "--report", page].iter().chain(more))
    };
    judge(&page, &[]).succeeds();
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("&lt;b&gt;a&amp;&apos;.tif") && !text.contains("<b>a"));
    judge(&page, &[]).fails(1, &["qa.html", "--overwrite"]);
    judge(&tin, &["--overwrite"]).fails(1, &["tin.ply", "input"]);
    judge(&page, &["--overwrite", "--error-raster", &page]).fails(2, &["--error-raster"]);
    judge(&folder.at("none/qa.html"), &[]).fails(1, &["none"]);
    let lines = folder.with("lines.geojson", r#"{"type": "LineString", "coordinates": [[1, -1], [5, -5]]}"#);
    judge(&lines, &["--overwrite", "--breaklines", &lines]).fails(1, &["lines.geojson", "input"]);
    assert_eq!(fs::read_to_string(&page).unwrap(), text);
}

#[test]
fn a_run_has_a_page_too() {
    let folder = Folder::new();
    let dem = Dem::new(80, 60).on_the_map().write(&folder, "dem.tif");
    let (tin, page) = (folder.at("tin.ply"), folder.at("tin.html"));
    let make = |page: &str, more: &[&str]| {
        let run = ["simplify", &dem, &tin, "--max-error", "3", "--report", page, "--json"];
        terrabite(run.iter().chain(more))
    };
    let report = make(&page, &[]).succeeds().json();
    let text = fs::read_to_string(&page).unwrap();
    assert_stands_alone(&text);
    assert_eq!(embedded(&text)["error"], report["error"]);
    assert!(text.contains(&format!(">{}<br>", report["error"]["max"].as_f64().unwrap())));
    for words in ["<b>PASS</b>", &sha256(&tin), "verify --report", "EPSG:32633"] {
        assert!(text.contains(words), "{words}");
    }
    make(&tin, &["--overwrite"]).fails(2, &["tin.ply"]);
    make(&dem, &["--overwrite"]).fails(1, &["dem.tif", "input"]);
    let names = folder.names();
    make(&page, &["--max-triangles", "20", "--overwrite"]);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains("<b>FAIL</b>") && text.contains("before it reached the tolerance of 3"), "a budget ended it");
    assert_eq!(folder.names(), names);
}

/// The mesh inside of a page, as a file.
fn mesh_of(page: &str, folder: &Folder) -> String {
    let text = folder.with("view.txt", element(page, "<script type=\"application/octet-stream\" id=\"view-mesh\">"));
    let decoded = Command::new("base64").args(["-d", &text]).output().unwrap();
    assert!(decoded.status.success());
    folder.with("view.glb", decoded.stdout)
}

fn settings(page: &str) -> Value {
    serde_json::from_str(element(page, "<script type=\"application/json\" id=\"view-settings\">")).unwrap()
}

#[test]
fn the_mesh_in_a_page_is_the_mesh() {
    let folder = Folder::new();
    let (dem, tin) = scene(&folder);
    let (judged, made) = (folder.at("judged.html"), folder.at("made.html"));
    let report = terrabite(["verify", &dem, &tin, "--max-error", "4", "--report", &judged, "--json"]).json();
    let options = ["--max-error", "4", "--tile", "64", "--overwrite", "--report", &made];
    terrabite(["simplify", &dem, &tin].iter().chain(&options)).succeeds();
    for page in [judged, made] {
        let page = fs::read_to_string(page).unwrap();
        let shown = settings(&page);
        assert_eq!(
            (&shown["triangles"], &shown["of"], &shown["isCopy"]),
            (&report["triangles"], &report["triangles"], &false.into())
        );
        // What single precision loses of heights is far below a thousandth.
        let view = mesh_of(&page, &folder);
        let again = terrabite(["verify", &dem, &view, "--max-error", "4.001", "--json"]).succeeds().json();
        assert_eq!((&again["triangles"], &again["vertices"]), (&report["triangles"], &report["vertices"]));
    }
}

#[test]
fn a_large_mesh_has_a_copy_in_its_page() {
    let folder = Folder::new();
    let rough = |column: usize, row: usize| {
        hills(column, row) + ((31 * column * column + 17 * row * row + 7 * column * row) % 97) as f64
    };
    let dem = Dem::new(380, 340).kind(Kind::Float64).heights(rough).on_the_map().write(&folder, "dem.tif");
    let (tin, made, judged) = (folder.at("tin.ply"), folder.at("made.html"), folder.at("judged.html"));
    let run = ["simplify", &dem, &tin, "--max-error", "0", "--quality", "none", "--report", &made, "--json"];
    let report = terrabite(run).succeeds().json();
    assert!(report["triangles"].as_u64().unwrap() > 200_000);
    terrabite(["verify", &dem, &tin, "--max-error", "0", "--report", &judged, "--quiet"]).succeeds();
    for page in [made, judged] {
        let page = fs::read_to_string(page).unwrap();
        assert_stands_alone(&page);
        let shown = settings(&page);
        assert_eq!((&shown["of"], &shown["isCopy"]), (&report["triangles"], &true.into()));
        let triangles = shown["triangles"].as_u64().unwrap();
        assert!((20_000..=100_000).contains(&triangles), "{triangles}");
        assert!(page.contains("Not certified"));
        // A mesh without gaps over the ground of the raster, if not within its tolerance.
        let verdict = terrabite(["verify", &dem, &mesh_of(&page, &folder), "--max-error", "1", "--json"]).json();
        assert_eq!(verdict["triangles"].as_u64(), Some(triangles));
        assert_eq!(verdict["passed"], false);
    }
}

#[test]
fn with_weights_shares_are_those_of_error_times_weight() {
    let folder = Folder::new();
    let (dem, tin) = scene(&folder);
    let weights = Dem::new(700, 70).kind(Kind::Float32).heights(|column, _| (column % 3) as f64).on_the_map();
    let (weights, page) = (weights.write(&folder, "weights.tif"), folder.at("qa.html"));
    let run = ["verify", &dem, &tin, "--max-error", "6", "--importance", &weights, "--report", &page, "--json"];
    let report = terrabite(run).json();
    let number = |path: &str| report.pointer(path).unwrap().as_f64().unwrap();
    assert_eq!(number("/survey/p100"), number("/worst_by_importance/weighted_error"));
    assert!(number("/survey/p100") > number("/worst/error"));
    let signed = report["survey"]["signed_errors"].as_array().unwrap();
    let beyond = signed[0].as_u64().unwrap() + signed[41].as_u64().unwrap();
    assert_eq!((beyond, beyond > 0), (number("/above_tolerance/count") as u64, true));
    // A third of the samples weighs nothing.
    let level = signed[21].as_u64().unwrap() as f64;
    assert!(level > number("/survey/measured") / 3.0 - 700.0, "{level}");
}
