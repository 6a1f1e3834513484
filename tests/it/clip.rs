//! `--window` and `--bbox`: a part of a raster.

use crate::util::{Dem, Folder, Kind, Run, terrabite};

/// A raster and the part of it, cut out by hand, from column 13 and row 7 on.
fn simplified(folder: &Folder, dem: &str, options: &[&str]) -> (Run, Vec<u8>) {
    let tin = folder.at("tin.ply");
    let all = ["simplify", dem, &tin, "--max-error", "2", "--overwrite", "--json"];
    let run = terrabite(all.iter().copied().chain(options.iter().copied())).succeeds();
    (run, std::fs::read(folder.join("tin.ply")).unwrap())
}

/// What follows the header.
fn body(ply: &[u8]) -> &[u8] {
    let end = b"end_header\n";
    let at = ply.windows(end.len()).position(|w| w == end).unwrap();
    &ply[at + end.len()..]
}

fn ways() -> [(&'static str, Dem); 5] {
    let dem = Dem::new(90, 70).on_the_map();
    [
        ("in-place", dem.clone()),
        ("in-place", dem.clone().tiled(32).kind(Kind::Float32)),
        ("windows", dem.clone().tiled(16).compressed()),
        ("decode", dem.clone().stripped(5).compressed()),
        ("windows", dem.bands(3)),
    ]
}

#[test]
fn a_window_is_meshed_in_every_way_of_reading_and_judged_as_such() {
    let folder = Folder::new();
    let mut bodies = Vec::new();
    for (access, dem) in ways() {
        let dem = dem.write(&folder, "dem.tif");
        let (run, ply) = simplified(&folder, &dem, &["--window", "13,7,61,50", "--access", access, "--tile", "24"]);
        assert_eq!(run.json()["samples"], 61 * 50);
        assert_eq!(run.json()["window"], serde_json::json!([13, 7, 61, 50]));
        let header = String::from_utf8_lossy(&ply[..300]).into_owned();
        assert!(header.contains("comment window 13,7,61,50\n"), "{header}");
        let tin = folder.at("tin.ply");
        terrabite(["verify", &dem, &tin, "--max-error", "2", "--window", "13,7,61,50"]).succeeds();
        let other = terrabite(["verify", &dem, &tin, "--max-error", "2", "--window", "12,7,61,50"]);
        assert_eq!(other.code, Some(1), "{other:?}");
        bodies.push(body(&ply).to_vec());
    }
    assert!(bodies.iter().all(|b| *b == bodies[0]));
}

/// Not so in general: a window counts its tiles from its own corner. In one tile there are the same triangles.
#[test]
fn a_window_is_the_raster_cut_out_beforehand() {
    fn shifted(column: usize, row: usize) -> f64 {
        crate::util::hills(column + 13, row + 7)
    }
    let folder = Folder::new();
    let dem = Dem::new(90, 70).on_the_map().write(&folder, "dem.tif");
    let cut = Dem::new(61, 50).heights(shifted).on_the_map();
    let cut = cut.geo_transform([500_130.0, 10.0, 0.0, 5_199_930.0, 0.0, -10.0]).write(&folder, "cut.tif");
    let (_, whole) = simplified(&folder, &dem, &["--window", "13,7,61,50"]);
    let (_, part) = simplified(&folder, &cut, &[]);
    assert_eq!(body(&whole), body(&part));
}

#[test]
fn a_box_holds_the_samples_inside_it() {
    let folder = Folder::new();
    let dem = Dem::new(90, 70).on_the_map().write(&folder, "dem.tif");
    let window = |options: &[&str]| simplified(&folder, &dem, options).0.json()["window"].clone();
    // Samples lie on 500 005 + 10·column, 5 199 995 − 10·row.
    assert_eq!(window(&["--bbox", "500135,5199435,500735,5199925"]), serde_json::json!([13, 7, 61, 50]));
    assert_eq!(window(&["--bbox", "500126,5199426,500744,5199934"]), serde_json::json!([13, 7, 61, 50]));
    assert_eq!(window(&["--bbox", "0,0,500735,9999999"]), serde_json::json!([0, 0, 74, 70]));
    // The whole of it is no window.
    assert_eq!(window(&["--bbox", "-1e9,-1e9,1e9,1e9"]), serde_json::Value::Null);
    // The same box in longitude and latitude, a little larger for its bent sides.
    let degrees = ["--bbox", "15.00177,46.94844,15.00966,46.95286", "--bbox-crs", "EPSG:4326"];
    let found = window(&degrees);
    for (found, expected) in found.as_array().unwrap().iter().zip([13, 7, 61, 50]) {
        assert!(found.as_i64().unwrap().abs_diff(expected) <= 2, "{found}: {expected}");
    }
}

#[test]
fn turned_and_upside_down_rasters_have_boxes_too() {
    let folder = Folder::new();
    for c in [[500_000.0, 8.0, 6.0, 5.2e6, 6.0, -8.0], [500_000.0, 10.0, 0.0, 5.2e6, 0.0, 10.0]] {
        let dem = Dem::new(60, 60).geo_transform(c).write(&folder, "dem.tif");
        // The place of column 30, row 25.
        let (x, y) = (c[0] + 30.5 * c[1] + 25.5 * c[2], c[3] + 30.5 * c[4] + 25.5 * c[5]);
        let bounds = format!("{},{},{},{}", x - 30.0, y - 30.0, x + 30.0, y + 30.0);
        let (run, _) = simplified(&folder, &dem, &["--bbox", &bounds]);
        let window = run.json()["window"].clone();
        let n: Vec<i64> = window.as_array().unwrap().iter().map(|n| n.as_i64().unwrap()).collect();
        assert!(n[0] <= 27 && n[0] + n[2] > 33 && n[1] <= 22 && n[1] + n[3] > 28 && n[2] < 11 && n[3] < 11, "{n:?}");
        let tin = folder.at("tin.ply");
        terrabite(["verify", &dem, &tin, "--max-error", "2", "--bbox", &bounds]).succeeds();
    }
}

#[test]
fn windows_and_boxes_that_are_none() {
    let folder = Folder::new();
    let dem = Dem::new(90, 70).on_the_map().write(&folder, "dem.tif");
    let refused = |options: &[&str], words: &[&str]| {
        for command in [vec!["simplify", &dem, &folder.at("tin.ply"), "--max-error", "1"], vec!["info", &dem]] {
            let run = terrabite(command.iter().copied().chain(options.iter().copied()));
            run.fails(1, words);
        }
    };
    refused(&["--window", "80,0,11,5"], &["dem.tif", "90 × 70", "11 × 5 from column 80", "--window"]);
    refused(&["--window", "3,3,1,5"], &["at least 2 × 2", "--window"]);
    refused(&["--bbox", "0,0,1,1"], &["found 0 × 0", "x 500005", "EPSG:32633", "--bbox"]);
    refused(&["--bbox", "500135,5199435,500136,5199925"], &["found 1 × 50", "--bbox"]);
    refused(&["--bbox", "0,0,1,1", "--bbox-crs", "nonsense"], &["from nonsense", "--bbox-crs"]);
    let bare = Dem::new(20, 20).write(&folder, "bare.tif");
    let run = terrabite(["info", &bare, "--bbox", "0,-9,9,0", "--bbox-crs", "EPSG:4326"]);
    run.fails(1, &["the raster has no CRS", "--bbox-crs"]);
    terrabite(["info", &bare, "--bbox", "0,-9,9,0"]).succeeds();
    assert_eq!(terrabite(["info", &dem, "--window", "0,0,5,5", "--bbox", "0,0,1,1"]).code, Some(2));
}

#[test]
fn a_work_dir_belongs_to_a_window() {
    let folder = Folder::new();
    // Flat: all windows have the same samples.
    let dem = Dem::new(90, 70).heights(|_, _| 3.0).on_the_map().write(&folder, "dem.tif");
    let (tin, work) = (folder.at("tin.ply"), folder.at("work"));
    let with = |window: &'static str| {
        let all = ["simplify", &dem, &tin, "--max-error", "1", "--work-dir", &work, "--tile", "16", "--window", window];
        all.map(str::to_string)
    };
    crate::util::terrabite_with_fault("kill:vertices:1", with("1,1,50,50"));
    assert!(folder.join("work").is_dir());
    terrabite(with("2,1,50,50"))
        .fails(1, &["another job", "--window, --bbox: 1,1,50,50 in the work dir, 2,1,50,50 now"]);
    terrabite(with("1,1,50,50")).succeeds();
    assert_eq!(folder.names(), ["dem.tif", "tin.ply"]);
}

#[test]
fn weights_and_channels_and_points_of_a_window() {
    let folder = Folder::new();
    let dem =
        Dem::new(90, 70).bands(2).others(|_, c, r| crate::util::hills(r, c)).on_the_map().write(&folder, "dem.tif");
    let weights = Dem::new(90, 70).heights(|c, _| if c < 40 { 1.0 } else { 0.5 }).kind(Kind::Float32).on_the_map();
    let weights = weights.write(&folder, "weights.tif");
    let tin = folder.at("tin.ply");
    for options in [vec!["--importance", &weights], vec!["--attributes", "2"]] {
        let window = ["--window", "13,7,61,50"];
        simplified(&folder, &dem, &options.iter().copied().chain(window).collect::<Vec<_>>());
        let verify = ["verify", &dem, &tin, "--max-error", "2"];
        terrabite(verify.into_iter().chain(options.iter().copied()).chain(window)).succeeds();
    }
    // Column 20, row 10, and one outside of the window.
    let points = folder.with("points.csv", "x,y\n500205,5199895\n500005,5199995\n");
    let (run, _) = simplified(&folder, &dem, &["--window", "13,7,61,50", "--points", &points]);
    assert_eq!((&run.json()["points"]["used"], &run.json()["points"]["outside"]), (&1.into(), &1.into()));
}

#[test]
fn a_mesh_of_a_window_is_drawn_over_the_whole_raster() {
    let folder = Folder::new();
    let dem = Dem::new(90, 70).on_the_map().write(&folder, "dem.tif");
    simplified(&folder, &dem, &["--window", "13,7,61,50"]);
    let (tin, png) = (folder.at("tin.ply"), folder.at("tin.png"));
    let bounds = ["--bbox", "500135,5199435,500735,5199925"];
    let preview = ["preview", &dem, &tin, &png, "--mode", "error", "--max-error", "2"];
    let run = terrabite(preview.into_iter().chain(bounds)).succeeds();
    assert!(run.out.contains("largest error"), "{run:?}");
}
