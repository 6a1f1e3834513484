//! The library without its default features.

use std::process::Command;

/// `make test` builds the example `array` with it, which simplifies and verifies an array.
#[test]
fn the_core_needs_no_gdal_no_command_line_and_no_pictures() {
    let tree = |features: &[&str]| {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
        cargo.args(["tree", "--offline", "--locked", "--edges", "normal", "--prefix", "none"]).args(features);
        let output = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let outside = ["gdal", "gdal-sys", "clap", "indicatif", "signal-hook", "png", "tiny-skia", "colorous"];
    let named = |tree: &str, name: &str| tree.lines().any(|line| line.split(' ').next() == Some(name));
    let (core, whole) = (tree(&["--no-default-features"]), tree(&[]));
    for name in outside {
        assert!(named(&whole, name) && !named(&core, name), "{name}");
    }
}
