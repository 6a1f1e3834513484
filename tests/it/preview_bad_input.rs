//! `terrabite preview` and what it must refuse.

use crate::util::{terrabite, with_both};

#[test]
fn draws_a_picture() {
    let (folder, dem, tin) = with_both();
    terrabite(["preview", &dem, &tin, &folder.at("tin.png")]).succeeds();
    assert!(std::fs::read(folder.join("tin.png")).unwrap().starts_with(b"\x89PNG"));
    assert_eq!(folder.names(), ["dem.tif", "tin.ply", "tin.png"]);
}

#[test]
fn inputs_that_are_missing_or_something_else() {
    let (folder, dem, tin) = with_both();
    let (missing, picture) = (folder.at("none"), folder.at("tin.png"));
    let text = folder.with("notes.txt", "no mesh, no raster");
    let before = folder.names();
    for wrong in [&missing, &text] {
        terrabite(["preview", wrong, &tin, &picture]).fails(1, &[wrong]);
        terrabite(["preview", &dem, wrong, &picture]).fails(1, &[wrong]);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn outputs_that_cannot_be_made() {
    let (folder, dem, tin) = with_both();
    let nowhere = folder.at("none/tin.png");
    terrabite(["preview", &dem, &tin, &nowhere]).fails(1, &[&nowhere, "folder"]);
    let precious = folder.with("tin.png", "precious");
    terrabite(["preview", &dem, &tin, &precious]).fails(1, &[&precious, "--overwrite"]);
    for input in [&dem, &tin] {
        let before = std::fs::read(input).unwrap();
        terrabite(["preview", &dem, &tin, input, "--format", "png", "--overwrite"])
            .fails(1, &[input, "same file as the input"]);
        assert_eq!(std::fs::read(input).unwrap(), before);
    }
    assert_eq!(std::fs::read(&precious).unwrap(), b"precious");
    assert_eq!(folder.names(), ["dem.tif", "tin.ply", "tin.png"]);
}
