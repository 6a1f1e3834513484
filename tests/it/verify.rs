//! `terrabite verify` as a user meets it: exit codes and what is printed.

use std::path::PathBuf;
use std::process::{Command, Output};

use gdal::DriverManager;
use gdal::raster::Buffer;

/// 3 × 2 samples, the one in the middle of the first row 1 above a mesh of two flat triangles.
fn scene(dir: &tempfile::TempDir) -> (PathBuf, PathBuf) {
    let (raster, mesh) = (dir.path().join("dem.tif"), dir.path().join("tin.ply"));
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let dataset = driver.create_with_band_type::<i16, _>(&raster, 3, 2, 1).unwrap();
    let mut samples = Buffer::new((3, 2), vec![0i16, 1, 0, 0, 0, 0]);
    dataset.rasterband(1).unwrap().write((0, 0), (3, 2), &mut samples).unwrap();
    dataset.close().unwrap();
    let ply = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
        element face 2\nproperty list uchar int vertex_indices\nend_header\n\
        0.5 -0.5 0\n2.5 -0.5 0\n2.5 -1.5 0\n0.5 -1.5 0\n3 0 2 1\n3 0 3 2\n";
    std::fs::write(&mesh, ply).unwrap();
    (raster, mesh)
}

fn terrabite(args: &[&str]) -> Output {
    let dir = tempfile::tempdir().unwrap();
    let (raster, mesh) = scene(&dir);
    Command::new(env!("CARGO_BIN_EXE_terrabite")).arg("verify").arg(raster).arg(mesh).args(args).output().unwrap()
}

#[test]
fn the_exit_code_is_the_verdict() {
    let code = |args: &[&str]| terrabite(args).status.code();
    assert_eq!(code(&["--max-error", "1"]), Some(0));
    assert_eq!(code(&["--max-error", "0.999"]), Some(1));
    assert_eq!(code(&["--max-error", "0", "--quiet"]), Some(1));
    for usage in [&["--max-error", "-1"][..], &["--max-error", "nan"], &["--max-error=-0.5"], &[]] {
        assert_eq!(code(usage), Some(2), "{usage:?}");
    }
}

#[test]
fn any_number_of_threads_says_the_same() {
    let said = |threads| {
        let output = terrabite(&["--max-error", "0.5", "--json", "--threads", threads]);
        assert_eq!(output.status.code(), Some(1));
        output.stdout
    };
    assert!(said("1") == said("2") && said("1") == said("5"));
    assert_eq!(terrabite(&["--max-error", "0.5", "--threads", "0"]).status.code(), Some(2));
}

#[test]
fn a_pass_and_a_failure_say_what_was_found() {
    let passed = String::from_utf8(terrabite(&["--max-error", "1"]).stdout).unwrap();
    assert!(passed.contains("6 samples, 4 vertices, 2 triangles"), "{passed}");
    assert!(passed.contains("PASS"), "{passed}");
    let failed = String::from_utf8(terrabite(&["--max-error", "0.5"]).stdout).unwrap();
    assert!(failed.contains("FAIL\n  1 sample is farther than 0.5: column 1, row 0 (1.5 -0.5)"), "{failed}");
    assert!(terrabite(&["--max-error", "0.5", "--quiet"]).stdout.is_empty());
}

#[test]
fn json_holds_the_whole_verdict() {
    let output = terrabite(&["--max-error", "0.5", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["passed"], false);
    assert_eq!(report["failures"].as_array().unwrap().len(), 1);
    assert_eq!((report["worst"]["error"].as_f64(), report["worst"]["column"].as_u64()), (Some(1.0), Some(1)));
    assert_eq!(report["double_area"], report["expected_double_area"]);
}

/// 4 × 3 samples, two in the middle without a height, and a mesh with these corners and faces.
fn scene_with_a_hole(dir: &tempfile::TempDir, corners: &[(f64, f64)], faces: &[[usize; 3]]) -> (PathBuf, PathBuf) {
    let (raster, mesh) = (dir.path().join("dem.tif"), dir.path().join("tin.ply"));
    let driver = DriverManager::get_driver_by_name("GTiff").unwrap();
    let dataset = driver.create_with_band_type::<i16, _>(&raster, 4, 3, 1).unwrap();
    dataset.rasterband(1).unwrap().set_no_data_value(Some(-1.0)).unwrap();
    let mut samples = Buffer::new((4, 3), vec![0i16, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0, 0]);
    dataset.rasterband(1).unwrap().write((0, 0), (4, 3), &mut samples).unwrap();
    dataset.close().unwrap();
    let vertices: String = corners.iter().map(|(x, y)| format!("{x} {y} 0\n")).collect();
    let triangles: String = faces.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")).collect();
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{vertices}{triangles}",
        corners.len(),
        faces.len(),
    );
    std::fs::write(&mesh, ply).unwrap();
    (raster, mesh)
}

#[test]
fn holes_up_to_a_size_are_to_be_bridged() {
    let dir = tempfile::tempdir().unwrap();
    let corners = [(0.5, -0.5), (3.5, -0.5), (3.5, -2.5), (0.5, -2.5)];
    let (raster, mesh) = scene_with_a_hole(&dir, &corners, &[[0, 2, 1], [0, 3, 2]]);
    let run = |samples: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_terrabite"));
        command.arg("verify").arg(&raster).arg(&mesh).args(["--max-error", "0", "--json", "--fill-holes", samples]);
        let output = command.output().unwrap();
        (output.status.code(), serde_json::from_slice::<serde_json::Value>(&output.stdout).ok())
    };
    let (code, report) = run("2");
    let report = report.unwrap();
    assert_eq!((code, report["filled_voids"].as_u64(), report["filled_samples"].as_u64()), (Some(0), Some(1), Some(2)));
    assert_eq!((report["samples"].as_u64(), report["missing_samples"].as_u64()), (Some(10), Some(0)));
    assert_eq!(run("1").0, Some(1));
    assert_eq!(run("0").1.unwrap()["touched_missing"]["count"].as_u64(), Some(2));
    assert_eq!(run("-1").0, Some(2));
}

#[test]
fn ground_near_samples_without_a_height_may_be_bare() {
    let dir = tempfile::tempdir().unwrap();
    // The half cell of the first corner, of four.
    let (raster, mesh) = scene_with_a_hole(&dir, &[(0.5, -0.5), (0.5, -1.5), (1.5, -0.5)], &[[0, 1, 2]]);
    let run = |args: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_terrabite"));
        let output =
            command.arg("verify").arg(&raster).arg(&mesh).args(["--max-error", "0"]).args(args).output().unwrap();
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, report, _) = run(&["--trim", "1", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!((code, report["trimmed_samples"].as_u64(), report["samples"].as_u64()), (Some(0), Some(7), Some(3)));
    assert!(run(&["--trim", "1"]).1.contains("trimmed, uncovered within 1 cell of missing samples: 7"));
    let (code, report, _) = run(&["--json"]);
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    assert_eq!((code, report.get("trim").is_none()), (Some(1), true));
    // A hole that is bridged leaves no strip.
    assert_eq!(run(&["--trim", "1", "--fill-holes", "2"]).0, Some(1));
    // Nor does one outside of the window.
    assert_eq!(run(&["--trim", "1", "--window", "0,0,4,2"]).0, Some(0));
    assert_eq!(run(&["--trim", "1", "--window", "0,0,4,1"]).0, Some(1));
    for wrong in ["1001", "1.5", "none"] {
        let (code, _, message) = run(&["--trim", wrong]);
        assert!(code == Some(2) && message.contains("--trim"), "{message}");
    }
}
