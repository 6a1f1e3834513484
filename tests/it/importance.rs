//! `--importance`: selective fidelity as a user meets it.

use std::fs;
use std::time::{Duration, SystemTime};

use crate::util::{Dem, Folder, Halted, Kind, hills, is_long, terrabite, terrabite_with_fault};

/// Weights of 4 in a square in the middle, 0 at the left, 0.5 elsewhere.
fn weights(column: usize, row: usize) -> f64 {
    match (column, row) {
        (40..80, 30..60) => 4.0,
        (..30, _) => 0.0,
        _ => 0.5,
    }
}

fn ground() -> Dem {
    Dem::new(120, 90).on_the_map()
}

fn importance() -> Dem {
    ground().kind(Kind::Float32).heights(weights)
}

/// The command, for a raster of weights.
fn simplify<'a>(dem: &'a str, tin: &'a str, weights: &'a str) -> Vec<&'a str> {
    vec!["simplify", dem, tin, "--max-error", "4", "--tile", "32", "--importance", weights, "--overwrite"]
}

#[test]
fn what_is_written_keeps_error_times_weight() {
    let folder = Folder::new();
    let (tin, dem) = (folder.at("tin.ply"), ground().write(&folder, "dem.tif"));
    let files = [
        importance().write(&folder, "plain.tif"),
        importance().tiled(16).compressed().write(&folder, "packed.tif"),
        importance().kind(Kind::Float64).stripped(5).big_endian().write(&folder, "strips.tif"),
    ];
    let mut expected = None;
    for file in &files {
        let run = simplify(&dem, &tin, file);
        let report = terrabite(run.iter().chain(&["--json"])).succeeds().json();
        assert_eq!(report["importance"]["file"], file.as_str());
        assert!(report["importance"]["max_weighted_error"].as_f64() <= Some(4.0));
        assert!(report["error"]["max"].as_f64() > Some(8.0), "where nothing is asked for, nothing is kept");
        terrabite(["verify", &dem, &tin, "--max-error", "4", "--importance", file]).succeeds();
        assert_eq!(terrabite(["verify", &dem, &tin, "--max-error", "4"]).code, Some(1));
        let bytes = fs::read(&tin).unwrap();
        let name = file.rsplit('/').next().unwrap();
        let comment = format!("comment importance {name}\n");
        let header = String::from_utf8_lossy(&bytes[..600.min(bytes.len())]).into_owned();
        assert!(header.contains(&comment), "{header}");
        // But for the name, the same bytes, however weights are stored and read.
        let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap();
        let mesh = bytes[end..].to_vec();
        assert!(expected.get_or_insert_with(|| mesh.clone()) == &mesh);
    }
    let out = terrabite(simplify(&dem, &tin, &files[0])).succeeds().out;
    assert!(out.contains("importance") && out.contains("error × weight up to"), "{out}");
}

#[test]
fn verify_judges_by_weights_of_its_own() {
    let folder = Folder::new();
    let (tin, dem) = (folder.at("tin.ply"), ground().write(&folder, "dem.tif"));
    let light = importance().write(&folder, "light.tif");
    let heavy = importance().heights(|c, r| 8.0 * weights(c, r)).write(&folder, "heavy.tif");
    terrabite(simplify(&dem, &tin, &light)).succeeds();
    let judge = ["verify", &dem, &tin, "--max-error", "4", "--importance"];
    let passed = terrabite(judge.iter().chain(&[light.as_str()])).succeeds().out;
    assert!(passed.contains("max error × weight") && passed.contains("PASS: error × weight within 4"), "{passed}");
    let failed = terrabite(judge.iter().chain(&[heavy.as_str()]));
    assert_eq!(failed.code, Some(1), "{failed:#?}");
    assert!(failed.out.contains("an error × weight above 4"), "{failed:#?}");
    let report = terrabite(judge.iter().chain(&[light.as_str(), "--json"])).succeeds().json();
    assert_eq!(report["has_importance"], true);
    assert!(report["worst_by_importance"]["weighted_error"].as_f64() <= Some(4.0));
}

#[test]
fn weights_of_one_give_the_same_mesh() {
    let folder = Folder::new();
    let (tin, dem) = (folder.at("tin.ply"), ground().write(&folder, "dem.tif"));
    let ones = ground().kind(Kind::Byte).heights(|_, _| 1.0).write(&folder, "ones.tif");
    for feasibility in ["weak", "strong"] {
        let bytes = |weights: Option<&str>| {
            let run = ["simplify", &dem, &tin, "--max-error", "3", "--feasibility", feasibility, "--overwrite"];
            terrabite(run.into_iter().chain(weights.into_iter().flat_map(|w| ["--importance", w]))).succeeds();
            let bytes = fs::read(&tin).unwrap();
            let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap();
            bytes[end..].to_vec()
        };
        assert!(bytes(None) == bytes(Some(&ones)), "{feasibility}");
    }
}

#[test]
fn threads_and_access_do_not_change_a_byte() {
    let folder = Folder::new();
    let (tin, dem) = (folder.at("tin.ply"), ground().write(&folder, "dem.tif"));
    let file = importance().write(&folder, "weights.tif");
    let bytes = |options: &[&str]| {
        terrabite(simplify(&dem, &tin, &file).iter().chain(options)).succeeds();
        fs::read(&tin).unwrap()
    };
    let expected = bytes(&["--threads", "1"]);
    for options in [["--threads", "3"], ["--access", "windows"], ["--access", "decode"], ["--access", "in-place"]] {
        assert!(bytes(&options) == expected, "{options:?}");
    }
}

/// Both commands must refuse, with the same words, and leave nothing.
#[track_caller]
fn refused(folder: &Folder, file: &str, options: &[&str], words: &[&str]) {
    let (dem, tin) = (folder.at("dem.tif"), folder.at("tin.ply"));
    let before = folder.names();
    let run = ["simplify", &dem, &folder.at("out.ply"), "--max-error", "4", "--importance", file];
    terrabite(run.iter().chain(options)).fails(1, words);
    assert_eq!(folder.names(), before);
    let run = ["verify", &dem, &tin, "--max-error", "4", "--importance", file];
    terrabite(run.iter().chain(options)).fails(1, words);
}

#[test]
fn importance_rasters_that_do_not_fit() {
    let folder = Folder::new();
    let (dem, tin) = (ground().write(&folder, "dem.tif"), folder.at("tin.ply"));
    terrabite(["simplify", &dem, &tin, "--max-error", "4"]).succeeds();
    let missing = folder.at("none.tif");
    refused(&folder, &missing, &[], &[&missing, "No such file"]);
    let text = folder.with("notes.txt", "no raster");
    refused(&folder, &text, &[], &[&text, "cannot be opened as a raster"]);
    let small = Dem::new(119, 90).write(&folder, "small.tif");
    refused(&folder, &small, &[], &[&small, "the grid of", &dem, "120 × 90", "found size 119 × 90", "gdalwarp"]);
    let shifted = importance().geo_transform([500_005.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0]);
    let shifted = shifted.write(&folder, "shifted.tif");
    refused(&folder, &shifted, &[], &[&shifted, "geotransform 500000,", "found geotransform 500005,", "gdalwarp"]);
    let fine = importance().write(&folder, "fine.tif");
    refused(&folder, &fine, &["--importance-band", "2"], &[&fine, "bands 1 to 1", "--importance-band"]);
    // Without a place of its own it is taken for the raster's.
    let nowhere = Dem::new(120, 90).kind(Kind::Float32).heights(weights).write(&folder, "nowhere.tif");
    terrabite(simplify(&dem, &tin, &nowhere)).succeeds();
    terrabite(["simplify", &dem, &tin, "--max-error", "4", "--importance-band", "1"]).fails(2, &["--importance"]);
}

#[test]
fn weights_that_are_none_are_named() {
    let folder = Folder::new();
    let (dem, tin) = (ground().write(&folder, "dem.tif"), folder.at("tin.ply"));
    terrabite(["simplify", &dem, &tin, "--max-error", "4"]).succeeds();
    let at = ["column 70, row 40", "expected a", "weight"];
    type Weights = fn(usize, usize) -> f64;
    let wrong: [(Weights, &str); 3] = [
        (|c, r| if (c, r) == (70, 40) { -0.5 } else { 1.0 }, "-0.5"),
        (|c, r| if (c, r) == (70, 40) { f64::NAN } else { 1.0 }, "nodata"),
        (|c, r| if (c, r) == (70, 40) { f64::INFINITY } else { 1.0 }, "inf"),
    ];
    for (heights, found) in wrong {
        let file = ground().kind(Kind::Float32).heights(heights).write(&folder, "wrong.tif");
        refused(&folder, &file, &[], &[&file, found, at[0], at[1], at[2]]);
        fs::remove_file(file).unwrap();
    }
    let holes = importance().nodata(4.0).write(&folder, "holes.tif");
    refused(&folder, &holes, &[], &[&holes, "nodata", "column 40, row 30", "weight"]);
    fs::remove_file(holes).unwrap();
}

#[test]
fn the_importance_raster_is_never_the_output() {
    let folder = Folder::new();
    let dem = ground().write(&folder, "dem.tif");
    let file = importance().write(&folder, "weights.tif");
    let before = fs::read(&file).unwrap();
    let over = simplify(&dem, &file, &file).into_iter().chain(["--format", "ply"]);
    terrabite(over).fails(1, &[&file, "same file as the input"]);
    assert!(fs::read(&file).unwrap() == before);
}

#[test]
fn a_run_continues_with_the_same_weights_only() {
    let folder = Folder::new();
    let (tin, dem) = (folder.at("tin.ply"), ground().write(&folder, "dem.tif"));
    let file = importance().compressed().write(&folder, "weights.tif");
    terrabite(simplify(&dem, &tin, &file)).succeeds();
    let expected = fs::read(&tin).unwrap();
    fs::remove_file(&tin).unwrap();
    let other = importance().heights(|c, r| weights(c, r) + hills(c, r) / 100.0).write(&folder, "other.tif");
    let work = folder.at("work");
    let kept = |weights: &str| -> Vec<String> {
        let command = simplify(&dem, &tin, weights);
        command.into_iter().chain(["--work-dir", &work, "--json", "--threads", "1"]).map(str::to_string).collect()
    };
    assert_eq!(terrabite_with_fault("kill:chunk-renamed:3", kept(&file)).code, None);
    terrabite(kept(&other)).fails(1, &["another job", "the importance raster's checksum of some samples"]);
    let without = ["simplify", &dem, &tin, "--max-error", "4", "--tile", "32", "--work-dir", &work];
    terrabite(without).fails(1, &["another job", "--importance: given in the work dir, not given now", "--work-dir"]);
    // One weight that is changed behind the run's back, at a place that identifies nothing.
    let mended = importance().heights(|c, r| if (c, r) == (5, 3) { 0.25 } else { weights(c, r) });
    let original = fs::read(&file).unwrap();
    mended.compressed().write(&folder, "weights.tif");
    let run = terrabite(kept(&file));
    assert!(run.code == Some(1) && run.err.contains("samples and weights at column 0, row 0"), "{run:#?}");
    fs::write(&file, original).unwrap();
    let report = terrabite(kept(&file)).succeeds().json();
    assert!(report["tiles_found"].as_u64() >= Some(3));
    assert!(fs::read(&tin).unwrap() == expected);
}

#[test]
fn weights_that_change_during_a_run_end_it() {
    let folder = Folder::new();
    let (tin, dem) = (folder.at("tin.ply"), ground().write(&folder, "dem.tif"));
    let file = importance().write(&folder, "weights.tif");
    for (point, count) in [("tile-begun", 2), ("vertices", 1), ("triangles", 2)] {
        let halted = Halted::at(point, count, simplify(&dem, &tin, &file));
        let now = SystemTime::now() + Duration::from_secs(count.into());
        fs::File::options().append(true).open(&file).unwrap().set_modified(now).unwrap();
        halted.go_on().fails(1, &[&file, "the raster has changed", "modified"]);
        assert_eq!(folder.names(), ["dem.tif", "weights.tif"]);
    }
}

/// Dense meshes, whose every sample is a vertex, at a budget near the smallest.
#[test]
fn weights_are_part_of_the_memory_plan() {
    let folder = Folder::new();
    let rough = |c: usize, r: usize| ((c * c * 31 + r * r * 17 + c * r * 7) % 1009) as f64;
    let (width, height, tile, memory) =
        if is_long() { (1020, 520, "512", "98MiB") } else { (510, 260, "256", "86MiB") };
    let dem = Dem::new(width, height).heights(rough).tiled(256).compressed().write(&folder, "dem.tif");
    let file = Dem::new(width, height).kind(Kind::Float64).heights(|c, r| ((c + r) % 3) as f64);
    let file = file.tiled(256).compressed().write(&folder, "weights.tif");
    let tin = folder.at("tin.ply");
    let run = ["simplify", &dem, &tin, "--max-error", "0.5", "--importance", &file, "--json", "--tile", tile];
    let needs = |more: &[&str]| terrabite(run.iter().chain(more)).succeeds().json();
    let plan = needs(&["--dry-run", "--threads", "1"]);
    let plain = ["simplify", &dem, &tin, "--max-error", "0.5", "--json", "--dry-run", "--threads", "1", "--tile", tile];
    let without = terrabite(plain);
    let least = |needs: &serde_json::Value| needs["memory"]["needed_bytes"].as_u64().unwrap();
    assert!(least(&plan) >= least(&without.succeeds().json()) + 12 * 256 * 256);
    let report = needs(&["--memory", memory]);
    let (peak, budget) = (report["peak_memory_bytes"].as_u64(), report["memory"]["budget_bytes"].as_u64());
    assert!(peak <= budget, "{peak:?} of {budget:?}");
    terrabite(["verify", &dem, &tin, "--max-error", "0.5", "--importance", &file]).succeeds();
}
