//! Names, sizes and samples that nobody expects, and files that must survive.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::util::{Dem, Folder, Halted, Kind, terrabite, terrabite_with_fault};

fn words<const N: usize>(words: [&OsStr; N]) -> Vec<OsString> {
    words.map(OsStr::to_os_string).to_vec()
}

#[test]
fn names_with_blanks_and_bytes_that_are_no_utf_8() {
    let folder = Folder::new();
    let odd = folder.join("").join(OsStr::from_bytes(b"h\xf6hen modell"));
    std::fs::create_dir(&odd).unwrap();
    let made = Dem::new(40, 30).on_the_map().write(&folder, "dem.tif");
    let packed = Dem::new(40, 30).on_the_map().tiled(16).compressed().write(&folder, "packed.tif");
    let layer = folder.with("points.csv", "x,y\n500205,5199895\n");
    let moved = |from: &str, name: &[u8]| -> PathBuf {
        let to = odd.join(OsStr::from_bytes(name));
        std::fs::copy(from, &to).unwrap();
        to
    };
    let points = moved(&layer, b"spitz\xe9 1.csv");
    for (from, name) in
        [(&made, &b"dem 1.tif"[..]), (&made, b"dem \xff1.tif"), (&packed, b"packed \xff1.tif"), (&packed, b"d\xe9m")]
    {
        let dem = moved(from, name);
        let tin = odd.join(OsStr::from_bytes(b"netz\xff 1.ply"));
        let png = odd.join(OsStr::from_bytes(b"bild\xff 1.png"));
        let (dem, tin, png) = (dem.as_os_str(), tin.as_os_str(), png.as_os_str());
        let [simplify, verify, preview, info] = ["simplify", "verify", "preview", "info"].map(OsStr::new);
        let [error, two, overwrite, with] = ["--max-error", "2", "--overwrite", "--points"].map(OsStr::new);
        terrabite(words([simplify, dem, tin, error, two, overwrite, with, points.as_os_str()])).succeeds();
        terrabite(words([verify, dem, tin, error, two])).succeeds();
        terrabite(words([preview, dem, tin, png, overwrite])).succeeds();
        terrabite(words([info, dem])).succeeds();
    }
    let terrain = odd.join(OsStr::from_bytes(b"gel\xe4nde.tif"));
    let [synth, size, small] = ["synth", "--size", "32x32"].map(OsStr::new);
    terrabite(words([synth, terrain.as_os_str(), size, small])).succeeds();
    assert!(terrain.is_file());
    assert_eq!(odd.read_dir().unwrap().count(), 8, "{:?}", odd.read_dir().unwrap().collect::<Vec<_>>());
}

#[test]
fn an_infinite_sample_is_named() {
    fn infinite(column: usize, row: usize) -> f64 {
        if (column, row) == (7, 4) { f64::NEG_INFINITY } else { 3.0 }
    }
    let folder = Folder::new();
    let flat = Dem::new(20, 10).heights(|_, _| 3.0).write(&folder, "flat.tif");
    let tin = folder.at("tin.ply");
    terrabite(["simplify", &flat, &tin, "--max-error", "1"]).succeeds();
    for (kind, access) in [(Kind::Float32, "in-place"), (Kind::Float64, "windows"), (Kind::Float32, "decode")] {
        let dem = Dem::new(20, 10).kind(kind).heights(infinite).write(&folder, "dem.tif");
        let words = ["dem.tif", "-inf at column 7, row 4"];
        let out = folder.at("out.ply");
        terrabite(["simplify", &dem, &out, "--max-error", "1", "--access", access]).fails(1, &words);
        terrabite(["verify", &dem, &tin, "--max-error", "1"]).fails(1, &["dem.tif", "column 7, row 4", "-inf"]);
    }
    assert_eq!(folder.names(), ["dem.tif", "flat.tif", "tin.ply"]);
}

/// One is as large as GDAL lets a VRT be. Nothing of it may be allocated.
#[test]
fn rasters_that_claim_to_be_huge() {
    let folder = Folder::new();
    Dem::new(20, 20).on_the_map().write(&folder, "dem.tif");
    let claims = |width: u64, height: u64| {
        let band = r#"<VRTRasterBand dataType="Float64" band="1"><SimpleSource><SourceFilename
            relativeToVRT="1">dem.tif</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand>"#;
        let text = format!(r#"<VRTDataset rasterXSize="{width}" rasterYSize="{height}">{band}</VRTDataset>"#);
        folder.with("huge.vrt", text)
    };
    let tin = folder.at("tin.ply");
    let flat = folder.with("flat.ply", crate::util::flat(20, 20, 0.0));
    let start = Instant::now();
    let huge = claims(1_000_000_000, 1_000_000_000);
    // Numbering takes memory for each column, which is more than there usually is; then the disk is too small.
    let run = terrabite(["simplify", &huge, &tin, "--max-error", "1"]);
    run.fails(3, &["expected a memory budget of at least", "--memory"]);
    let run = terrabite(["simplify", &huge, &tin, "--max-error", "1", "--memory", "300GiB"]);
    run.fails(4, &["bytes free", "--temp-dir"]);
    terrabite(["info", &huge]).succeeds();
    for command in ["verify", "preview"] {
        let more: &[&str] = if command == "verify" { &["--max-error", "1"] } else { &["out.png"] };
        let run = terrabite([command, &huge, &flat].iter().chain(more));
        run.fails(1, &["huge.vrt", "at most 67108864 samples across, found 1000000000", "--window"]);
    }
    // A part of it is a raster like any other.
    let part = ["--window", "0,0,100,90"];
    terrabite(["simplify", &huge, &tin, "--max-error", "1"].into_iter().chain(part)).succeeds();
    terrabite(["verify", &huge, &tin, "--max-error", "1"].into_iter().chain(part)).succeeds();
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
}

#[test]
fn the_old_output_survives_whatever_ends_a_run() {
    let folder = Folder::new();
    let good = Dem::new(60, 50).write(&folder, "good.tif");
    let bad = Dem::new(60, 50).kind(Kind::Float32).heights(|c, _| if c == 59 { f64::INFINITY } else { 1.0 });
    let bad = bad.write(&folder, "bad.tif");
    let tin = folder.with("tin.ply", "old");
    let run = |dem: &str| ["simplify", dem, &tin, "--max-error", "1", "--overwrite"].map(str::to_string);
    let old = || String::from_utf8_lossy(&std::fs::read(&tin).unwrap()).into_owned();
    terrabite(run(&bad)).fails(1, &["column 59"]);
    assert_eq!(
        (old(), folder.names()),
        ("old".to_string(), ["bad.tif", "good.tif", "tin.ply"].map(String::from).to_vec())
    );
    for point in ["vertices", "triangles", "output-written"] {
        terrabite_with_fault(&format!("kill:{point}:1"), run(&good));
        assert_eq!(old(), "old", "{point}");
    }
    terrabite(run(&good)).succeeds();
    assert!(old().starts_with("ply"));
}

/// What others see of a run that is under way.
#[test]
fn files_are_private_while_they_are_incomplete() {
    let folder = Folder::new();
    let dem = Dem::new(60, 50).write(&folder, "dem.tif");
    let (tin, work) = (folder.at("tin.ply"), folder.at("work"));
    let all = ["simplify", &dem, &tin, "--max-error", "1", "--work-dir", &work, "--tile", "16"];
    let halted = Halted::at("vertices", 1, all);
    let (mut looked_at, mut folders) = (0, vec![folder.path().to_path_buf()]);
    while let Some(next) = folders.pop() {
        for entry in next.read_dir().unwrap() {
            let path = entry.unwrap().path();
            if path.ends_with("dem.tif") {
                continue;
            }
            let found = path.symlink_metadata().unwrap();
            assert_eq!(found.permissions().mode() & 0o077, 0, "{}", path.display());
            looked_at += 1;
            if found.is_dir() {
                folders.push(path);
            }
        }
    }
    assert!(looked_at > 12, "{looked_at}");
    // Nobody else's link is written through: the name is taken from it.
    let letters = folder.with("letters.txt", "dear");
    symlink(&letters, &tin).unwrap();
    let run = halted.go_on();
    assert_eq!(std::fs::read_to_string(&letters).unwrap(), "dear", "{run:?}");
    assert_eq!(run.code, Some(1), "{run:?}");
    let mut all: Vec<&str> = all.to_vec();
    all.push("--overwrite");
    std::fs::remove_file(&tin).unwrap();
    let halted = Halted::at("vertices", 1, &all);
    symlink(&letters, &tin).unwrap();
    halted.go_on().succeeds();
    assert_eq!(std::fs::read_to_string(&letters).unwrap(), "dear");
    assert!(!folder.join("tin.ply").is_symlink());
}
