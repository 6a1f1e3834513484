//! `terrabite simplify --trim`, from outside.

use std::fs;

use serde_json::Value;

use crate::util::{Dem, Folder, hills, terrabite, terrabite_with_fault};

/// Hills with a round lake, a slanting coast and a strip without heights along the upper rim.
fn coast(column: usize, row: usize) -> f64 {
    let (x, y) = (column as f64, row as f64);
    let lake = (x - 50.0).powi(2) + (y - 40.0).powi(2) < 300.0;
    let sea = y > 70.0 + 0.15 * x + 3.0 * (x * 0.3).sin();
    if lake || sea || row < 2 { -32768.0 } else { hills(column, row) }
}

fn dem() -> Dem {
    Dem::new(120, 110).heights(coast).nodata(-32768.0)
}

fn command(dem: &str, tin: &str, options: &[&str]) -> Vec<String> {
    let usual = ["simplify", dem, tin, "--max-error", "30", "--tile", "32", "--overwrite", "--json"];
    usual.iter().chain(options).map(|word| word.to_string()).collect()
}

fn report(dem: &str, tin: &str, options: &[&str]) -> Value {
    terrabite(command(dem, tin, options)).succeeds().json()
}

#[test]
fn fewer_triangles_and_what_is_lost_is_told() {
    let folder = Folder::new();
    let (dem, tin) = (dem().write(&folder, "dem.tif"), folder.at("tin.ply"));
    let whole = report(&dem, &tin, &[]);
    let usual = fs::read(&tin).unwrap();
    assert_eq!(whole["trimmed_samples"], 0);
    report(&dem, &tin, &["--trim", "0"]);
    assert!(fs::read(&tin).unwrap() == usual);
    let number = |report: &Value, name: &str| report[name].as_u64().unwrap();
    let mut before = whole;
    for cells in ["1", "3"] {
        let trimmed = report(&dem, &tin, &["--trim", cells]);
        assert!(number(&trimmed, "triangles") < number(&before, "triangles"), "{cells} cells: {trimmed}");
        assert!(number(&trimmed, "trimmed_samples") > number(&before, "trimmed_samples"), "{cells} cells: {trimmed}");
        let all =
            ["samples", "missing_samples", "isolated_samples", "trimmed_samples"].map(|name| number(&trimmed, name));
        assert_eq!(all.iter().sum::<u64>(), 120 * 110);
        let verify = |cells: &str| terrabite(["verify", &dem, &tin, "--max-error", "30", "--json", "--trim", cells]);
        let verdict = verify(cells).succeeds().json();
        assert_eq!(verdict["trimmed_samples"], trimmed["trimmed_samples"], "{verdict}");
        assert_eq!(verify("0").code, Some(1));
        before = trimmed;
    }
    let lines = terrabite(["simplify", &dem, &tin, "--max-error", "30", "--trim", "3", "--overwrite"]).succeeds();
    assert!(lines.out.contains(" samples of the ground are not covered"), "{}", lines.out);
    let header = fs::read(&tin).unwrap();
    assert!(header.windows(15).any(|bytes| bytes == b"comment trim 3\n"));
}

/// Engines, qualities and heights, in tiles and in one piece.
#[test]
fn what_is_trimmed_passes_the_verifier() {
    let folder = Folder::new();
    let (dem, tin) = (dem().write(&folder, "dem.tif"), folder.at("tin.ply"));
    let ways: [&[&str]; 6] = [
        &["--quality", "none"],
        &["--quality", "none", "--engine", "greedy-insertion"],
        &["--quality", "fast", "--tile", "0"],
        &["--heights", "fitted"],
        &["--feasibility", "strong"],
        &["--quality", "best", "--tile", "17"],
    ];
    for (way, cells) in ways.iter().zip(["1", "2", "3", "4", "5", "9"]) {
        for max_error in ["0", "2.5", "1000"] {
            let mut command = vec!["simplify", &dem, &tin, "--max-error", max_error, "--overwrite", "--trim", cells];
            command.extend_from_slice(way);
            if !way.contains(&"--tile") {
                command.extend(["--tile", "32"]);
            }
            terrabite(command).succeeds();
            terrabite(["verify", &dem, &tin, "--max-error", max_error, "--trim", cells]).succeeds();
        }
    }
}

#[test]
fn the_same_bytes_whatever_the_threads_and_the_way_to_the_samples() {
    let folder = Folder::new();
    let (dem, tin) = (dem().write(&folder, "dem.tif"), folder.at("tin.ply"));
    report(&dem, &tin, &["--trim", "4", "--threads", "1"]);
    let expected = fs::read(&tin).unwrap();
    for options in [["--threads", "4"], ["--memory", "90MiB"], ["--access", "windows"], ["--access", "decode"]] {
        report(&dem, &tin, &[options.as_slice(), &["--trim", "4"]].concat());
        assert!(fs::read(&tin).unwrap() == expected, "{options:?}");
    }
}

#[test]
fn a_run_that_was_killed_continues_with_the_same_cells_only() {
    let folder = Folder::new();
    let (dem, tin, work) = (dem().write(&folder, "dem.tif"), folder.at("tin.ply"), folder.at("work"));
    report(&dem, &tin, &["--trim", "2"]);
    let expected = fs::read(&tin).unwrap();
    fs::remove_file(&tin).unwrap();
    let job = |trim: &str| command(&dem, &tin, &["--work-dir", &work, "--trim", trim]);
    // In the first pass, in the second, and behind both.
    for fault in ["kill:tile-begun:5", "kill:tile-begun:30", "kill:vertices:1"] {
        let killed = terrabite_with_fault(fault, job("2"));
        assert_eq!(killed.code, None, "{fault}: {killed:#?}");
        terrabite(job("1")).fails(1, &["another job", "--trim: 2 cells in the work dir, 1 cells now"]);
    }
    terrabite(job("2")).succeeds();
    assert!(fs::read(&tin).unwrap() == expected);
}

#[test]
fn cells_that_are_none_are_refused() {
    let folder = Folder::new();
    let (dem, tin) = (dem().write(&folder, "dem.tif"), folder.at("tin.ply"));
    for wrong in ["1001", "-1", "1.5", "all"] {
        let refused = terrabite(command(&dem, &tin, &["--trim", wrong]));
        refused.fails(2, &["--trim", "expected a whole number of cells, from 0 to 1000"]);
    }
}

/// Nothing is missing: the raster's own rim stays.
#[test]
fn whole_rasters_are_not_trimmed() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(120, 110).write(&folder, "dem.tif"), folder.at("tin.ply"));
    report(&dem, &tin, &[]);
    let expected = fs::read(&tin).unwrap();
    report(&dem, &tin, &["--trim", "5"]);
    let comment = b"comment trim 5\n";
    let found = fs::read(&tin).unwrap();
    let at = found.windows(comment.len()).position(|bytes| bytes == comment).unwrap();
    assert!([&found[..at], &found[at + comment.len()..]].concat() == expected);
}
