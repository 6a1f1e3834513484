//! `terrabite simplify` and what it must refuse: a clear message, the right exit code, nothing left behind.

use crate::util::{Dem, Folder, Kind, terrabite, terrabite_disturbed, terrabite_stopped, terrabite_with_file_limit};

/// A folder with a good raster in it, and its path.
fn with_dem() -> (Folder, String) {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).write(&folder, "dem.tif");
    (folder, dem)
}

/// Simplifying `input` must fail as told and leave nothing.
#[track_caller]
fn refuses(folder: &Folder, input: &str, words: &[&str]) {
    let before = folder.names();
    terrabite(["simplify", input, &folder.at("tin.ply"), "--max-error", "1"]).fails(1, words);
    assert_eq!(folder.names(), before);
}

#[test]
fn input_that_is_missing_or_no_raster() {
    let folder = Folder::new();
    let missing = folder.at("none.tif");
    refuses(&folder, &missing, &[&missing, "No such file"]);
    let text = folder.with("notes.txt", "no raster");
    refuses(&folder, &text, &[&text, "cannot be opened as a raster"]);
}

#[test]
fn input_that_is_cut_off() {
    let (folder, dem) = with_dem();
    let bytes = std::fs::read(&dem).unwrap();
    let cut = folder.with("cut.tif", &bytes[..bytes.len() / 2]);
    refuses(&folder, &cut, &[&cut]);
    // Once with blocks that have to be decoded.
    let packed = Dem::new(200, 200).compressed().tiled(16).write(&folder, "packed.tif");
    let bytes = std::fs::read(&packed).unwrap();
    let cut = folder.with("packed.tif", &bytes[..bytes.len() / 2]);
    refuses(&folder, &cut, &[&cut]);
}

#[test]
fn input_too_small_for_a_surface() {
    let folder = Folder::new();
    for (width, height) in [(1, 1), (1, 9), (9, 1)] {
        let thin = Dem::new(width, height).write(&folder, "thin.tif");
        refuses(&folder, &thin, &[&thin, &format!("{width} × {height}")]);
    }
}

#[test]
fn bands_that_are_not_there() {
    let (folder, dem) = with_dem();
    for band in ["0", "2"] {
        let run = terrabite(["simplify", &dem, &folder.at("tin.ply"), "--max-error", "1", "--band", band]);
        run.fails(1, &[&dem, &format!("band {band}"), "bands 1 to 1", "--band"]);
    }
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn infinity_is_no_height_and_marks_nothing() {
    let folder = Folder::new();
    let strange = Dem::new(40, 30).kind(Kind::Float32).heights(|c, _| if c == 20 { f64::INFINITY } else { 5.0 });
    let strange = strange.write(&folder, "strange.tif");
    refuses(&folder, &strange, &[&strange, "inf", "column 20, row 0"]);
}

#[test]
fn a_raster_without_ground_is_refused() {
    let folder = Folder::new();
    let all = Dem::new(40, 30).nodata(-9999.0).heights(|_, _| -9999.0).write(&folder, "all.tif");
    refuses(&folder, &all, &[&all, "no ground"]);
    let lines = Dem::new(40, 30).kind(Kind::Float32).heights(|c, _| if c % 2 == 0 { f64::NAN } else { 5.0 });
    refuses(&folder, &lines.write(&folder, "lines.tif"), &["three heights"]);
}

#[test]
fn nodata_values_that_no_sample_can_have() {
    let folder = Folder::new();
    let (dem, tin) = (Dem::new(40, 30).kind(Kind::Byte).write(&folder, "dem.tif"), folder.at("tin.ply"));
    for wrong in ["-9999", "256", "255.5", "-0.5", "nan", "high"] {
        let run = terrabite(["simplify", &dem, &tin, "--max-error", "1", "--nodata", wrong]);
        run.fails(2, &[&dem, "Byte", wrong, "--nodata"]);
    }
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn tolerances_that_are_none() {
    let (folder, dem) = with_dem();
    let tin = folder.at("tin.ply");
    for wrong in ["-1", "-0.001", "nan", "-nan", "inf", "five", ""] {
        terrabite(["simplify", &dem, &tin, "--max-error", wrong]).fails(2, &["--max-error", "expected"]);
    }
    terrabite(["simplify", &dem, &tin]).fails(2, &["--max-error"]);
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn options_out_of_range() {
    let (folder, dem) = with_dem();
    let tin = folder.at("tin.ply");
    for (option, wrong) in [("--threads", "0"), ("--threads", "-2"), ("--tile", "-1"), ("--feasibility", "feeble")] {
        let run = terrabite(["simplify", &dem, &tin, "--max-error", "1", option, wrong]);
        run.fails(2, &[wrong]);
    }
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn output_folders_that_are_missing_or_closed() {
    let (folder, dem) = with_dem();
    let nowhere = folder.at("none/tin.ply");
    terrabite(["simplify", &dem, &nowhere, "--max-error", "1"]).fails(1, &[&nowhere, "folder"]);
    // Not even root can make files here.
    if std::path::Path::new("/proc/self").is_dir() {
        terrabite(["simplify", &dem, "/proc/tin.ply", "--max-error", "1"]).fails(1, &["/proc/tin.ply", "folder"]);
    }
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn an_existing_output_is_spared() {
    let (folder, dem) = with_dem();
    let tin = folder.with("tin.ply", "precious");
    terrabite(["simplify", &dem, &tin, "--max-error", "1"]).fails(1, &[&tin, "--overwrite"]);
    assert_eq!(std::fs::read(&tin).unwrap(), b"precious");
    assert_eq!(folder.names(), ["dem.tif", "tin.ply"]);
    terrabite(["simplify", &dem, &tin, "--max-error", "1", "--overwrite"]).succeeds();
    assert!(std::fs::read(&tin).unwrap().starts_with(b"ply\n"));
    assert_eq!(folder.names(), ["dem.tif", "tin.ply"]);
}

#[test]
fn a_failed_run_spares_what_it_would_overwrite() {
    let folder = Folder::new();
    let strange = Dem::new(40, 30).kind(Kind::Float32).heights(|c, _| if c == 9 { f64::INFINITY } else { 5.0 });
    let strange = strange.write(&folder, "strange.tif");
    let tin = folder.with("tin.ply", "precious");
    terrabite(["simplify", &strange, &tin, "--max-error", "1", "--overwrite"]).fails(1, &["inf"]);
    assert_eq!(std::fs::read(&tin).unwrap(), b"precious");
    assert_eq!(folder.names(), ["strange.tif", "tin.ply"]);
}

#[test]
fn the_input_is_never_the_output() {
    let (folder, dem) = with_dem();
    let before = std::fs::read(&dem).unwrap();
    std::fs::hard_link(&dem, folder.join("hard.tif")).unwrap();
    for output in [dem.clone(), folder.at("hard.tif"), folder.at("./dem.tif")] {
        let run = terrabite(["simplify", &dem, &output, "--format", "ply", "--max-error", "1", "--overwrite"]);
        run.fails(1, &[&output, "same file as the input"]);
    }
    assert_eq!(std::fs::read(&dem).unwrap(), before);
    assert_eq!(folder.names(), ["dem.tif", "hard.tif"]);
}

#[test]
fn temporary_folders_that_are_missing() {
    let (folder, dem) = with_dem();
    let missing = folder.at("none");
    let run = terrabite(["simplify", &dem, &folder.at("tin.ply"), "--max-error", "1", "--temp-dir", &missing]);
    run.fails(1, &[&missing, "--temp-dir"]);
    assert_eq!(folder.names(), ["dem.tif"]);
}

/// Every file is limited to 64 KiB, as if the disk were full: the decoded field does not fit; where the raster is
/// mapped in place the finished tiles do not.
#[test]
fn a_full_disk() {
    let folder = Folder::new();
    let temp = Folder::new();
    let rough = |c: usize, r: usize| ((c * 7919 + r * 104_729) % 1009) as f64;
    let plain = Dem::new(300, 300).heights(rough);
    let packed = plain.clone().compressed().write(&folder, "packed.tif");
    let plain = plain.write(&folder, "plain.tif");
    for dem in [&packed, &plain] {
        let tin = folder.at("tin.ply");
        let temp_dir = temp.at("");
        let arguments = ["simplify", dem, &tin, "--max-error", "0", "--quality", "none", "--temp-dir", &temp_dir];
        terrabite_with_file_limit(128, arguments).fails(1, &["File too large"]);
        assert_eq!(folder.names(), ["packed.tif", "plain.tif"]);
        assert_eq!(temp.names(), [""; 0]);
    }
}

/// The raster is mapped; another process cuts it in the middle of the run.
#[test]
fn a_mapped_raster_that_is_truncated_under_the_run() {
    let (folder, temp) = (Folder::new(), Folder::new());
    let rough = |c: usize, r: usize| ((c * 7919 + r * 104_729) % 1009) as f64;
    let dem = Dem::new(2000, 2000).heights(rough).write(&folder, "dem.tif");
    let arguments =
        ["simplify", &dem, &folder.at("tin.ply"), "--max-error", "3", "--tile", "128", "--temp-dir", &temp.at("")];
    let cut = || std::fs::OpenOptions::new().write(true).open(&dem).and_then(|f| f.set_len(5000)).is_ok();
    let run = terrabite_disturbed(arguments, cut);
    // Whichever comes first: a page that is gone, or the look at the file after every tile.
    let words = if run.err.contains("in use") { "in use" } else { "the raster has changed" };
    run.fails(1, &[&dem, words]);
    assert_eq!(folder.names(), ["dem.tif"]);
    assert_eq!(temp.names(), [""; 0]);
}

/// The same where windows are read through GDAL: it finds a block that is gone.
#[test]
fn a_raster_read_by_windows_that_is_truncated_under_the_run() {
    let (folder, temp) = (Folder::new(), Folder::new());
    let rough = |c: usize, r: usize| ((c * 7919 + r * 104_729) % 1009) as f64;
    let dem = Dem::new(2000, 2000).heights(rough).compressed().tiled(128).write(&folder, "dem.tif");
    let tin = folder.at("tin.ply");
    let arguments = ["simplify", &dem, &tin, "--max-error", "3", "--tile", "128", "--temp-dir", &temp.at("")];
    let cut = || std::fs::OpenOptions::new().write(true).open(&dem).and_then(|f| f.set_len(100_000)).is_ok();
    let run = terrabite_disturbed(arguments, cut);
    run.fails(1, &[&dem]);
    assert_eq!(folder.names(), ["dem.tif"]);
    assert_eq!(temp.names(), [""; 0]);
}

/// An interrupt in the middle of a run of several seconds. The partial output is there from the beginning.
#[test]
fn an_interrupted_run_leaves_nothing() {
    let (folder, temp) = (Folder::new(), Folder::new());
    let rough = |c: usize, r: usize| ((c * 7919 + r * 104_729) % 1009) as f64;
    let dem = Dem::new(2000, 2000).heights(rough).write(&folder, "dem.tif");
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let arguments =
            ["simplify", &dem, &folder.at("tin.ply"), "--max-error", "3", "--tile", "128", "--temp-dir", &temp.at("")];
        terrabite_stopped(signal, arguments, || folder.names().len() > 1).fails(code, &["stopped"]);
        assert_eq!(folder.names(), ["dem.tif"]);
        assert_eq!(temp.names(), [""; 0]);
    }
}
