//! `terrabite verify` and what it must refuse, and what it must not let pass.

use crate::util::{Dem, Folder, Kind, flat, ply, terrabite, terrabite_disturbed, with_both};

#[test]
fn a_fitting_mesh_passes() {
    let (_folder, dem, tin) = with_both();
    terrabite(["verify", &dem, &tin, "--max-error", "0"]).succeeds();
    let report = terrabite(["verify", &dem, &tin, "--max-error", "0", "--json"]).succeeds().json();
    assert!(report.is_object(), "{report}");
}

#[test]
fn files_that_are_missing_or_something_else() {
    let (folder, dem, tin) = with_both();
    let missing = folder.at("none");
    let text = folder.with("notes.txt", "no mesh, no raster");
    let empty = folder.with("empty.ply", "");
    for wrong in [&missing, &text] {
        terrabite(["verify", wrong, &tin, "--max-error", "1"]).fails(1, &[wrong]);
    }
    for wrong in [&missing, &text, &empty, &dem] {
        terrabite(["verify", &dem, wrong, "--max-error", "1"]).fails(1, &[wrong]);
    }
}

#[test]
fn meshes_cut_off_at_any_point() {
    let (folder, dem, tin) = with_both();
    let bytes = std::fs::read(&tin).unwrap();
    for keep in [3, 40, 150, bytes.len() - 40, bytes.len() - 1] {
        let cut = folder.with("cut.ply", &bytes[..keep]);
        terrabite(["verify", &dem, &cut, "--max-error", "1"]).fails(1, &[&cut]);
    }
}

/// Another process cuts either file while the verifier sorts what it has read of the mesh.
#[test]
fn files_that_are_truncated_under_the_run() {
    let (folder, temp) = (Folder::new(), Folder::new());
    let rough = |c: usize, r: usize| ((c * 7919 + r * 104_729) % 1009) as f64;
    let dem = Dem::new(700, 700).heights(rough).compressed().tiled(128).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let options = ["--max-error", "3", "--temp-dir", &temp.at("")];
    terrabite(["simplify", &dem, &tin, "--quality", "none"].iter().chain(&options)).succeeds();
    for file in [&tin, &dem] {
        let copy = std::fs::read(file).unwrap();
        let cut = || std::fs::OpenOptions::new().write(true).open(file).and_then(|f| f.set_len(50_000)).is_ok();
        let run = terrabite_disturbed(["verify", &dem, &tin].iter().chain(&options), cut);
        run.fails(1, &[file]);
        assert_eq!(temp.names(), [""; 0]);
        std::fs::write(file, copy).unwrap();
    }
}

#[test]
fn faces_that_name_no_vertex() {
    let (folder, dem, _) = with_both();
    let corners = [[0.5, -0.5, 3.0], [0.5, -9.5, 3.0], [19.5, -9.5, 3.0]];
    let wild = folder.with("wild.ply", ply(&corners, &[[0, 1, 3]]));
    terrabite(["verify", &dem, &wild, "--max-error", "1"]).fails(1, &[&wild]);
}

#[test]
fn what_does_not_fit_does_not_pass() {
    let (folder, dem, _) = with_both();
    let corners = [[0.5, -0.5, 3.0], [0.5, -9.5, 3.0], [19.5, -9.5, 3.0], [19.5, -0.5, 3.0]];
    for (name, mesh) in [
        ("too high", flat(20, 10, 4.5)),
        ("too small", flat(19, 10, 3.0)),
        ("half", ply(&corners, &[[0, 1, 2]])),
        ("upside down", ply(&corners, &[[0, 2, 1], [0, 3, 2]])),
        ("twice", ply(&corners, &[[0, 1, 2], [0, 2, 3], [0, 2, 3]])),
        ("folded", ply(&corners, &[[0, 1, 2], [0, 1, 3]])),
        ("not a number", ply(&corners.map(|[x, y, _]| [x, y, f64::NAN]), &[[0, 1, 2], [0, 2, 3]])),
        ("no triangles", ply(&corners, &[])),
    ] {
        let mesh = folder.with("tin.ply", mesh);
        let run = terrabite(["verify", &dem, &mesh, "--max-error", "1"]);
        assert!(run.code == Some(1) && !run.err.contains("panicked"), "{name}: {run:#?}");
    }
}

#[test]
fn options_out_of_range() {
    let (_folder, dem, tin) = with_both();
    for wrong in ["-1", "nan", "inf", "five"] {
        terrabite(["verify", &dem, &tin, "--max-error", wrong]).fails(2, &["--max-error", "expected"]);
    }
    terrabite(["verify", &dem, &tin, "--max-error", "1", "--band", "2"]).fails(1, &[&dem, "bands 1 to 1", "--band"]);
    terrabite(["verify", &dem]).fails(2, &["Usage"]);
}

/// 4 × 3 samples at height 3 with a gap in the corner, and a mesh of the eleven others.
fn with_a_gap() -> (Folder, String, String) {
    let folder = Folder::new();
    let heights = |column, row| if (column, row) == (3, 0) { -7.0 } else { 3.0 };
    let dem = Dem::new(4, 3).heights(heights).nodata(99.0).write(&folder, "dem.tif");
    let corners = [(0, 0), (2, 0), (3, 1), (3, 2), (0, 2)].map(|(c, r)| [f64::from(c) + 0.5, -f64::from(r) - 0.5, 3.0]);
    let tin = folder.with("tin.ply", ply(&corners, &[[0, 4, 1], [1, 4, 3], [1, 3, 2]]));
    (folder, dem, tin)
}

#[test]
fn the_mark_of_nodata_can_be_given() {
    let (folder, dem, tin) = with_a_gap();
    let verify =
        |tin: &str, nodata: &str| terrabite(["verify", &dem, tin, "--max-error", "0", "--nodata", nodata, "--json"]);
    let report = verify(&tin, "-7").succeeds().json();
    let count = |name: &str| report[name].as_u64();
    assert_eq!((count("raster_samples"), count("samples"), count("missing_samples")), (Some(12), Some(11), Some(1)));
    assert_eq!(report["isolated_samples"].as_u64(), Some(0));
    let text = terrabite(["verify", &dem, &tin, "--max-error", "0", "--nodata=-7"]).succeeds().out;
    assert!(text.contains("ground: 11 samples; missing: 1\n"), "{text}");
    // By its tag the raster has heights everywhere.
    let failed = verify(&tin, "99");
    assert_eq!((failed.code, failed.json()["uncovered"]["count"].as_u64()), (Some(1), Some(1)));
    let whole = folder.with("whole.ply", flat(4, 3, 3.0));
    let failed = verify(&whole, "-7");
    assert_eq!((failed.code, failed.json()["touched_missing"]["count"].as_u64()), (Some(1), Some(1)));
    verify(&tin, "nothing").fails(2, &["--nodata", "expected a nodata value"]);
    let png = folder.at("out.png");
    terrabite(["preview", &dem, &tin, &png, "--mode", "error", "--nodata", "-7"]).succeeds();
}

#[test]
fn bands_of_bytes_with_alpha_have_ground_where_they_are_opaque() {
    let folder = Folder::new();
    let alpha = |_, column, row| if (column, row) == (3, 0) { 0.0 } else { 255.0 };
    let dem = Dem::new(4, 3).kind(Kind::Byte).bands(2).heights(|_, _| 3.0).others(alpha).option("ALPHA=YES");
    let dem = dem.write(&folder, "dem.tif");
    let (_gap, _, tin) = with_a_gap();
    let report = terrabite(["verify", &dem, &tin, "--max-error", "0", "--json"]).succeeds().json();
    assert_eq!(report["missing_samples"].as_u64(), Some(1));
    let text = terrabite(["info", &dem]).succeeds().out;
    assert!(text.contains("nodata        what a mask or alpha band says"), "{text}");
}
