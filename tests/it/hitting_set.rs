//! `simplify --engine hitting-set` and its options.

use crate::util::{Dem, Folder, terrabite};

#[test]
fn every_variant_passes_and_is_the_same_for_any_number_of_threads() {
    let folder = Folder::new();
    let dem = Dem::new(90, 70).on_the_map().write(&folder, "dem.tif");
    for options in [
        vec![],
        vec!["--quality", "none", "--stitching", "shared"],
        vec!["--squares", "sliding", "--feasibility", "strong"],
        vec!["--corners", "free", "--heights", "fitted"],
    ] {
        let [one, two] = ["1", "2"].map(|threads| {
            let tin = folder.at(&format!("{threads}.ply"));
            let run =
                ["simplify", &dem, &tin, "--overwrite", "--engine", "hitting-set", "--max-error", "2", "--tile", "32"];
            terrabite(run.iter().chain(&options).chain(&["--threads", threads])).succeeds();
            let straying = if options.contains(&"none") { "inf" } else { "1.5" };
            terrabite(["verify", &dem, &tin, "--max-error", "2", "--max-stray", straying]).succeeds();
            std::fs::read(tin).expect("a mesh")
        });
        assert!(one == two, "{options:?}");
    }
}

#[test]
fn options_of_others_are_usage_errors() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(20, 20).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let fails = |options: &[&str], message: &[&str]| {
        terrabite(["simplify", &dem, &tin].iter().chain(options)).fails(2, message);
        assert!(!std::path::Path::new(&tin).exists());
    };
    let engine = ["--engine", "hitting-set"];
    fails(&[&engine[..], &["--max-error", "1", "--swap", "delaunay"]].concat(), &["--swap delaunay", "hitting-set"]);
    fails(
        &[&engine[..], &["--max-error", "1", "--corners", "free"]].concat(),
        &["--corners free requires --heights fitted"],
    );
    fails(&["--max-error", "1", "--squares", "nested"], &["--squares requires --engine hitting-set"]);
}
