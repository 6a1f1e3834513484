//! `terrabite simplify` on every kind of raster: `verify`, which shares no code with the engines, must pass the file.

use crate::util::{Dem, Folder, Kind, shared_data, terrabite};

/// Simplifies and verifies; gives the number of triangles.
#[track_caller]
fn certified(folder: &Folder, dem: &str, tolerance: &str, options: &[&str]) -> u64 {
    let tin = folder.at("tin.ply");
    let simplify = ["simplify", dem, &tin, "--max-error", tolerance, "--overwrite", "--json"];
    let report = terrabite(simplify.iter().chain(options)).succeeds().json();
    terrabite(["verify", dem, &tin, "--max-error", tolerance]).succeeds();
    report["triangles"].as_u64().unwrap()
}

#[test]
fn every_type_in_every_layout_gives_the_same_mesh() {
    use Kind::*;
    let folder = Folder::new();
    let mut counts = Vec::new();
    for kind in [Byte, SignedByte, UInt16, Int16, UInt32, Int32, UInt64, Int64, Float32, Float64] {
        let plain = Dem::new(70, 50).kind(kind).on_the_map();
        for dem in [
            plain.clone().stripped(7),
            plain.clone().tiled(16),
            plain.clone().compressed().tiled(32),
            plain.clone().big_endian(),
        ] {
            let path = dem.write(&folder, "dem.tif");
            counts.push(certified(&folder, &path, "2", &[]));
            std::fs::remove_file(path).unwrap();
        }
    }
    assert!(counts.iter().all(|c| *c == counts[0]), "{counts:?}");
}

#[test]
fn scale_offset_and_other_formats() {
    let folder = Folder::new();
    certified(&folder, &Dem::new(70, 50).scaling(0.1, -500.0).write(&folder, "scaled.tif"), "0.2", &[]);
    certified(&folder, &Dem::new(70, 50).driver("HFA").write(&folder, "dem.img"), "2", &[]);
    certified(&folder, &Dem::new(70, 50).driver("EHdr").write(&folder, "dem.bil"), "2", &[]);
    certified(&folder, &Dem::new(70, 50).nodata(-9999.0).write(&folder, "tag-only.tif"), "2", &[]);
}

#[test]
fn geotransforms_of_every_sort() {
    let folder = Folder::new();
    for coefficients in [
        [0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        [-71.0, 1.0 / 1200.0, 0.0, -32.0, 0.0, -1.0 / 1200.0],
        [5e5, 8.0, 6.0, 5.2e6, 6.0, -8.0],
        [5e5, -10.0, 0.0, 5.2e6, 0.0, -10.0],
    ] {
        let dem = Dem::new(40, 30).geo_transform(coefficients).write(&folder, "dem.tif");
        certified(&folder, &dem, "2", &["--tile", "16"]);
        std::fs::remove_file(dem).unwrap();
    }
}

#[test]
fn the_smallest_and_the_thinnest() {
    let folder = Folder::new();
    for (width, height) in [(2, 2), (2, 200), (200, 2), (3, 3)] {
        let dem = Dem::new(width, height).write(&folder, "dem.tif");
        certified(&folder, &dem, "0", &[]);
        certified(&folder, &dem, "1000", &["--tile", "16"]);
    }
}

#[test]
fn a_flat_sea_is_two_triangles() {
    let folder = Folder::new();
    let sea = Dem::new(64, 48).heights(|_, _| 3.0).write(&folder, "sea.tif");
    assert_eq!(certified(&folder, &sea, "0", &["--tile", "0"]), 2);
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = Folder::new();
    let dem = Dem::new(200, 150).compressed().tiled(32).write(&folder, "dem.tif");
    let bytes = |threads: &str| {
        certified(&folder, &dem, "3", &["--tile", "32", "--threads", threads]);
        std::fs::read(folder.join("tin.ply")).unwrap()
    };
    assert!(bytes("1") == bytes("2"));
}

#[test]
fn nothing_but_the_output_is_left() {
    let folder = Folder::new();
    let temp = Folder::new();
    let dem = Dem::new(100, 80).compressed().write(&folder, "dem.tif");
    let run = ["simplify", &dem, &folder.at("tin.ply"), "--max-error", "2", "--temp-dir", &temp.at(""), "--quiet"];
    let run = terrabite(run).succeeds();
    assert_eq!(run.err, "");
    assert_eq!(folder.names(), ["dem.tif", "tin.ply"]);
    assert_eq!(temp.names(), [""; 0]);
}

#[test]
fn a_real_terrain() {
    let Some(dem) = shared_data("crater_lake_garland.tif") else { return };
    let folder = Folder::new();
    for feasibility in ["weak", "strong"] {
        certified(&folder, dem.to_str().unwrap(), "20", &["--feasibility", feasibility]);
    }
}
