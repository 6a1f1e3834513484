//! `--max-stray` of `simplify` and `verify`, from outside.

use std::fs;

use crate::util::{Dem, Folder, Run, ply, terrabite};

/// Flat ground but for a step up to the third column, and weights.
fn scene(folder: &Folder) -> String {
    let step = |column, _| if column == 2 { 30.0 } else { 0.0 };
    Dem::new(3, 3).heights(step).write(folder, "dem.tif")
}

/// A mesh of all samples, its diagonals falling, and one vertex more in the midst of the first side, at this height.
fn with_spike(height: f64) -> Vec<u8> {
    let sample = |i: usize| [i as f64 % 3.0 + 0.5, -0.5 - (i / 3) as f64, if i % 3 == 2 { 30.0 } else { 0.0 }];
    let vertices: Vec<[f64; 3]> = (0..9).map(sample).chain([[1.0, -0.5, height]]).collect();
    let cells = [1u32, 3, 4].map(|nw| [[nw, nw + 3, nw + 4], [nw, nw + 4, nw + 1]]);
    let spike = [[0, 3, 4], [0, 4, 9], [9, 4, 1]];
    ply(&vertices, &cells.into_iter().flatten().chain(spike).collect::<Vec<_>>())
}

fn verify(dem: &str, tin: &str, options: &[&str]) -> Run {
    terrabite(["verify", dem, tin, "--max-error", "2"].iter().chain(options))
}

#[test]
fn a_spike_between_samples_fails_where_it_is_asked_for() {
    let folder = Folder::new();
    let dem = scene(&folder);
    let tin = folder.with("tin.ply", with_spike(4.5));
    for options in [&[][..], &["--max-stray", "inf"]] {
        let passed = verify(&dem, &tin, options).succeeds();
        assert!(passed.out.contains("PASS: within 2 at every sample, without cracks"), "{}", passed.out);
    }
    assert!(verify(&dem, &tin, &["--json"]).succeeds().json()["stray"].is_null());
    let passed = verify(&dem, &tin, &["--max-stray", "2.25"]).succeeds();
    let worst = "4.5 (2.250 × the tolerance) at column 0.5, row 0 (1 -0.5): surface 4.5, samples 0 and 0";
    assert!(passed.out.contains(&format!("max stray {worst}\n")), "{}", passed.out);
    let promise = "PASS: within 2 at every sample and 4.5 (2.25 × 2) of the heights around between samples, without";
    assert!(passed.out.contains(promise), "{}", passed.out);
    let failed = verify(&dem, &tin, &["--max-stray", "2"]);
    assert_eq!(failed.code, Some(1));
    let what = "the surface is more than 4 (2 × 2) beyond the heights around, between samples, in 1 place:";
    assert!(failed.out.contains(&format!("FAIL\n  {what} {worst}")), "{}", failed.out);
    let report = verify(&dem, &tin, &["--max-stray", "2", "--json"]).json();
    assert_eq!((&report["passed"], report["failures"].as_array().unwrap().len()), (&false.into(), 1));
    let stray = &report["stray"];
    assert_eq!((stray["max_stray"].as_f64(), stray["limit"].as_f64()), (Some(2.0), Some(4.0)));
    assert_eq!(
        (stray["beyond"]["count"].as_u64(), stray["beyond"]["first"]["to"]["column"].as_u64()),
        (Some(1), Some(1))
    );
    let number = |name: &str| stray["worst"][name].as_f64();
    let found = ["stray", "tolerances", "column", "row", "x", "y", "surface_height"].map(number);
    assert_eq!(found, [4.5, 2.25, 0.5, 0.0, 1.0, -0.5, 4.5].map(Some));
    assert_eq!(stray["worst"]["raster_heights"], serde_json::json!([0.0, 0.0]));
    // Below as well as above.
    let tin = folder.with("below.ply", with_spike(-4.5));
    assert_eq!(verify(&dem, &tin, &["--max-stray", "2", "--quiet"]).code, Some(1));
}

#[test]
fn cliffs_stray_nowhere() {
    let folder = Folder::new();
    let dem = scene(&folder);
    let tin = folder.with("tin.ply", with_spike(0.0));
    let passed = verify(&dem, &tin, &["--max-stray", "1"]).succeeds();
    assert!(passed.out.contains("max stray 0\n"), "{}", passed.out);
    let cliff = ply(
        &[[0.5, -0.5, 0.0], [1.5, -0.5, 0.0], [2.5, -0.5, 30.0], [0.5, -2.5, 0.0], [1.5, -2.5, 0.0], [2.5, -2.5, 30.0]],
        &[[0, 3, 4], [0, 4, 1], [1, 4, 5], [1, 5, 2]],
    );
    // The diagonals cross the middle row between its samples.
    let tin = folder.with("cliff.ply", cliff);
    verify(&dem, &tin, &["--max-stray", "1", "--max-error", "0"]).fails(2, &["--max-error"]);
    terrabite(["verify", &dem, &tin, "--max-error", "0", "--max-stray", "1"]).succeeds();
}

#[test]
fn weights_count_and_so_does_what_is_missing() {
    let folder = Folder::new();
    let dem = scene(&folder);
    let tin = folder.with("tin.ply", with_spike(4.5));
    let weights = Dem::new(3, 3).heights(|column, row| if (column, row) == (1, 0) { 0.0 } else { 1.0 });
    let weights = weights.write(&folder, "weights.tif");
    let weighted = |options: &[&str]| {
        let usual = ["verify", &dem, &tin, "--max-error", "2", "--max-stray", "1", "--json"];
        terrabite(usual.iter().chain(options))
    };
    assert_eq!(weighted(&[]).code, Some(1));
    assert!(weighted(&["--importance", &weights]).succeeds().json()["stray"]["worst"].is_null());
}

#[test]
fn strong_meshes_keep_what_weak_ones_break() {
    let folder = Folder::new();
    let dem = Dem::new(200, 160).write(&folder, "dem.tif");
    for (feasibility, passes) in [("strong", true), ("weak", false)] {
        let tin = folder.at(feasibility);
        let options = ["--max-error", "8", "--quality", "none", "--engine", "greedy-cuts", "--format", "ply"];
        let feasibility = ["--feasibility", feasibility];
        terrabite(["simplify", &dem, &tin].iter().chain(&options).chain(&feasibility)).succeeds();
        let said = [1, 3].map(|threads| {
            let threads = threads.to_string();
            terrabite(["verify", &dem, &tin, "--max-error", "8", "--max-stray", "1.5", "--json", "--threads", &threads])
        });
        assert_eq!(said[0].out, said[1].out);
        let report = said[0].json();
        assert_eq!(report["passed"], passes, "{report}");
        assert_eq!(report["stray"]["beyond"]["count"].as_u64().unwrap() == 0, passes, "{report}");
        assert_eq!(report["above_tolerance"]["count"], 0);
    }
    // Any format is judged.
    let (tin, other) = (folder.at("strong"), folder.at("tin.obj"));
    terrabite(["convert", &tin, &other]).succeeds();
    terrabite(["verify", &dem, &other, "--max-error", "8", "--max-stray", "1.5"]).succeeds();
}

#[test]
fn limits_that_no_mesh_keeps_are_refused() {
    let folder = Folder::new();
    let dem = scene(&folder);
    let tin = folder.with("tin.ply", with_spike(0.0));
    for wrong in ["0.99", "0", "-1", "nan", "much", "-inf"] {
        verify(&dem, &tin, &["--max-stray", wrong]).fails(2, &["--max-stray", "1 or more", "inf"]);
    }
    assert!(fs::metadata(&tin).is_ok());
}

#[test]
fn the_default_mesh_keeps_to_its_limit_and_others_to_theirs() {
    let folder = Folder::new();
    // Hills, and houses on them.
    let ground = |column: usize, row: usize| {
        let hills = (column as f64 * 0.13).sin() * 9.0 + (row as f64 * 0.17).cos() * 7.0;
        if column % 23 > 15 && row % 19 > 12 { hills + 25.0 } else { hills }
    };
    let dem = Dem::new(150, 130).heights(ground).write(&folder, "dem.tif");
    let make = |options: &[&str]| {
        let tin = folder.at("tin.ply");
        let words = ["simplify", &dem, &tin, "--max-error", "1", "--tile", "48", "--overwrite", "--json"];
        (terrabite(words.iter().chain(options)).succeeds().json(), tin)
    };
    let judge = |tin: &str, limit: &str| terrabite(["verify", &dem, tin, "--max-error", "1", "--max-stray", limit]);
    for (options, limit) in
        [(&[][..], 1.5), (&["--max-stray", "1"], 1.0), (&["--quality", "none", "--max-stray", "2"], 2.0)]
    {
        let (report, tin) = make(options);
        assert_eq!(report["max_stray"].as_f64(), Some(limit));
        assert_eq!(report["shape"]["edges_astray"], 0);
        judge(&tin, &limit.to_string()).succeeds();
    }
    for options in [&["--quality", "none"][..], &["--max-stray", "inf"]] {
        let (report, tin) = make(options);
        assert!(report["max_stray"].is_null());
        assert_eq!(judge(&tin, "1.5").code, Some(1), "without a limit something strays");
    }
}

#[test]
fn a_limit_below_one_is_refused() {
    let folder = Folder::new();
    let (dem, tin) = (scene(&folder), folder.at("tin.ply"));
    let simplify = |options: &[&str]| terrabite(["simplify", &dem, &tin].iter().chain(options));
    simplify(&["--max-error", "2", "--max-stray", "0.9"]).fails(2, &["--max-stray", "expected 1 or more", "inf"]);
    assert!(!fs::exists(&tin).unwrap(), "nothing is left behind");
}
