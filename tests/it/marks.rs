//! `--nodata`, `--valid-range`, alpha bands and the warnings about marks, from outside.

use std::fs;

use gdal::raster::{Buffer, ColorInterpretation};
use gdal::{Dataset, DriverManager};
use serde_json::Value;

use crate::util::{Dem, Folder, Kind, hills, terrabite};

const VOID: (std::ops::Range<usize>, std::ops::Range<usize>) = (20..30, 15..22);

fn in_void(column: usize, row: usize) -> bool {
    VOID.0.contains(&column) && VOID.1.contains(&row)
}

const VOID_SAMPLES: u64 = 70;

fn simplified(dem: &str, tin: &str, options: &[&str]) -> Value {
    let command = ["simplify", dem, tin, "--max-error", "2", "--overwrite", "--json"];
    terrabite(command.iter().chain(options)).succeeds().json()
}

fn verified(dem: &str, tin: &str, options: &[&str]) -> Value {
    terrabite(["verify", dem, tin, "--max-error", "2", "--json"].iter().chain(options)).succeeds().json()
}

fn codes(report: &Value) -> Vec<&str> {
    report["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap()).collect()
}

#[test]
fn several_marks_and_infinities() {
    let heights = |c, r| match (in_void(c, r), c) {
        (true, 20..25) => -9999.0,
        (true, _) => f64::NEG_INFINITY,
        _ => hills(c, r),
    };
    let folder = Folder::new();
    let dem = Dem::new(60, 50).kind(Kind::Float32).heights(heights).nodata(-9999.0).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let refused = terrabite(["simplify", &dem, &tin, "--max-error", "2"]);
    refused.fails(1, &[&dem, "-inf", "column 25, row 15", "nodata tag is -9999", "--nodata -inf", "--valid-range"]);
    for options in [
        &["--nodata", "tag", "--nodata", "-inf"][..],
        &["--nodata", "-9999", "--nodata=-inf"],
        &["--valid-range", "-500,9000"],
        &["--valid-range=-500,9000", "--nodata", "none"],
    ] {
        let report = simplified(&dem, &tin, options);
        assert_eq!(report["missing_samples"], VOID_SAMPLES, "{options:?}");
        let verdict = verified(&dem, &tin, options);
        assert_eq!(
            (&verdict["missing_samples"], &verdict["worst"]["error"]),
            (&report["missing_samples"].clone(), &report["error"]["max"])
        );
        assert_eq!(verdict["height_range"], report["height_range"]);
        let (png, info) = (folder.at("tin.png"), ["info", &dem, "--json"]);
        terrabite(["preview", &dem, &tin, &png, "--mode", "error", "--overwrite"].iter().chain(options)).succeeds();
        let info = terrabite(info.iter().chain(options)).succeeds().json();
        assert_eq!(
            (&info["missing_samples"], &info["height_range"]),
            (&report["missing_samples"], &report["height_range"])
        );
    }
    terrabite(["verify", &dem, &tin, "--max-error", "2"]).fails(1, &["-inf", "--nodata", "--valid-range"]);
    let tagged = Dem::new(60, 50).kind(Kind::Float32).heights(heights).nodata(f64::NEG_INFINITY);
    let tagged = tagged.write(&folder, "tagged.tif");
    let run = terrabite(["simplify", &tagged, &tin, "--max-error", "2", "--overwrite", "--nodata", "-9999"]);
    run.fails(1, &["that is the nodata tag", "--nodata -inf"]);
}

/// A tag of NaN marks no integer, and preview tells of it like others.
#[test]
fn a_tag_of_nan_marks_no_integer() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(60, 50).nodata(f64::NAN).write(&folder, "dem.tif"), folder.at("tin.ply"));
    assert_eq!(codes(&simplified(&dem, &tin, &[])), ["unreachable_nodata"]);
    let run = terrabite(["preview", &dem, &tin, &folder.at("tin.png")]).succeeds();
    assert!(run.err.starts_with(&format!("warning: {dem}: the nodata tag NaN marks nothing")), "{}", run.err);
}

/// `info` counts what is outside of the polygons as missing, like `simplify`.
#[test]
fn info_counts_what_is_outside_of_a_cutline() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(60, 50).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let geometry = r#"{"type": "Polygon", "coordinates": [[[5,-5],[50,-6],[40,-40],[5,-5]]]}"#;
    let text = format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {geometry}}}"#);
    let cutline = folder.with("area.geojson", text);
    let report = simplified(&dem, &tin, &["--cutline", &cutline]);
    let info = terrabite(["info", &dem, "--cutline", &cutline, "--json"]).succeeds().json();
    assert_eq!(
        (&info["missing_samples"], &info["height_range"]),
        (&report["missing_samples"], &report["height_range"])
    );
}

#[test]
fn ends_of_the_valid_range_are_valid_and_what_is_no_range_is_refused() {
    let folder = Folder::new();
    let heights = |c: usize, _| if c < 20 { 10.0 } else { 20.0 + c as f64 };
    let dem = Dem::new(40, 30).scaling(0.5, 0.0).heights(heights).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    // Heights, not stored values: from 5 and 20 to 29.5.
    let report = simplified(&dem, &tin, &["--valid-range", "5,29"]);
    assert_eq!((&report["missing_samples"], &report["height_range"]), (&30.into(), &serde_json::json!([5.0, 29.0])));
    for wrong in ["5", "9,5", "nan,5", ""] {
        terrabite(["simplify", &dem, &tin, "--max-error", "1", "--valid-range", wrong]).fails(2, &["MIN,MAX"]);
    }
}

#[test]
fn marks_decide_what_a_work_dir_is_for() {
    let folder = Folder::new();
    let heights = |c, r| if in_void(c, r) { -9999.0 } else { hills(c, r) };
    let dem = Dem::new(60, 50).heights(heights).nodata(-9999.0).write(&folder, "dem.tif");
    let (tin, work) = (folder.at("tin.ply"), folder.at("work"));
    let run = |options: &[&str], fault| {
        let command = ["simplify", &dem, &tin, "--max-error", "2", "--tile", "16", "--work-dir", &work];
        let command: Vec<&str> = command.iter().chain(options).copied().collect();
        match fault {
            Some(fault) => crate::util::terrabite_with_fault(fault, &command),
            None => terrabite(&command),
        }
    };
    run(&["--valid-range", "0,9000"], Some("kill:vertices:1"));
    for other in [
        &[][..],
        &["--valid-range", "0,8000"],
        &["--valid-range", "0,9000", "--nodata", "5"],
        &["-oo", "NUM_THREADS=1", "--valid-range", "0,9000"],
    ] {
        run(other, None).fails(1, &["--work-dir"]);
    }
    run(&["--valid-range", "0,9000"], None).succeeds();
}

/// A sea floor at −9999.002 beside a tag of −9999 vanishes: GDAL takes them for the same, too.
#[test]
fn samples_that_are_missing_by_nearness_are_counted_and_warned_of() {
    let heights = |c, r| if in_void(c, r) { -9999.002 } else { hills(c, r) };
    let folder = Folder::new();
    let dem = Dem::new(60, 50).kind(Kind::Float32).heights(heights).nodata(-9999.0).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let report = simplified(&dem, &tin, &["--tile", "16"]);
    assert_eq!(codes(&report), ["near_nodata"]);
    let warning = &report["warnings"][0];
    assert_eq!((&warning["count"], &warning["file"]), (&VOID_SAMPLES.into(), &dem.clone().into()));
    let message = warning["message"].as_str().unwrap();
    assert!(message.contains("column 20, row 15") && message.contains("--nodata none"), "{message}");
    assert_eq!(verified(&dem, &tin, &[])["warnings"], report["warnings"]);
    let info = terrabite(["info", &dem, "--json"]).succeeds().json();
    assert_eq!(info["warnings"], report["warnings"]);
    // As lines, once, and not at all.
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "2", "--overwrite"]).succeeds();
    assert_eq!(run.err.matches(&format!("warning: {dem}: 70 samples")).count(), 1, "{}", run.err);
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "2", "--overwrite", "-q"]).succeeds();
    assert_eq!(run.err, "");
    // They are ground if the caller says so.
    assert_eq!(simplified(&dem, &tin, &["--nodata", "none"])["missing_samples"], 0);
}

/// What GDAL does not mask either is refused with both numbers, and no number has 309 digits.
#[test]
fn a_tag_of_fewer_digits_in_doubles_is_named_beside_what_is_stored() {
    let lowest = f64::from(f32::MIN);
    let heights = move |c: usize, r: usize| if in_void(c, r) { f64::from(f32::MIN) } else { hills(c, r) };
    let folder = Folder::new();
    let dem = Dem::new(60, 50).kind(Kind::Float64).heights(heights).nodata(-3.40282e38).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "2"]);
    let stored = format!("--nodata {lowest:e}");
    run.fails(1, &["-3.4028234663852886e38", "nodata tag is -3.40282e38", &stored, "--valid-range"]);
    let largest =
        Dem::new(60, 50).kind(Kind::Float64).heights(|c, r| if in_void(c, r) { f64::MAX } else { hills(c, r) });
    let largest = largest.write(&folder, "largest.tif");
    let run = terrabite(["simplify", &largest, &tin, "--max-error", "2"]);
    assert!(!run.err.contains("00000"), "{}", run.err);
    run.fails(1, &["1.7976931348623157e308"]);
    simplified(&largest, &tin, &["--nodata", "1.7976931348623157e308"]);
}

#[test]
fn a_tag_that_no_sample_can_have_is_warned_of() {
    let heights = |c, r| if in_void(c, r) { 65535.0 } else { hills(c, r) };
    let folder = Folder::new();
    let dem = Dem::new(60, 50).kind(Kind::UInt16).heights(heights).nodata(-1.0).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let report = simplified(&dem, &tin, &[]);
    assert_eq!((codes(&report), &report["height_range"][1]), (vec!["unreachable_nodata"], &65535.0.into()));
    let message = report["warnings"][0]["message"].as_str().unwrap();
    assert!(message.contains("-1") && message.contains("UInt16") && message.contains("--nodata"), "{message}");
    let run = terrabite(["simplify", &dem, &tin, "--max-error", "2", "--overwrite"]).succeeds();
    assert!(run.out.contains("heights from ") && run.out.contains("65535"), "{}", run.out);
    assert_eq!(codes(&simplified(&dem, &tin, &["--dry-run"])), ["unreachable_nodata"]);
    assert_eq!(codes(&simplified(&dem, &tin, &["--nodata", "65535"])), [""; 0]);
}

/// Warnings change no exit code; this one comes with its own.
#[test]
fn a_budget_that_ends_a_run_is_a_warning_like_others() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(60, 50).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let command = ["simplify", &dem, &tin, "--max-error", "1", "--max-points", "30", "--overwrite"];
    let run = terrabite(command);
    assert!(run.code == Some(5) && run.err.starts_with(&format!("warning: {tin}: the mesh is complete")), "{run:?}");
    let run = terrabite(command.iter().chain(&["--json"]));
    assert_eq!((run.code, run.err.as_str(), codes(&run.json())), (Some(5), "", vec!["fell_short"]));
    let run = terrabite(command.iter().chain(&["--quiet"]));
    assert_eq!((run.code, run.err.as_str(), run.out.as_str()), (Some(5), "", ""));
}

#[test]
fn a_tag_of_zero_says_what_it_took() {
    let heights = |c, r| if in_void(c, r) { 0.0 } else { hills(c, r) };
    let folder = Folder::new();
    let dem = Dem::new(60, 50).heights(heights).nodata(0.0).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let report = simplified(&dem, &tin, &[]);
    assert_eq!((codes(&report), &report["warnings"][0]["count"]), (vec!["zero_nodata"], &VOID_SAMPLES.into()));
    assert_eq!(verified(&dem, &tin, &[])["warnings"], report["warnings"]);
    assert_eq!(codes(&simplified(&dem, &tin, &["--nodata", "none"])), [""; 0]);
    assert_eq!(codes(&simplified(&dem, &tin, &["--nodata", "tag"])), ["zero_nodata"]);
    // Who names the value knows it.
    assert_eq!(codes(&simplified(&dem, &tin, &["--nodata", "0"])), [""; 0]);
}

/// A rim of what a resampler made out of a void and the ground beside it.
#[test]
fn heights_beside_voids_that_lie_far_beyond_all_others_are_warned_of() {
    let heights = |c: usize, r: usize| {
        let rim = (19..31).contains(&c) && (14..23).contains(&r);
        if in_void(c, r) {
            -9999.0
        } else if rim {
            -4000.0
        } else {
            hills(c, r)
        }
    };
    let folder = Folder::new();
    let dem = Dem::new(60, 50).heights(heights).nodata(-9999.0).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    for tile in ["16", "0"] {
        let report = simplified(&dem, &tin, &["--tile", tile]);
        assert_eq!((codes(&report), &report["warnings"][0]["count"]), (vec!["near_voids"], &(12 * 9 - 70).into()));
        let message = report["warnings"][0]["message"].as_str().unwrap();
        assert!(message.contains("-4000 at column 19, row 14") && message.contains("--valid-range"), "{message}");
        assert_eq!(verified(&dem, &tin, &[])["warnings"], report["warnings"]);
    }
    let report = simplified(&dem, &tin, &["--valid-range", "0,9000"]);
    assert_eq!((codes(&report), &report["missing_samples"]), (vec![], &(12 * 9).into()));
    let plain = Dem::new(60, 50).heights(|c, r| if in_void(c, r) { -9999.0 } else { hills(c, r) }).nodata(-9999.0);
    assert_eq!(codes(&simplified(&plain.write(&folder, "plain.tif"), &tin, &[])), [""; 0]);
}

/// Band 2 is alpha, of the raster's own type: 0 and NaN are missing, whatever GDAL's mask says, and beside a tag.
#[test]
fn alpha_of_any_type_counts() {
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    for (kind, nodata, zero) in [
        (Kind::Float32, None, 0.0),
        (Kind::Float32, Some(-9999.0), f64::NAN),
        (Kind::Int16, None, 0.0),
        (Kind::Float64, None, 0.0),
        (Kind::Byte, Some(1.0), 0.0),
    ] {
        let dem = Dem::new(60, 50).kind(kind).bands(3).heights(|c, r| if in_void(c, r) { 0.0 } else { hills(c, r) });
        let dem = match nodata {
            Some(mark) => dem.nodata(mark),
            None => dem,
        };
        let path = dem.write(&folder, "dem.tif");
        let options = gdal::DatasetOptions { open_flags: gdal::GdalOpenFlags::GDAL_OF_UPDATE, ..Default::default() };
        let dataset = Dataset::open_ex(&path, options).unwrap();
        let alpha = (0..60 * 50).map(|i| if in_void(i % 60, i / 60) { zero } else { 255.0 }).collect::<Vec<f64>>();
        let mut band = dataset.rasterband(2).unwrap();
        band.set_color_interpretation(ColorInterpretation::AlphaBand).unwrap();
        band.write((0, 0), (60, 50), &mut Buffer::new((60, 50), alpha)).unwrap();
        dataset.close().unwrap();
        for access in ["windows", "decode"] {
            let report = simplified(&path, &tin, &["--access", access, "--band", "1"]);
            assert_eq!(report["missing_samples"], VOID_SAMPLES, "{kind:?} {access}");
        }
        assert_eq!(verified(&path, &tin, &["--band", "1"])["missing_samples"], VOID_SAMPLES);
        assert!(terrabite(["info", &path]).succeeds().out.contains("what a mask or alpha band says"));
        fs::remove_file(&path).unwrap();
        let _ = fs::remove_file(format!("{path}.aux.xml"));
    }
}

/// Red, green and blue of terrain tiles.
fn tile(folder: &Folder, name: &str, number: impl Fn(usize, usize) -> u32, alpha: bool) -> String {
    let path = folder.join(name);
    let driver = DriverManager::get_driver_by_name("MEM").unwrap();
    let bands = if alpha { 4 } else { 3 };
    let memory = driver.create_with_band_type::<u8, _>("", 60, 50, bands).unwrap();
    use ColorInterpretation::{AlphaBand, BlueBand, GreenBand, RedBand};
    for (i, colour) in [RedBand, GreenBand, BlueBand, AlphaBand].into_iter().take(bands).enumerate() {
        let value = |c, r| match i {
            3 => {
                if in_void(c, r) {
                    0
                } else {
                    255
                }
            }
            _ => (number(c, r) >> (16 - 8 * i)) as u8,
        };
        let samples = (0..60 * 50).map(|k| value(k % 60, k / 60)).collect::<Vec<u8>>();
        let mut band = memory.rasterband(i + 1).unwrap();
        band.set_color_interpretation(colour).unwrap();
        band.write((0, 0), (60, 50), &mut Buffer::new((60, 50), samples)).unwrap();
    }
    let png = DriverManager::get_driver_by_name("PNG").unwrap();
    memory.create_copy(&png, &path, &Default::default()).unwrap().close().unwrap();
    folder.at(name)
}

#[test]
fn a_picture_is_no_terrain_unless_it_is_said_to_be() {
    let folder = Folder::new();
    let tin = folder.at("tin.ply");
    let terrain_rgb = tile(&folder, "rgb.png", |c, r| (10.0 * (hills(c, r) + 10_000.0)) as u32, false);
    let words = [terrain_rgb.as_str(), "found red", "--encoding", "--band 1"];
    terrabite(["simplify", &terrain_rgb, &tin, "--max-error", "2"]).fails(1, &words);
    terrabite(["verify", &terrain_rgb, &tin, "--max-error", "2"]).fails(1, &words);
    terrabite(["preview", &terrain_rgb, &tin, &folder.at("tin.png")]).fails(1, &words);
    let info = terrabite(["info", &terrain_rgb, "--json"]).succeeds().json();
    assert_eq!((codes(&info), &info["bands"], &info["band_description"]), (vec!["picture"], &3.into(), &"red".into()));
    simplified(&terrain_rgb, &tin, &["--band", "1"]);
    simplified(&terrain_rgb, &tin, &["--image"]);

    let encoded = ["--encoding", "terrain-rgb"];
    let report = simplified(&terrain_rgb, &tin, &encoded);
    let heights: Vec<f64> = (0..60 * 50).map(|i| hills(i % 60, i / 60)).collect();
    let least = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(report["height_range"], serde_json::json!([least, largest]));
    let verdict = verified(&terrain_rgb, &tin, &encoded);
    assert_eq!(verdict["worst"]["error"], report["error"]["max"]);
    let header = String::from_utf8_lossy(&fs::read(&tin).unwrap()[..600]).into_owned();
    assert!(header.contains("comment encoding terrain-rgb"), "{header}");
    let terrarium = tile(&folder, "terrarium.png", |c, r| (256.0 * (hills(c, r) + 32_768.0)) as u32, true);
    let report = simplified(&terrarium, &tin, &["--encoding", "terrarium"]);
    assert_eq!(report["missing_samples"], VOID_SAMPLES);
    verified(&terrarium, &tin, &["--encoding", "terrarium"]);
    let grey = Dem::new(60, 50).kind(Kind::Byte).write(&folder, "grey.tif");
    let refused = terrabite(["simplify", &grey, &tin, "--max-error", "2", "--encoding", "terrarium"]);
    refused.fails(1, &[&grey, "three bands of bytes", "one band of Byte", "--encoding"]);
}

/// The first band that is no colour is named: Vertical Mapper's grids have heights in band 4.
#[test]
fn the_band_that_is_no_colour_is_named() {
    let folder = Folder::new();
    let dem = Dem::new(60, 50).kind(Kind::Byte).bands(4).option("PHOTOMETRIC=RGB").option("ALPHA=UNSPECIFIED");
    let dem = dem.write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    terrabite(["simplify", &dem, &tin, "--max-error", "2"]).fails(1, &["found red", "--band 4"]);
    let report = simplified(&dem, &tin, &["--band", "4"]);
    assert_eq!((&report["band"], &report["bands"]), (&4.into(), &4.into()));
    Dem::new(60, 50).bands(6).write(&folder, "many.tif");
    let band = |number: usize| {
        let description = if number == 1 { "<Description>min</Description>" } else { "" };
        format!(
            r#"<VRTRasterBand dataType="Int16" band="{number}">{description}<SimpleSource><SourceFilename
            relativeToVRT="1">many.tif</SourceFilename><SourceBand>{number}</SourceBand></SimpleSource></VRTRasterBand>"#
        )
    };
    let bands: String = (1..=6).map(band).collect();
    let many =
        folder.with("many.vrt", format!(r#"<VRTDataset rasterXSize="60" rasterYSize="50">{bands}</VRTDataset>"#));
    for run in [terrabite(["simplify", &many, &tin, "--max-error", "2", "--overwrite"]), terrabite(["info", &many])] {
        let out = run.succeeds().out;
        assert!(out.contains("band 1 of 6 (min)"), "{out}");
    }
}

#[test]
fn open_options_reach_the_driver_and_are_checked() {
    let folder = Folder::new();
    let lines: String =
        (0..50).flat_map(|r| (0..60).map(move |c| format!("{c} {} {}\n", 50 - r, hills(c, r)))).collect();
    let (dem, tin) = (folder.with("dem.xyz", lines), folder.at("tin.ply"));
    for oo in ["--oo", "-oo"] {
        let report = simplified(&dem, &tin, &[oo, "COLUMN_ORDER=XYZ"]);
        assert_eq!(report["samples"], 3000);
        let header = String::from_utf8_lossy(&fs::read(&tin).unwrap()[..600]).into_owned();
        assert!(header.contains("comment open option COLUMN_ORDER=XYZ"), "{header}");
    }
    verified(&dem, &tin, &["-oo", "COLUMN_ORDER=XYZ"]);
    terrabite(["info", &dem, "-oo", "COLUMN_ORDER=XYZ"]).succeeds();
    terrabite(["simplify", &dem, &tin, "--max-error", "2", "--oo", "COLUMN_ORDER"]).fails(2, &["NAME=VALUE"]);
    let weights = Dem::new(60, 50).heights(|_, _| 1.0).write(&folder, "weights.tif");
    simplified(&dem, &tin, &["--importance", &weights, "--importance-oo", "NUM_THREADS=1"]);
    terrabite(["simplify", &dem, &tin, "--max-error", "2", "--importance-oo", "A=1"]).fails(2, &["--importance"]);
}

/// Window, marks and cutline are applied in one order, whatever the order of the words.
#[test]
fn the_order_of_options_does_not_matter() {
    let folder = Folder::new();
    let heights = |c, r| if in_void(c, r) { -1.0 } else { hills(c, r) };
    let (dem, tin) = (Dem::new(60, 50).heights(heights).write(&folder, "dem.tif"), folder.at("tin.ply"));
    let ring = "[[[2,-2],[58,-3],[55,-48],[3,-45],[2,-2]]]";
    let cutline = folder.with(
        "area.geojson",
        format!(
            r#"{{"type": "Feature", "properties": {{}}, "geometry": {{"type": "Polygon", "coordinates": {ring}}}}}"#
        ),
    );
    let window = ["--window", "5,4,45,40"];
    let (marks, polygons) = (["--nodata", "-1"], ["--cutline", cutline.as_str()]);
    let mut meshes = Vec::new();
    for order in [[window, marks, polygons], [polygons, window, marks], [marks, polygons, window]] {
        simplified(&dem, &tin, order.as_flattened());
        verified(&dem, &tin, order.as_flattened());
        terrabite(["preview", &dem, &tin, &folder.at("p.png"), "--overwrite"].iter().chain(order.as_flattened()))
            .succeeds();
        meshes.push(fs::read(&tin).unwrap());
    }
    assert!(meshes.windows(2).all(|pair| pair[0] == pair[1]));
}
