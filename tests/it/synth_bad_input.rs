//! `terrabite synth` and what it must refuse.

use crate::util::{Folder, terrabite, terrabite_with_file_limit};

#[test]
fn sizes_that_are_none() {
    let folder = Folder::new();
    for wrong in ["0x10", "10", "-5x10", "axb"] {
        terrabite(["synth", &folder.at("dem.tif"), "--size", wrong]).fails(2, &["--size"]);
    }
    let code = terrabite(["synth", &folder.at("dem.tif"), "--size", "1x9"]).code;
    assert!(matches!(code, Some(1 | 2)), "{code:?}");
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn outputs_that_cannot_be_made() {
    let folder = Folder::new();
    let nowhere = folder.at("none/dem.tif");
    terrabite(["synth", &nowhere, "--size", "64x64"]).fails(1, &[&nowhere, "folder"]);
    let precious = folder.with("dem.tif", "precious");
    terrabite(["synth", &precious, "--size", "64x64"]).fails(1, &[&precious, "--overwrite"]);
    assert_eq!(std::fs::read(&precious).unwrap(), b"precious");
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn a_full_disk() {
    let folder = Folder::new();
    let dem = folder.at("dem.tif");
    let run = terrabite_with_file_limit(128, ["synth", &dem, "--size", "512x512"]);
    run.fails(1, &["dem.tif"]);
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn the_same_seed_gives_the_same_terrain() {
    let folder = Folder::new();
    let bytes = |name: &str, seed| {
        terrabite(["synth", &folder.at(name), "--size", "100x80", "--seed", seed]).succeeds();
        std::fs::read(folder.join(name)).unwrap()
    };
    assert!(bytes("a.tif", "7") == bytes("b.tif", "7"));
    assert!(bytes("c.tif", "7") != bytes("d.tif", "8"));
    let info = terrabite(["info", &folder.at("a.tif"), "--json"]).succeeds().json();
    assert_eq!((&info["width"], &info["height"], &info["georeferenced"]), (&100.into(), &80.into(), &true.into()));
}
