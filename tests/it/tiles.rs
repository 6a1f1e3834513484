//! `tiles` and `tiles-verify` as users run them, and tiles in a decoder that others wrote.

use std::path::Path;
use std::process::Command;

use crate::readers;
use crate::util::{Dem, Folder, Kind, Run, hills, terrabite};

/// In Switzerland, with cells of half a kilometre.
fn dem(folder: &Folder) -> String {
    let heights = |column, row| 500.0 + 10.0 * hills(column, row);
    let place = [8.0, 0.005, 0.0, 46.5, 0.0, -0.005];
    Dem::new(40, 30).kind(Kind::Float32).heights(heights).geo_transform(place).epsg(4326).write(folder, "dem.tif")
}

#[test]
fn a_set_is_made_judged_and_replaced() {
    let folder = Folder::new();
    let (dem, out) = (dem(&folder), folder.at("out"));
    let made = terrabite(["tiles", &dem, &out, "--max-error", "100"]).succeeds();
    assert!(made.out.contains("taken as ellipsoidal") && made.out.contains("resampled surface"), "{made:#?}");
    let judged = terrabite(["tiles-verify", &dem, &out]).succeeds();
    assert!(judged.out.ends_with("passed\n"), "{judged:#?}");
    terrabite(["tiles", &dem, &out, "--max-error", "100"]).fails(1, &["an earlier set of tiles", "--overwrite"]);
    let json =
        terrabite(["tiles", &dem, &out, "--max-error", "200", "--overwrite", "--gzip", "--json", "--fine-heights"]);
    assert_eq!(json.succeeds().json()["levels"][0]["tiles"], 2);
    let promise = std::fs::read_to_string(folder.join("out/terrabite.json")).expect("a file");
    assert!(promise.contains("\"fine_heights\": true"), "{promise}");
    let verdict = terrabite(["tiles-verify", &dem, &out, "--json"]).succeeds().json();
    assert!(verdict["levels"][0]["own_samples"]["samples"].as_u64() > Some(1000), "{verdict}");
    // A tile that is gone: exit code 1, and the reason.
    std::fs::remove_file(folder.join("out/0/0/0.terrain")).expect("removed");
    let judged = terrabite(["tiles-verify", &dem, &out]);
    assert_eq!(judged.code, Some(1), "{judged:#?}");
    assert!(judged.out.contains("tile 0/0/0 is missing") && judged.out.ends_with("NOT passed\n"), "{judged:#?}");
    assert_eq!(folder.names(), ["dem.tif", "out"]);
}

#[test]
fn what_cannot_be_done_is_said_with_the_way_out() {
    let folder = Folder::new();
    let nowhere = Dem::new(20, 20).write(&folder, "nowhere.tif");
    let out = folder.at("out");
    terrabite(["tiles", &nowhere, &out, "--max-error", "10"]).fails(1, &["nowhere.tif", "geotransform", "-a_srs"]);
    let dem = dem(&folder);
    let grid = ["tiles", &dem, &out, "--max-error", "100", "--vertical-crs", "EPSG:3855"];
    terrabite(grid).fails(1, &["dem.tif", "us_nga_egm08_25.tif", "projinfo -s \"EPSG:4326+3855\"", "--vertical-crs"]);
    terrabite(["tiles", &dem, &out, "--max-error", "0"]).fails(2, &["--max-error", "0.001"]);
    terrabite(["tiles", &dem, &out, "--max-error", "100", "--max-level", "20"]).fails(1, &["--max-level"]);
    let strays = |factor| ["tiles", &dem, &out, "--max-error", "1000", "--own-samples", "--max-stray", factor];
    terrabite(strays("1.5")).fails(2, &["--max-stray 1.5 cannot be combined with --own-samples", "remove"]);
    terrabite(strays("inf")).succeeds();
    std::fs::remove_dir_all(&out).unwrap();
    terrabite(["tiles-verify", &dem, folder.path().to_str().expect("a path")]).fails(1, &["terrabite.json"]);
    let infinite = |c, r| if (c, r) == (7, 5) { f64::INFINITY } else { 3.0 };
    let place = [8.0, 0.005, 0.0, 46.5, 0.0, -0.005];
    let infinite = Dem::new(20, 20).kind(Kind::Float32).heights(infinite).geo_transform(place).epsg(4326);
    let infinite = infinite.write(&folder, "infinite.tif");
    let refused = ["tiles", &infinite, &out, "--max-error", "100"];
    terrabite(refused).fails(1, &["infinite.tif", "found inf at column 7, row 5", "--nodata inf"]);
    assert!(!Path::new(&out).exists());
}

/// A level above the finest that has all that clients expect gets more by --error-factor alone, and only who has asked for fine heights
/// can do without.
#[test]
fn a_refusal_names_the_option_that_mends_it() {
    let folder = Folder::new();
    let (dem, out) = (dem(&folder), folder.at("out"));
    let refused = |error: &str, options: &[&str], words: &[&str], not: &str| {
        let run = terrabite(["tiles", &dem, &out, "--max-error", error].iter().chain(options));
        let run = run.fails(1, words);
        assert!(!run.err.contains(not), "{run:#?}");
    };
    refused("100", &["--error-factor", "0.01"], &["sag under", "choose a larger --error-factor"], "--max-error");
    terrabite(["tiles", &dem, &out, "--max-error", "100", "--error-factor", "0.1", "-q"]).succeeds();
    std::fs::remove_dir_all(&out).unwrap();
    let finer = ["--grid-factor", "4"];
    refused("0.01", &finer, &["can be written in steps of", "choose a larger --max-error"], "--fine-heights");
    let fine = ["--fine-heights", "--grid-factor", "4"];
    refused("0.05", &fine, &["steps of 0.125 m", "without --fine-heights steps are smaller"], "--error-factor");
    // Where the sky is the limit, a decimal without end is not.
    let stray = terrabite(["tiles", &dem, &out, "--max-error", "100", "--max-stray", "1e400"]);
    stray.fails(2, &["--max-stray", "1e400 is beyond 1.7976931348623157e308", "inf sets no limit"]);
    let nodata = terrabite(["tiles", &dem, &out, "--max-error", "100", "--nodata", "1e400"]);
    nodata.fails(2, &["dem.tif", "found 1e400", "inf"]);
}

/// PyPI's quantized-mesh-tile decodes every tile to the vertices and triangles that are in it.
#[test]
fn another_decoder_finds_the_same() {
    if readers::are_skipped() {
        return;
    }
    let folder = Folder::new();
    let (dem, out) = (dem(&folder), folder.at("out"));
    terrabite(["tiles", &dem, &out, "--max-error", "100", "--outside", "700"]).succeeds();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/it/tiles.py");
    let decoded = Run::of(Command::new(readers::python()).arg(script).arg(&out));
    assert_eq!(decoded.code, Some(0), "{decoded:#?}");
    assert!(decoded.out.starts_with("agreed: "), "{decoded:#?}");
}
