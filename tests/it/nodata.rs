//! `terrabite simplify` on rasters with missing samples, from outside.

use std::fs;

use serde_json::Value;

use crate::util::{Dem, Folder, Kind, hills, terrabite, terrabite_with_fault, without_comments};

/// Hills with a lake, a strip along the upper rim, and a height all by itself.
fn holes(column: usize, row: usize) -> f64 {
    let lake = (column as f64 - 50.0).powi(2) + (row as f64 - 40.0).powi(2) < 150.0;
    let island = (column, row) == (50, 40);
    if (lake && !island) || row < 2 { -32768.0 } else { hills(column, row) }
}

fn dem() -> Dem {
    Dem::new(120, 90).heights(holes)
}

fn report(dem: &str, tin: &str, options: &[&str]) -> Value {
    let command = ["simplify", dem, tin, "--max-error", "3", "--tile", "32", "--overwrite", "--json"];
    terrabite(command.iter().chain(options)).succeeds().json()
}

#[test]
fn what_is_left_out_is_counted() {
    let folder = Folder::new();
    let (dem, tin) = (dem().nodata(-32768.0).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let report = report(&dem, &tin, &[]);
    let missing = (0..120 * 90).filter(|i| holes(i % 120, i / 120) == -32768.0).count() as u64;
    assert_eq!(report["missing_samples"], missing);
    assert_eq!(report["isolated_samples"], 1);
    assert_eq!(report["samples"], 120 * 90 - missing - 1);
    let lines = terrabite(["simplify", &dem, &tin, "--max-error", "3", "--overwrite"]).succeeds();
    assert!(lines.out.contains(&format!("{missing} samples, and 1 isolated")), "{}", lines.out);
}

#[test]
fn whatever_marks_them_and_however_they_are_read() {
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    let tagged = dem().nodata(-32768.0).write(&folder, "tagged.tif");
    report(&tagged, &tin, &["--access", "in-place"]);
    let expected = without_comments(&tin);
    for access in ["windows", "decode"] {
        report(&tagged, &tin, &["--access", access]);
        assert!(without_comments(&tin) == expected, "{access}");
    }
    // What the user says takes the place of what the raster says.
    for other in [dem(), dem().nodata(75.0)] {
        let path = other.write(&folder, "other.tif");
        report(&path, &tin, &["--nodata", "-32768"]);
        assert!(without_comments(&tin) == expected);
        fs::remove_file(path).unwrap();
    }
    let nan = |c: usize, r: usize| if holes(c, r) == -32768.0 { f64::NAN } else { holes(c, r) };
    let nan = Dem::new(120, 90).kind(Kind::Float32).heights(nan).write(&folder, "nan.tif");
    report(&nan, &tin, &[]);
    assert!(without_comments(&tin) == expected);
}

/// The tag of a band with a scale is a stored value.
#[test]
fn a_tag_is_a_stored_value() {
    let folder = Folder::new();
    let scaled = dem().nodata(-32768.0).scaling(0.5, 7.0).write(&folder, "scaled.tif");
    let scaled = report(&scaled, &folder.at("tin.ply"), &[]);
    assert_eq!(scaled["isolated_samples"], 1);
}

#[test]
fn a_run_that_was_killed_continues_with_the_same_value_only() {
    let folder = Folder::new();
    let (dem, tin, work) = (dem().compressed().write(&folder, "dem.tif"), folder.at("tin.ply"), folder.at("work"));
    report(&dem, &tin, &["--nodata", "-32768"]);
    let expected = fs::read(&tin).unwrap();
    fs::remove_file(&tin).unwrap();
    let command = |nodata: &'static str| {
        let command =
            ["simplify", &dem, &tin, "--max-error", "3", "--tile", "32", "--work-dir", &work, "--nodata", nodata];
        command.map(str::to_string)
    };
    let killed = terrabite_with_fault("kill:vertices:1", command("-32768"));
    assert_eq!(killed.code, None, "{killed:#?}");
    terrabite(command("75")).fails(1, &["another job", "--nodata, --valid-range: -32768", "75"]);
    terrabite(command("-32768")).succeeds();
    assert!(fs::read(&tin).unwrap() == expected);
}
