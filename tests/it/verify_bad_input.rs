//! `terrabite verify` and what it must refuse, and what it must not let pass.

use crate::util::{flat, ply, terrabite, with_both};

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
