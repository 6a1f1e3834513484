//! `--fill-holes`: small holes of the ground, bridged by `simplify` and held against the raster by `verify`.

use std::fs;

use serde_json::Value;

use crate::util::{Dem, Folder, Kind, hills, terrabite, terrabite_with_fault, without_comments};

const MISSING: f64 = -32768.0;

/// Hills with lakes of 1, 2 (over a corner), 9, 21 and some 470 samples, one at the upper rim, and a strait between two rims.
fn lakes(column: usize, row: usize) -> f64 {
    let within = |c: usize, r: usize, square: usize| {
        (column as i64 - c as i64).pow(2) + (row as i64 - r as i64).pow(2) <= square as i64
    };
    let small = [(10, 80), (20, 80), (21, 81)].contains(&(column, row)) || within(32, 32, 2) || within(64, 20, 5);
    let large = within(60, 55, 150) || within(90, 0, 20) || column == 110 + (row / 40) % 2;
    if small || large { MISSING } else { hills(column, row) }
}

fn dem() -> Dem {
    Dem::new(120, 90).heights(lakes)
}

fn report(dem: &str, tin: &str, options: &[&str]) -> Value {
    let command = ["simplify", dem, tin, "--max-error", "3", "--tile", "32", "--overwrite", "--json"];
    terrabite(command.iter().chain(options)).succeeds().json()
}

#[test]
fn what_is_bridged_is_what_verify_asks_for() {
    let folder = Folder::new();
    let (dem, tin) = (dem().nodata(MISSING).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let missing = (0..120 * 90).filter(|i| lakes(i % 120, i / 120) == MISSING).count() as u64;
    for (most, holes, samples) in [("1", 1, 1), ("2", 2, 3), ("9", 3, 12), ("21", 4, 33), ("1000", 5, 33 + 481)] {
        for more in [
            &["--quality", "none"][..],
            &["--quality", "balanced", "--heights", "fitted"],
            &["--quality", "none", "--engine", "greedy-cuts"],
        ] {
            let told = report(&dem, &tin, &[&["--fill-holes", most], more].concat());
            assert_eq!((&told["filled_voids"], &told["filled_samples"]), (&holes.into(), &samples.into()), "{most}");
            assert_eq!(told["missing_samples"], missing - samples);
            assert_eq!(told["samples"], 120 * 90 - missing);
            let verify = |most| terrabite(["verify", &dem, &tin, "--max-error", "3", "--fill-holes", most, "--json"]);
            let verdict = verify(most).succeeds().json();
            assert_eq!((&verdict["filled_voids"], &verdict["filled_samples"]), (&holes.into(), &samples.into()));
            assert_eq!(verify("0").code, Some(1));
        }
    }
    let lines = terrabite(["simplify", &dem, &tin, "--max-error", "3", "--overwrite", "--fill-holes", "9"]).succeeds();
    assert!(lines.out.contains("3 voids of 12 samples"), "{}", lines.out);
    // Nothing is bridged unless asked for.
    let told = report(&dem, &tin, &[]);
    assert_eq!((&told["filled_voids"], &told["missing_samples"]), (&0.into(), &missing.into()));
    let expected = without_comments(&tin);
    report(&dem, &tin, &["--fill-holes", "0"]);
    assert!(without_comments(&tin) == expected);
}

#[test]
fn however_samples_are_read_and_whatever_marks_them() {
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    let nan = |c: usize, r: usize| if lakes(c, r) == MISSING { f64::NAN } else { lakes(c, r) };
    let rasters = [
        dem().nodata(MISSING).write(&folder, "strips.tif"),
        dem().nodata(MISSING).tiled(16).compressed().write(&folder, "tiled.tif"),
        dem().nodata(MISSING).stripped(7).compressed().write(&folder, "high.tif"),
        Dem::new(120, 90).kind(Kind::Float32).heights(nan).tiled(48).write(&folder, "nan.tif"),
    ];
    let mut expected = None;
    for dem in &rasters {
        for options in [
            ["--access", "auto", "--threads", "1"],
            ["--access", "windows", "--threads", "3"],
            ["--access", "decode", "--threads", "2"],
        ] {
            report(dem, &tin, &[&["--fill-holes", "500"], &options[..]].concat());
            let bytes = without_comments(&tin);
            assert!(*expected.get_or_insert_with(|| bytes.clone()) == bytes, "{dem} {options:?}");
        }
    }
}

/// A hole of the raster may be an edge of a part of it.
#[test]
fn a_window_has_edges_of_its_own() {
    let folder = Folder::new();
    let (dem, tin) = (dem().nodata(MISSING).tiled(16).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let part = ["--fill-holes", "25", "--window", "5,32,60,52"];
    let told = report(&dem, &tin, &part);
    assert_eq!((&told["filled_voids"], &told["filled_samples"]), (&2.into(), &3.into()));
    let verify = ["verify", &dem, &tin, "--max-error", "3", "--json"];
    assert_eq!(terrabite(verify.iter().chain(&part)).succeeds().json()["filled_samples"], 3);
}

/// Weights and points beside holes, and one point in the largest of them.
#[test]
fn beside_weights_and_points() {
    let folder = Folder::new();
    let (dem, tin) = (dem().nodata(MISSING).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let weights = |c: usize, r: usize| if lakes(c, r) == MISSING { -1.0 } else { [0.5, 1.0, 2.0][(c + r) % 3] };
    let weights = Dem::new(120, 90).kind(Kind::Float32).heights(weights).write(&folder, "weights.tif");
    let points = folder.with("points.csv", "X,Y\n60.5,-55.5\n33.5,-32.5\n5.5,-5.5\n");
    let told = report(&dem, &tin, &["--fill-holes", "500", "--importance", &weights, "--points", &points]);
    assert_eq!(told["filled_voids"], 5);
    assert!(told["importance"]["max_weighted_error"].as_f64() <= Some(3.0));
    let verify = ["verify", &dem, &tin, "--max-error", "3", "--fill-holes", "500", "--importance", &weights];
    terrabite(verify).succeeds();
    let refused =
        ["simplify", &dem, &tin, "--max-error", "3", "--overwrite", "--fill-holes", "30", "--points", &points];
    assert_ne!(terrabite(refused).code, Some(0));
}

#[test]
fn a_run_that_was_killed_continues_with_as_many_samples_only() {
    let folder = Folder::new();
    let (tin, work) = (folder.at("tin.ply"), folder.at("work"));
    let dem = dem().nodata(MISSING).compressed().write(&folder, "dem.tif");
    report(&dem, &tin, &["--fill-holes", "25"]);
    let expected = fs::read(&tin).unwrap();
    fs::remove_file(&tin).unwrap();
    let command = |most: &'static str| {
        let command =
            ["simplify", &dem, &tin, "--max-error", "3", "--tile", "32", "--work-dir", &work, "--fill-holes", most];
        command.map(str::to_string)
    };
    let killed = terrabite_with_fault("kill:vertices:1", command("25"));
    assert_eq!(killed.code, None, "{killed:#?}");
    terrabite(command("30")).fails(1, &["another job", "--fill-holes: 25 in the work dir, 30 now"]);
    // The raster's times are others, so samples are compared.
    fs::copy(&dem, folder.at("copy.tif")).unwrap();
    fs::rename(folder.at("copy.tif"), &dem).unwrap();
    terrabite(command("25")).succeeds();
    assert!(fs::read(&tin).unwrap() == expected);
}

#[test]
fn what_it_does_not_go_with() {
    let folder = Folder::new();
    let (dem, tin) = (dem().nodata(MISSING).bands(2).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let run = |options: &[&str]| {
        let command = ["simplify", &dem, &tin, "--max-error", "3", "--fill-holes", "9"];
        terrabite(command.iter().chain(options))
    };
    run(&["--attributes", "2"]).fails(2, &["--fill-holes", "--attributes"]);
    let command = ["simplify", &dem, &tin, "--max-error", "3", "--fill-holes", "few"];
    terrabite(command).fails(2, &["whole number"]);
    assert_eq!(folder.names(), ["dem.tif"]);
}

/// Holes that are bridged have no rim to be trimmed, and those that are not have.
#[test]
fn beside_a_rim_that_is_trimmed() {
    let folder = Folder::new();
    let (dem, tin) = (dem().nodata(MISSING).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let both = ["--fill-holes", "9", "--trim", "2"];
    let command = ["simplify", &dem, &tin, "--max-error", "30", "--tile", "32", "--json"];
    let told = terrabite(command.iter().chain(&both)).succeeds().json();
    let verify = |options: &[&str]| {
        let command = ["verify", &dem, &tin, "--max-error", "30", "--json"];
        terrabite(command.iter().chain(options))
    };
    let verdict = verify(&both).succeeds().json();
    assert_eq!((&told["filled_samples"], &verdict["filled_samples"]), (&12.into(), &12.into()));
    assert!(told["trimmed_samples"].as_u64() > Some(0), "{told}");
    assert_eq!(told["trimmed_samples"], verdict["trimmed_samples"]);
    let counts = ["samples", "missing_samples", "isolated_samples", "filled_samples", "trimmed_samples"];
    assert_eq!(counts.map(|name| told[name].as_u64().unwrap()).iter().sum::<u64>(), 120 * 90);
    for less in [&["--fill-holes", "9"][..], &["--trim", "2"], &["--fill-holes", "2", "--trim", "2"]] {
        assert_eq!(verify(less).code, Some(1), "{less:?}");
    }
}
