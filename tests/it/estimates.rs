//! What `--dry-run` and the check of the disks go by, against what is written: within a factor of two.

use crate::util::{Dem, Folder, hills, terrabite, terrabite_with_fault};

/// Hills with rough ground on them, so that budgets are spent.
fn ground(column: usize, row: usize) -> f64 {
    hills(column, row) * 20.0 + ((column * column * 31 + row * row * 17 + column * row * 7) % 101) as f64
}

const FACTOR: f64 = 2.0;

/// The estimate of a run and the run itself must agree on the output and on temporary files.
#[track_caller]
fn agree(folder: &Folder, dem: &str, options: &[&str]) -> (f64, f64) {
    let tin = folder.at("tin.ply");
    let command = ["simplify", dem, &tin, "--tile", "64", "--overwrite", "--json"];
    let needs = terrabite(command.iter().chain(options).chain(&["--dry-run"])).succeeds().json();
    let run = terrabite(command.iter().chain(options));
    assert!(matches!(run.code, Some(0 | 5)), "{run:#?}");
    let report = run.json();
    let told = |name: &str| needs["estimate"][name].as_f64().unwrap();
    let written = std::fs::metadata(&tin).unwrap().len() as f64;
    let (output, temporary) = (told("output_bytes"), told("field_bytes") + told("spool_bytes") + told("survey_bytes"));
    let used = report["temporary_bytes"].as_f64().unwrap();
    for (what, told, found) in [("output", output, written), ("temporary files", temporary, used)] {
        let near = told <= FACTOR * found && found <= FACTOR * told;
        assert!(near, "{options:?}: {what}: {told} told, {found} written: {needs}");
    }
    (output, told("survey_bytes"))
}

#[test]
fn under_a_budget_it_is_the_budget() {
    let folder = Folder::new();
    let dem = Dem::new(300, 200).heights(ground).write(&folder, "dem.tif");
    let agree = |goal: &[&str]| agree(&folder, &dem, &[goal, &["--quality", "none"]].concat());
    let (output, survey) = agree(&["--max-points", "3000"]);
    assert!(output > 100_000.0 && survey > 100_000.0, "{output}, {survey}");
    agree(&["--max-triangles", "3000"]);
    // More than there are samples.
    agree(&["--max-points", "3000000"]);
    // Whichever ends it.
    agree(&["--max-points", "20000", "--max-error", "300"]);
    agree(&["--max-points", "1000", "--max-error", "10"]);
}

#[test]
fn a_search_is_begun() {
    let folder = Folder::new();
    let dem = Dem::new(300, 200).heights(ground).write(&folder, "dem.tif");
    let (output, survey) = agree(&folder, &dem, &["--max-triangles", "3000"]);
    assert!(output > 30_000.0 && survey == 0.0, "{output}, {survey}");
    let command =
        ["simplify", &dem, &folder.at("tin.ply"), "--max-triangles", "3000", "--tile", "64", "--json", "--overwrite"];
    let needs = terrabite(command.iter().chain(&["--dry-run"])).succeeds().json();
    let tolerance = terrabite(command).succeeds().json()["tolerance"].as_f64().unwrap();
    let expected = needs["tolerance"].as_f64().unwrap();
    assert!((expected / tolerance - 1.0).abs() < 0.5, "{expected}, {tolerance}");
    assert!(needs["thread_seconds"].as_f64().is_some_and(|seconds| seconds > 0.0), "{needs}");
    // In one tile, too.
    let alone = ["simplify", &dem, &folder.at("tin.ply"), "--max-triangles", "3000", "--overwrite", "--dry-run"];
    assert!(terrabite(alone).succeeds().out.contains("time "));
}

#[test]
fn under_a_root_mean_square_a_few_tiles_tell() {
    let folder = Folder::new();
    let dem = Dem::new(300, 200).heights(ground).write(&folder, "dem.tif");
    agree(&folder, &dem, &["--max-rms", "30"]);
    agree(&folder, &dem, &["--max-rms", "30", "--max-error", "100"]);
    agree(&folder, &dem, &["--max-rms", "10", "--max-points", "2000"]);
}

#[test]
fn under_a_tolerance_a_few_tiles_tell() {
    let folder = Folder::new();
    let dem = Dem::new(300, 200).heights(ground).write(&folder, "dem.tif");
    agree(&folder, &dem, &["--max-error", "20", "--quality", "none"]);
    agree(&folder, &dem, &["--max-error", "20", "--quality", "fast"]);
    // Hardly any triangles: what every tile has counts.
    agree(&folder, &dem, &["--max-error", "100000", "--quality", "none"]);
}

/// Every other sample of every other row, all but those on flat ground where nothing else is a vertex.
#[test]
fn points_count_also_beside_bridged_holes() {
    let folder = Folder::new();
    let flat = |c: usize, r: usize| if (10..13).contains(&c) && r == 20 { -9999.0 } else { 5.0 };
    let dem = Dem::new(300, 200).heights(flat).nodata(-9999.0).write(&folder, "dem.tif");
    let places = (0..99).flat_map(|row| (0..149).map(move |column| (2 * column + 1, 2 * row + 1)));
    let lines: String = places.map(|(c, r)| format!("{}.5,-{}.5\n", c, r)).collect();
    let points = folder.with("peaks.csv", format!("x,y\n{lines}"));
    for holes in ["0", "9"] {
        let options = ["--max-error", "1", "--points", &points, "--fill-holes", holes, "--quality", "none"];
        // At a hole that is not bridged no point lies.
        let (output, _) = agree(&folder, &dem, &options);
        assert!(output > 500_000.0, "{output}");
    }
}

/// A budget too small for what is there from the start is refused by the estimate, too.
#[test]
fn a_budget_that_is_too_small_is_told_of() {
    let folder = Folder::new();
    let dem = Dem::new(300, 200).heights(ground).write(&folder, "dem.tif");
    let command = ["simplify", &dem, &folder.at("tin.ply"), "--tile", "64", "--max-points", "9"];
    let stops = command.iter().copied().chain(["--quality", "none", "--dry-run"]).collect::<Vec<_>>();
    terrabite(&stops).fails(2, &["at least 30 vertices, found 9"]);
    // Nothing was begun: the first tile is never come to.
    let run = terrabite_with_fault("kill:tile-begun:1", &stops);
    assert_eq!(run.code, Some(2), "{run:#?}");
    // What the coarsest polished mesh has is known when it is made.
    terrabite(command).fails(2, &["expected a budget of at least ", " vertices, found 9"]);
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn a_cutline_that_is_exact_takes_its_share() {
    let folder = Folder::new();
    let dem = Dem::new(300, 200).heights(ground).write(&folder, "dem.tif");
    // The left third, less half of it in the middle.
    let ring = |left: f64, top: f64, right: f64, bottom: f64| {
        format!("[[{left},{top}],[{right},{top}],[{right},{bottom}],[{left},{bottom}],[{left},{top}]]")
    };
    let (outer, hole) = (ring(-1.0, 1.0, 100.0, -201.0), ring(30.0, -40.0, 80.0, -160.0));
    let area = folder.at("area.geojson");
    let text = format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[{outer},{hole}]}}}}]}}"#
    );
    std::fs::write(&area, text).unwrap();
    agree(&folder, &dem, &["--max-error", "20", "--quality", "none", "--cutline", &area, "--cutline-exact"]);
}
