//! The house from outside: the library without its default features, and what its files begin with.

use std::process::Command;

/// `make test` builds the example `array` with it, which simplifies and verifies an array.
#[test]
fn the_core_needs_no_gdal_no_command_line_and_no_pictures() {
    let tree = |features: &[&str]| {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        // Not offline: what the Python package alone needs may not be here yet.
        cargo.args(["tree", "--locked", "--edges", "normal", "--prefix", "none"]).args(features);
        let output = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let outside = ["gdal", "gdal-sys", "clap", "indicatif", "signal-hook", "png", "tiny-skia", "colorous"];
    let named = |tree: &str, name: &str| tree.lines().any(|line| line.split(' ').next() == Some(name));
    let (core, whole) = (tree(&["--no-default-features"]), tree(&[]));
    // Features of two packages that are built together are those of both.
    let python = tree(&["-p", "terrabite-python"]);
    for name in outside {
        assert!(named(&whole, name) && !named(&core, name) && !named(&python, name), "{name}");
    }
}

/// A visitor of a file is told what it is for.
#[test]
fn every_source_file_begins_with_a_line_that_says_what_it_is_for() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders: Vec<_> =
        ["src", "tests", "benches", "examples", "fuzz/fuzz_targets", "python/src"].map(|f| root.join(f)).into();
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for path in folder.read_dir().unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                files += 1;
                assert!(std::fs::read_to_string(&path).unwrap().starts_with("//! "), "{}", path.display());
            }
        }
    }
    assert!(files > 200, "{files} files");
}
