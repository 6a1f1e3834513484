//! `--channels`, `--emphasis` and `--planar`: what is refused, and what `verify` makes of a mesh with colours.

use crate::util::{Dem, Folder, Kind, terrabite};

/// Three bands of bytes, all of them this.
fn grey(column: usize, row: usize) -> f64 {
    (10 * column + row) as f64
}

fn with_image() -> (Folder, String) {
    let folder = Folder::new();
    let image = Dem::new(20, 10).kind(Kind::Byte).bands(3).heights(grey).write(&folder, "image.tif");
    (folder, image)
}

/// The corners of the image as two flat triangles, with their colours made darker by `darker`.
fn coloured(darker: f64) -> String {
    let corner = |(x, y, column, row): (f64, f64, usize, usize)| {
        let grey = grey(column, row) - darker;
        format!("{x} {y} 0 {grey} {grey} {grey}\n")
    };
    let corners = [(0.5, -0.5, 0, 0), (0.5, -9.5, 0, 9), (19.5, -9.5, 19, 9), (19.5, -0.5, 19, 0)].map(corner).concat();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
        property float red\nproperty float green\nproperty float blue\nelement face 2\n\
        property list uchar uint vertex_indices\nend_header\n";
    format!("{header}{corners}3 0 1 2\n3 0 2 3\n")
}

#[test]
fn channels_need_an_engine_that_keeps_them() {
    let (folder, image) = with_image();
    let tin = folder.at("tin.ply");
    for channels in [&["--channels", "2,3"][..], &["--planar"], &["--planar", "--channels", "3"]] {
        let run = ["simplify", &image, &tin, "--max-error", "1"].into_iter().chain(channels.iter().copied());
        terrabite(run).fails(2, &["greedy cuts", "--engine greedy-insertion"]);
    }
    assert_eq!(folder.names(), ["image.tif"]);
}

#[test]
fn bands_and_emphases_that_are_none() {
    let (folder, image) = with_image();
    let tin = folder.with("tin.ply", coloured(0.0));
    let output = folder.at("new.ply");
    for command in [["simplify", &image, &output], ["verify", &image, &tin]] {
        let refused = |options: &[&str], code, words: &[&str]| {
            let arguments = command.iter().copied().chain(["--max-error", "1"]).chain(options.iter().copied());
            terrabite(arguments).fails(code, words);
        };
        refused(&["--channels", "2,4"], 1, &[&image, "band 4", "bands 1 to 3", "--channels"]);
        for wrong in ["0", "2,2", "two", "", "2-3"] {
            refused(&["--channels", wrong], 2, &["--channels", "expected"]);
        }
        for wrong in ["-0.1", "1.5", "nan", "much"] {
            refused(&["--channels", "2", "--emphasis", wrong], 2, &["--emphasis", "from 0 to 1"]);
        }
        refused(&["--emphasis", "0.5"], 2, &["--channels"]);
        refused(&["--planar", "--channels", "2", "--emphasis", "0.5"], 2, &["--planar"]);
        refused(&["--planar", "--band", "2"], 2, &["--planar"]);
    }
    assert_eq!(folder.names(), ["image.tif", "tin.ply"]);
}

#[test]
fn samples_without_a_value_are_refused_by_band() {
    let (folder, _) = with_image();
    let hole = |c: usize, r: usize| if (c, r) == (7, 5) { f64::NAN } else { 3.0 };
    let strange = Dem::new(20, 10).kind(Kind::Float32).bands(2).heights(hole).write(&folder, "strange.tif");
    let tin = folder.with("tin.ply", coloured(0.0).replace("red", "band_2"));
    terrabite(["verify", &strange, &tin, "--max-error", "1", "--planar", "--channels", "2"])
        .fails(1, &[&strange, "row 5"]);
}

#[test]
fn verify_judges_colours() {
    let (folder, image) = with_image();
    let tin = folder.with("tin.ply", coloured(0.0));
    let exact = terrabite(["verify", &image, &tin, "--max-error", "1e-9", "--planar"]).succeeds();
    assert!(exact.out.contains("max weighted error") && exact.out.contains("PASS"), "{exact:#?}");
    let tin = folder.with("tin.ply", coloured(3.0));
    let judge = |tolerance| terrabite(["verify", &image, &tin, "--max-error", tolerance, "--planar", "--json"]);
    let passed = judge("3").json();
    assert!((passed["extended"]["worst"]["error"].as_f64().unwrap() - 3.0).abs() < 1e-12, "{passed}");
    let failed = judge("2.9");
    assert_eq!((failed.code, &failed.json()["extended"]["above_tolerance"]["count"]), (Some(1), &200.into()));
    // Heights alone do not ask for attributes, and a report without channels does not speak of them.
    let plain = terrabite(["verify", &image, &tin, "--max-error", "300", "--json"]).succeeds().json();
    assert!(plain.get("extended").is_none());
    // With heights: (1 − 0.25)·|Δz| and a quarter of the colours' share of the range of heights, 199.
    let weighted =
        ["verify", &image, &tin, "--max-error", "300", "--channels", "1,2,3", "--emphasis", "0.25", "--json"];
    let found = terrabite(weighted).succeeds().json()["extended"]["worst"]["error"].as_f64().unwrap();
    let expected = 0.75 * 199.0 + 0.25 * 199.0 * 3.0 / 255.0;
    assert!((found - expected).abs() < 1e-9, "{found} against {expected}");
}

#[test]
fn attributes_that_are_missing_are_named() {
    let (folder, image) = with_image();
    let tin = folder.with("tin.ply", coloured(0.0).replace("property float green", "property float grün"));
    terrabite(["verify", &image, &tin, "--max-error", "1", "--planar"]).fails(1, &[&tin, "property green"]);
    terrabite(["preview", &image, &tin, &folder.at("out.png"), "--mode", "colour"]).fails(1, &[&tin, "property green"]);
    assert_eq!(folder.names(), ["image.tif", "tin.ply"]);
}
