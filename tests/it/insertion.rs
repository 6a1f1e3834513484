//! `simplify --engine greedy-insertion`: its options, and goals over all tiles.

use serde_json::Value;

use crate::util::{Dem, Folder, Kind, hills, shared_data, terrabite, terrabite_with_fault};

const INSERTION: [&str; 2] = ["--engine", "greedy-insertion"];

fn simplified(dem: &str, tin: &str, options: &[&str], code: i32) -> Value {
    let run = terrabite(["simplify", dem, tin, "--overwrite", "--json"].iter().chain(&INSERTION).chain(options));
    assert_eq!(run.code, Some(code), "{run:#?}");
    serde_json::from_str(&run.out).expect("a report")
}

fn verified(dem: &str, tin: &str, tolerance: f64) {
    terrabite(["verify", dem, tin, "--max-error", &tolerance.to_string()]).succeeds();
}

#[test]
fn every_variant_passes() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(90, 70).on_the_map().write(&folder, "dem.tif"), folder.at("tin.ply"));
    for options in [
        vec![],
        vec!["--feasibility", "strong"],
        vec!["--swap", "data-dependent"],
        vec!["--swap", "data-dependent", "--fit", "l2", "--shape", "smallest-angle", "--quality-threshold", "0.2"],
        vec!["--selection", "fractional", "--fraction", "0.5"],
        vec!["--selection", "constant"],
        vec!["--measure", "curvature", "--smoothing", "2"],
        vec!["--measure", "global-error"],
        vec!["--measure", "product"],
        vec!["--quality", "none"],
        vec!["--quality", "fast"],
        vec!["--quality", "best"],
        vec!["--heights", "fitted"],
        vec!["--quality", "fast", "--heights", "fitted", "--feasibility", "strong"],
        vec!["--min-angle", "20"],
        vec!["--polish-edges", "strong"],
        vec!["--polish-passes", "2", "--polish-caps", "0.5,2", "--polish-rounds", "5", "--polish-turns", "false"],
        vec!["--polish-sweeps", "0", "--polish-moves", "2", "--polish-last-sweeps", "all", "--polish-places", "4"],
    ] {
        for tile in ["0", "32"] {
            let options: Vec<&str> = options.iter().copied().chain(["--max-error", "2", "--tile", tile]).collect();
            simplified(&dem, &tin, &options, 0);
            verified(&dem, &tin, 2.0);
        }
    }
}

#[test]
fn options_that_mean_nothing_are_usage_errors() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(20, 20).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let fails = |options: &[&str], message: &[&str]| {
        let fixed = ["simplify", &dem, &tin];
        terrabite(fixed.iter().chain(options)).fails(2, message);
        assert!(!std::path::Path::new(&tin).exists());
    };
    let cuts = ["--engine", "greedy-cuts", "--max-error", "1"];
    let cuts = |more: &[&'static str]| cuts.iter().copied().chain(more.iter().copied()).collect::<Vec<_>>();
    fails(&cuts(&["--swap", "delaunay"]), &["--swap", "--engine greedy-insertion"]);
    fails(
        &["--max-error", "1", "--quality", "none", "--heights", "fitted"],
        &["--heights fitted requires --quality fast, balanced or best", "use --quality balanced"],
    );
    for untuned in [["--min-angle", "9"], ["--polish-rounds", "3"], ["--polish-edges", "strong"]] {
        let none = ["--max-error", "1", "--quality", "none"];
        fails(
            &[none.as_slice(), &untuned].concat(),
            &[untuned[0], "requires --quality fast, balanced or best", "use --quality balanced"],
        );
    }
    for [option, value, message] in [
        ["--min-angle", "61", "0 to 60"],
        ["--min-angle", "-1", "0 to 60"],
        ["--polish-caps", "1,-1", "none below 0"],
        ["--polish-caps", "1,2,3,4,5,6,7,8,9", "one to 8 numbers"],
        ["--polish-shrink", "0", "above 0"],
        ["--polish-reach", "0", "above 0"],
        ["--polish-rows", "7", "from 8 on"],
        ["--polish-sweeps", "-1", "--polish-sweeps"],
        ["--polish-places", "6", "--polish-places"],
        ["--polish-rounds", "0", "--polish-rounds"],
        ["--polish-longest-repaired", "65", "--polish-longest-repaired"],
    ] {
        fails(&["--max-error", "1", &format!("{option}={value}")], &[option, message]);
    }
    fails(
        &["--max-error", "1", "--feasibility", "strong", "--polish-edges", "weak"],
        &["--polish-edges", "--feasibility"],
    );
    fails(
        &["--max-error", "1", "--engine", "greedy-insertion", "--cuts", "plain"],
        &["--cuts", "--engine greedy-cuts"],
    );
    let with = |more: &[&'static str]| INSERTION.iter().copied().chain(more.iter().copied()).collect::<Vec<_>>();
    fails(&with(&["--max-error", "1", "--fit", "l2"]), &["--fit", "--swap data-dependent"]);
    fails(&with(&["--max-error", "1", "--fraction", "0.5"]), &["--fraction", "--selection fractional"]);
    fails(&with(&["--max-error", "1", "--smoothing", "2"]), &["--smoothing", "--measure"]);
    fails(&with(&["--max-error", "1", "--quality-threshold", "2"]), &["from 0 to 1"]);
    for quality in ["none", "balanced"] {
        fails(&["--max-points", "3", "--quality", quality], &["at least 4 vertices", "found 3", "--tile"]);
    }
    fails(&with(&["--max-triangles", "many"]), &["many", "--max-triangles"]);
    fails(&with(&[]), &["--max-error", "--max-points"]);
}

#[test]
fn a_budget_is_spent_and_never_exceeded() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(90, 70).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let report = simplified(&dem, &tin, &["--max-points", "200", "--tile", "32", "--quality", "none"], 0);
    assert_eq!((report["vertices"].as_u64(), report["tolerance"].as_f64()), (Some(200), None), "{report}");
    assert_eq!(report["goal"]["ended_by"], "max-points");
    verified(&dem, &tin, report["error"]["max"].as_f64().unwrap() + 1e-9);
    let header = String::from_utf8_lossy(&std::fs::read(&tin).unwrap()).into_owned();
    assert!(header.contains("comment max_points 200\n") && !header.contains("max_error"));
    let report = simplified(&dem, &tin, &["--max-triangles", "301", "--tile", "32", "--quality", "none"], 0);
    assert!((299..=301).contains(&report["triangles"].as_u64().unwrap()), "{report}");
}

/// With polishing, by engines that cannot stop, with a trimmed rim: the mesh is the one that the tolerance makes that is found.
#[test]
fn a_budget_has_its_tolerance_looked_for() {
    let folder = Folder::new();
    let (dem, tin, other) = (Dem::new(120, 90).write(&folder, "dem.tif"), folder.at("tin.ply"), folder.at("other.ply"));
    let report = |to: &str, options: &[&str]| {
        let all = ["simplify", &dem, to, "--tile", "40", "--overwrite", "--json"];
        terrabite(all.iter().chain(options)).succeeds().json()
    };
    for options in [
        &["--max-points", "300"][..],
        &["--max-triangles", "600", "--quality", "fast", "--heights", "fitted"],
        &["--max-triangles", "900", "--quality", "none", "--engine", "greedy-cuts"],
        &["--max-triangles", "600", "--trim", "2"],
        &["--max-rms", "1.5"],
    ] {
        let told = report(&tin, options);
        let (tolerance, search) = (told["tolerance"].as_f64().expect("a tolerance"), &told["goal"]["search"]);
        assert_eq!(search["tolerance"].as_f64(), Some(tolerance), "{told}");
        assert!(search["share"].as_f64().is_none_or(|share| (0.9..=1.0).contains(&share)), "{told}");
        assert!(told["error"]["rms"].as_f64().unwrap() <= 1.5 || options[0] != "--max-rms", "{told}");
        verified(&dem, &tin, tolerance);
        let (alone, asked) = (&options[2..], tolerance.to_string());
        report(&other, &[alone, &["--max-error", &asked]].concat());
        let [found, expected] =
            [&tin, &other].map(|path| String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned());
        let goal = format!("comment {} {}\n", options[0][2..].replace('-', "_"), options[1]);
        assert!(found.replace(&goal, "") == expected, "{options:?}");
        assert!(found.contains(&format!("max_error {tolerance}\n")), "{options:?}");
    }
}

/// In single precision heights lose something: that is taken from every tolerance that is tried.
#[test]
fn what_rounding_loses_is_taken_from_a_tolerance_that_is_found() {
    let folder = Folder::new();
    let heights = |column: usize, row: usize| 1e6 + hills(column, row) / 7.0;
    let dem = Dem::new(120, 90).heights(heights).kind(Kind::Float64).write(&folder, "dem.tif");
    for (name, goal) in [("tin.glb", ["--max-triangles", "900"]), ("tin.stl", ["--max-rms", "0.2"])] {
        let tin = folder.at(name);
        let command = ["simplify", &dem, &tin, "--tile", "40", "--heights", "fitted", "--json"];
        let told = terrabite(command.iter().chain(&goal)).succeeds().json();
        assert!(told["map"]["kept_for_rounding"].as_f64().is_some_and(|lost| lost > 0.01), "{told}");
        verified(&dem, &tin, told["tolerance"].as_f64().unwrap());
    }
}

#[test]
fn a_quality_is_reached_or_the_exit_code_tells() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(90, 70).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let report = simplified(&dem, &tin, &["--max-error", "3", "--max-points", "6000"], 0);
    assert_eq!(report["goal"]["reached"], true);
    verified(&dem, &tin, 3.0);
    let report = simplified(&dem, &tin, &["--max-rms", "1.5", "--tile", "40"], 0);
    assert!(report["error"]["rms"].as_f64().unwrap() <= 1.5, "{report}");
    let report = simplified(&dem, &tin, &["--max-error", "0.5", "--max-points", "100"], 5);
    assert_eq!(report["goal"]["reached"], false);
    assert!(std::path::Path::new(&tin).exists(), "it is complete all the same");
    let told = terrabite(
        ["simplify", &dem, &tin, "--overwrite", "--max-error", "0.5", "--max-points", "100"].iter().chain(&INSERTION),
    );
    assert!(told.out.contains(" of 100 vertices") && told.err.contains("warning"), "{told:#?}");
    assert!(told.out.contains("; the quality that was asked for is not reached"), "{told:#?}");
}

/// A lake over a corner of tiles, an island in it, and a strip of tiles with nothing at all.
fn lake(column: usize, row: usize) -> f64 {
    let from_centre = |radius: f64| (column as f64 - 32.0).hypot(row as f64 - 32.0) < radius;
    if from_centre(12.0) && !from_centre(4.0) || row > 64 { -9999.0 } else { hills(column, row) }
}

#[test]
fn goals_are_reached_where_samples_are_missing() {
    let folder = Folder::new();
    let dem = Dem::new(90, 110).heights(lake).nodata(-9999.0).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let gaps = (0..90 * 110).filter(|i| lake(i % 90, i / 90) == -9999.0).count() as u64;
    let run = |goal: &[&str], code| {
        let report = simplified(&dem, &tin, &[goal, &["--tile", "32", "--quality", "none"]].concat(), code);
        assert_eq!(report["missing_samples"], gaps);
        assert_eq!(report["samples"], 90 * 110 - gaps);
        verified(&dem, &tin, report["error"]["max"].as_f64().unwrap() + 1e-9);
        report
    };
    assert_eq!(run(&["--max-points", "400"], 0)["vertices"], 400);
    let triangles = run(&["--max-triangles", "701"], 0)["triangles"].as_u64().unwrap();
    assert!((700..=701).contains(&triangles), "{triangles}");
    assert!(run(&["--max-rms", "1.2"], 0)["error"]["rms"].as_f64().unwrap() <= 1.2);
    run(&["--max-error", "2", "--max-points", "6000"], 0);
    verified(&dem, &tin, 2.0);
    assert_eq!(run(&["--max-error", "0.1", "--max-points", "400"], 5)["goal"]["reached"], false);
    for quality in ["none", "balanced"] {
        let small = ["simplify", &dem, &tin, "--overwrite", "--max-points", "20", "--tile", "32", "--quality", quality];
        terrabite(small).fails(2, &["at least", "found 20", "outlines", "--tile"]);
    }
    let polished = simplified(&dem, &tin, &["--max-points", "500", "--tile", "32"], 0);
    assert!((450..=500).contains(&polished["vertices"].as_u64().unwrap()), "{polished}");
    verified(&dem, &tin, polished["tolerance"].as_f64().unwrap());
    assert_eq!(simplified(&dem, &tin, &["--max-error", "0.1", "--max-points", "500"], 5)["goal"]["reached"], false);
}

/// Killed while it is on its first run, on a later one, and again: it goes on where it was, and its folder holds nothing then.
#[test]
fn a_stopped_search_continues() {
    let folder = Folder::new();
    let dem = Dem::new(90, 70).write(&folder, "dem.tif");
    let [whole, tin, work] = ["whole.ply", "tin.ply", "work"].map(|name| folder.at(name));
    let goal = ["--max-triangles", "400", "--tile", "32", "--quality", "balanced"];
    let report = simplified(&dem, &whole, &goal, 0);
    let runs = report["goal"]["search"]["runs"].as_u64().unwrap();
    assert!(runs > 1, "{report}");
    let kept = ["simplify", &dem, &tin, "--work-dir", &work, "--threads", "1", "--json"];
    let kept: Vec<&str> = kept.iter().chain(&INSERTION).chain(&goal).copied().collect();
    for tiles in ["3", "21", "29", "7"] {
        terrabite_with_fault(&format!("kill:tile-begun:{tiles}"), &kept);
    }
    let told = terrabite(kept.iter().chain(&["--dry-run"])).succeeds();
    assert!(told.json()["work_dir"]["finished"]["runs"].as_u64().is_some_and(|made| made < runs), "{told:#?}");
    let report = terrabite(&kept).succeeds().json();
    assert!(report["tiles_found"].as_u64().is_some_and(|found| found > 0), "{report}");
    assert_eq!(std::fs::read(whole).unwrap(), std::fs::read(tin).unwrap());
    assert!(!std::path::Path::new(&work).exists());
}

/// The survey is made again, the finished tiles are not.
#[test]
fn a_stopped_run_under_a_goal_continues() {
    let folder = Folder::new();
    let dem = Dem::new(90, 70).write(&folder, "dem.tif");
    let [whole, tin, work] = ["whole.ply", "tin.ply", "work"].map(|name| folder.at(name));
    let goal = ["--max-points", "300", "--tile", "32", "--quality", "none"];
    simplified(&dem, &whole, &goal, 0);
    let kept = ["simplify", &dem, &tin, "--work-dir", &work, "--threads", "1", "--json"];
    let kept: Vec<&str> = kept.iter().chain(&INSERTION).chain(&goal).copied().collect();
    terrabite_with_fault("kill:tile-begun:3", &kept);
    let report = terrabite(&kept).succeeds().json();
    assert_eq!(report["tiles_found"], 2, "{report}");
    assert_eq!(std::fs::read(whole).unwrap(), std::fs::read(tin).unwrap());
}

/// Counts of the authors' own program, on the paper's own raster.
#[test]
fn crater_lake_takes_as_many_triangles_as_it_took_its_authors() {
    let Some(dem) = shared_data("crater_lake_garland.tif") else { return };
    let dem = dem.display().to_string();
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    for (tolerance, theirs) in [("1", 82_828.0), ("5", 19_447.0), ("10", 9_184.0), ("20", 3_979.0)] {
        let report = simplified(&dem, &tin, &["--max-error", tolerance, "--tile", "0"], 0);
        let ours = report["triangles"].as_f64().unwrap();
        assert!(ours <= theirs * 1.01, "{ours} triangles at {tolerance}");
        verified(&dem, &tin, tolerance.parse().unwrap());
    }
}
