//! `--attributes`, `--attribute-weight` and `--image`: from bands to colours of vertices, what is refused, and what `verify` makes
//! of a mesh with colours.

use std::fs;

use crate::util::{Dem, Folder, Kind, terrabite, terrabite_with_fault};

/// Hills in the first band, and in three more a picture: a disc on a ground that fades.
fn coloured_hills() -> Dem {
    fn picture(band: usize, column: usize, row: usize) -> f64 {
        let (x, y) = (column as f64 - 50.0, row as f64 - 40.0);
        let ground = (column + row) as f64 / 8.0 * band as f64;
        if x.hypot(y) < 25.0 { 230.0 - 30.0 * band as f64 } else { ground.floor() }
    }
    // Else GDAL takes the fourth of four bands of bytes for a mask.
    let plain = Dem::new(100, 80).kind(Kind::Byte).option("PHOTOMETRIC=MINISBLACK").option("ALPHA=NO");
    plain.bands(4).others(picture)
}

const COLOURS: [&str; 4] = ["--max-error", "4", "--attributes", "2,3,4"];
const INSERTION: [&str; 6] = ["--engine", "greedy-insertion", "--tile", "32", "--quality", "none"];

/// `simplify` with colours, and the engine that keeps them, which is the default then, as is polishing.
fn simplify<'a>(dem: &'a str, tin: &'a str, options: &[&'a str]) -> Vec<&'a str> {
    ["simplify", dem, tin, "--overwrite", "--json"]
        .iter()
        .chain(&COLOURS)
        .chain(&["--tile", "32"])
        .chain(options)
        .copied()
        .collect()
}

fn header(tin: &str) -> String {
    let bytes = fs::read(tin).unwrap();
    let end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap();
    String::from_utf8(bytes[..end].to_vec()).unwrap()
}

#[test]
fn colours_come_along() {
    let folder = Folder::new();
    let (dem, tin) = (coloured_hills().write(&folder, "dem.tif"), folder.at("tin.ply"));
    for options in
        [&[][..], &["--swap", "data-dependent"], &["--measure", "global-error"], &["--attribute-weight", "0.9"]]
    {
        let report = terrabite(simplify(&dem, &tin, options)).succeeds().json();
        let header = header(&tin);
        assert!(header.contains("property uchar red\nproperty uchar green\nproperty uchar blue\n"), "{header}");
        assert!(header.contains("channels 2,3,4, emphasis 0."), "{header}");
        let emphasis = options.iter().skip_while(|o| **o != "--attribute-weight");
        let verify = ["verify", &dem, &tin, "--json"].into_iter().chain(COLOURS).chain(emphasis.copied());
        let verdict = terrabite(verify).succeeds().json();
        let judged = verdict["attributes"]["worst"]["error"].as_f64().unwrap();
        let measured = report["attributes"]["max_error"].as_f64().unwrap();
        assert!(judged <= 4.0 && (judged - measured).abs() < 1e-9, "{judged}, {measured}");
    }
    // Heights alone need fewer vertices, and such a mesh has the colours of none.
    let with = terrabite(simplify(&dem, &tin, &["--quality", "none"])).succeeds().json()["vertices"].as_u64();
    let heights = ["simplify", &dem, &tin, "--max-error", "4", "--overwrite", "--json"];
    let without = terrabite(heights.iter().chain(&INSERTION)).succeeds().json()["vertices"].as_u64();
    assert!(without < with, "{without:?}, {with:?}");
    terrabite(["verify", &dem, &tin].iter().chain(&COLOURS)).fails(1, &["attribute \"red\""]);
}

#[test]
fn a_planar_image_becomes_a_flat_mesh_with_its_colours() {
    let folder = Folder::new();
    let image = coloured_hills().bands(3).write(&folder, "image.tif");
    let tin = folder.at("tin.ply");
    for (swap, quality, most) in
        [("delaunay", "none", 4000), ("data-dependent", "none", 4000), ("delaunay", "balanced", 2000)]
    {
        let planar = ["simplify", &image, &tin, "--max-error", "10", "--image", "--swap", swap, "--quality", quality];
        let report = terrabite(planar.iter().chain(&["--tile", "32", "--overwrite", "--json"])).succeeds().json();
        assert_eq!(report["error"]["max"], 0.0);
        assert!(report["vertices"].as_u64() < Some(most), "{report}");
        let verdict = terrabite(["verify", &image, &tin, "--max-error", "10", "--image"]).succeeds();
        assert!(verdict.out.contains("max error of heights and attributes"), "{verdict:#?}");
        assert_eq!(terrabite(["verify", &image, &tin, "--max-error", "1", "--image"]).code, Some(1));
    }
}

#[test]
fn threads_access_and_layout_do_not_change_a_byte() {
    let folder = Folder::new();
    let (dem, tin) = (coloured_hills().write(&folder, "dem.tif"), folder.at("tin.ply"));
    for swap in ["delaunay", "data-dependent"] {
        let bytes = |options: &[&str]| {
            terrabite(simplify(&dem, &tin, &[&["--swap", swap], options].concat())).succeeds();
            fs::read(&tin).unwrap()
        };
        let expected = bytes(&["--threads", "1"]);
        for options in [["--threads", "3"], ["--access", "windows"], ["--access", "decode"]] {
            assert!(bytes(&options) == expected, "{swap} {options:?}");
        }
        coloured_hills().compressed().stripped(16).write(&folder, "dem.tif");
        assert!(bytes(&[]) == expected, "{swap}");
    }
}

#[test]
fn a_run_continues_with_the_same_channels_only() {
    let folder = Folder::new();
    let dem = coloured_hills().write(&folder, "dem.tif");
    let (tin, work) = (folder.at("tin.ply"), folder.at("work"));
    terrabite(simplify(&dem, &tin, &[])).succeeds();
    let expected = fs::read(&tin).unwrap();
    fs::remove_file(&tin).unwrap();
    let kept = |options: &[&str]| {
        simplify(&dem, &tin, &[&["--work-dir", &work], options].concat())
            .iter()
            .map(|w| w.to_string())
            .collect::<Vec<_>>()
    };
    assert_eq!(terrabite_with_fault("kill:chunk-renamed:5", kept(&[])).code, None);
    terrabite(kept(&["--attribute-weight", "0.25"])).fails(1, &[&work, "--attribute-weight: "]);
    let run = terrabite(kept(&[])).succeeds();
    assert!(run.json()["tiles_found"].as_u64() >= Some(5), "{run:#?}");
    assert!(fs::read(&tin).unwrap() == expected);
}

#[test]
fn points_may_stand_beside_channels() {
    let folder = Folder::new();
    let (dem, tin) = (coloured_hills().write(&folder, "dem.tif"), folder.at("tin.ply"));
    let places = [(40.5f64, -32.5f64), (7.5, -3.5), (32.5, -9.5)];
    let rows: String = places.iter().map(|(x, y)| format!("{x},{y}\n")).collect();
    let points = folder.with("points.csv", format!("x,y\n{rows}"));
    terrabite(simplify(&dem, &tin, &["--points", &points])).succeeds();
    terrabite(["verify", &dem, &tin].iter().chain(&COLOURS)).succeeds();
    let bytes = fs::read(&tin).unwrap();
    for (x, y) in places {
        let vertex = [x.to_le_bytes(), y.to_le_bytes()].concat();
        assert!(bytes.windows(16).any(|w| w == vertex), "{x}, {y}");
    }
}

#[test]
fn weights_and_fitted_heights_do_not_stand_beside_channels() {
    let folder = Folder::new();
    let (dem, tin) = (coloured_hills().write(&folder, "dem.tif"), folder.at("tin.ply"));
    terrabite(simplify(&dem, &tin, &["--importance", &dem])).fails(2, &["--importance", "--attributes"]);
    terrabite(["verify", &dem, &tin, "--importance", &dem, "--max-error", "1", "--image"])
        .fails(2, &["--importance", "--image"]);
    let why = "there are no attribute values";
    terrabite(simplify(&dem, &tin, &["--heights", "fitted"]))
        .fails(2, &["--attributes", why, "remove --heights fitted"]);
    assert_eq!(folder.names(), ["dem.tif"]);
}

/// The tolerance that is found bounds heights and colours.
#[test]
fn a_budget_is_kept_with_colours() {
    let folder = Folder::new();
    let (dem, tin) = (coloured_hills().write(&folder, "dem.tif"), folder.at("tin.ply"));
    let colours = ["--attributes", "2,3,4", "--attribute-weight", "0.5"];
    let simplify = ["simplify", &dem, &tin, "--max-triangles", "1500", "--tile", "32", "--json"];
    let told = terrabite(simplify.iter().chain(&colours)).succeeds().json();
    assert!((1400..=1500).contains(&told["triangles"].as_u64().unwrap()), "{told}");
    let verify = ["verify", &dem, &tin, "--max-error", &told["tolerance"].to_string()];
    terrabite(verify.iter().chain(&colours)).succeeds();
}

/// By every quality, in tiles whose sides are polished, too, where that is worth it.
#[test]
fn meshes_with_colours_are_polished() {
    let folder = Folder::new();
    let (dem, tin) = (coloured_hills().write(&folder, "dem.tif"), folder.at("tin.ply"));
    let mut triangles = Vec::new();
    for quality in ["none", "fast", "balanced", "best"] {
        let options = ["--quality", quality, "--min-angle", "5", "--polish-edges", "weak", "--max-stray", "2"];
        let options = if quality == "none" { &options[..2] } else { &options[..] };
        let report = terrabite(simplify(&dem, &tin, options)).succeeds().json();
        let verify = ["verify", &dem, &tin, "--json"].into_iter().chain(COLOURS);
        let straying = if quality == "none" { &[][..] } else { &["--max-stray", "2"] };
        let verdict = terrabite(verify.chain(straying.iter().copied())).succeeds().json();
        let judged = verdict["attributes"]["worst"]["error"].as_f64().unwrap();
        let measured = report["attributes"]["max_error"].as_f64().unwrap();
        assert!(judged <= 4.0 && (judged - measured).abs() < 1e-9, "{quality}: {judged}, {measured}");
        triangles.push(report["triangles"].as_u64().unwrap());
    }
    let [none, fast, balanced, best] = triangles[..] else { panic!("{triangles:?}") };
    assert!(10 * fast < 6 * none && 2 * balanced < none && 2 * best < none, "{triangles:?}");
}

/// Three bands of bytes, all of them this.
fn grey(column: usize, row: usize) -> f64 {
    (10 * column + row) as f64
}

fn with_image() -> (Folder, String) {
    let folder = Folder::new();
    let image = Dem::new(20, 10).kind(Kind::Byte).bands(3).heights(grey).write(&folder, "image.tif");
    (folder, image)
}

/// The corners of the image as two flat triangles, with their colours made darker by `darker`.
fn coloured(darker: f64) -> String {
    let corner = |(x, y, column, row): (f64, f64, usize, usize)| {
        let grey = grey(column, row) - darker;
        format!("{x} {y} 0 {grey} {grey} {grey}\n")
    };
    let corners = [(0.5, -0.5, 0, 0), (0.5, -9.5, 0, 9), (19.5, -9.5, 19, 9), (19.5, -0.5, 19, 0)].map(corner).concat();
    let header = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n\
        property float red\nproperty float green\nproperty float blue\nelement face 2\n\
        property list uchar uint vertex_indices\nend_header\n";
    format!("{header}{corners}3 0 1 2\n3 0 2 3\n")
}

#[test]
fn channels_need_an_engine_that_keeps_them() {
    let (folder, image) = with_image();
    let tin = folder.at("tin.ply");
    for channels in [&["--attributes", "2,3"][..], &["--image"], &["--image", "--attributes", "3"]] {
        let run = ["simplify", &image, &tin, "--max-error", "1", "--engine", "greedy-cuts"];
        let run = run.into_iter().chain(channels.iter().copied());
        terrabite(run).fails(2, &["greedy cuts", "--engine greedy-insertion"]);
    }
    assert_eq!(folder.names(), ["image.tif"]);
}

#[test]
fn bands_and_emphases_that_are_none() {
    let (folder, image) = with_image();
    let tin = folder.with("tin.ply", coloured(0.0));
    let output = folder.at("new.ply");
    for command in [["simplify", &image, &output], ["verify", &image, &tin]] {
        let refused = |options: &[&str], code, words: &[&str]| {
            let arguments = command.iter().copied().chain(["--max-error", "1"]).chain(options.iter().copied());
            terrabite(arguments).fails(code, words);
        };
        refused(&["--attributes", "2,4"], 1, &[&image, "band 4", "bands 1 to 3", "--attributes"]);
        for wrong in ["0", "2,2", "two", "", "2-3"] {
            refused(&["--attributes", wrong], 2, &["--attributes", "expected"]);
        }
        for wrong in ["-0.1", "1.5", "nan", "much"] {
            refused(&["--attributes", "2", "--attribute-weight", wrong], 2, &["--attribute-weight", "from 0 to 1"]);
        }
        refused(&["--attribute-weight", "0.5"], 2, &["--attributes"]);
        refused(&["--image", "--attributes", "2", "--attribute-weight", "0.5"], 2, &["--image"]);
        refused(&["--image", "--band", "2"], 2, &["--image"]);
    }
    assert_eq!(folder.names(), ["image.tif", "tin.ply"]);
}

#[test]
fn samples_without_a_value_are_refused_by_band() {
    let folder = Folder::new();
    let hole = |_: usize, c: usize, r: usize| if (c, r) == (7, 5) { f64::NAN } else { 3.0 };
    let strange = Dem::new(20, 10).kind(Kind::Float32).bands(2).others(hole).write(&folder, "strange.tif");
    let tin = folder.at("tin.ply");
    terrabite(["simplify", &strange, &tin, "--max-error", "1", "--attributes", "2"])
        .fails(1, &[&strange, "band 2", "column 7, row 5", "gdal_fillnodata"]);
}

/// A sample of an image is there if every band has a value.
#[test]
fn images_have_voids() {
    fn collar(c: usize, r: usize) -> f64 {
        if c < 9 || r + c > 95 { 0.0 } else { ((3 * c + 2 * r) % 200 + 1) as f64 }
    }
    fn others(band: usize, c: usize, r: usize) -> f64 {
        if (c, r) == (40, 20 + band) { 0.0 } else { collar(c + band, r) }
    }
    let folder = Folder::new();
    let image = Dem::new(70, 60).kind(Kind::Byte).bands(3).heights(collar).others(others);
    let missing = (0..70 * 60).filter(|i| {
        let (c, r) = (i % 70, i / 70);
        collar(c, r) == 0.0 || (2..4).any(|band| others(band, c, r) == 0.0)
    });
    let missing = missing.count() as u64;
    let (plain, tin) = (image.write(&folder, "plain.tif"), folder.at("tin.ply"));
    let tagged = image.nodata(0.0).write(&folder, "tagged.tif");
    for (image, marks) in [(&tagged, &[][..]), (&plain, &["--nodata", "0"])] {
        for access in ["windows", "decode"] {
            let run =
                ["simplify", image, &tin, "--max-error", "20", "--image", "--tile", "32", "--overwrite", "--json"];
            let told = terrabite(run.iter().chain(&["--access", access]).chain(marks)).succeeds().json();
            assert_eq!(told["missing_samples"], missing, "{access} {marks:?}");
        }
        let verify = ["verify", image, &tin, "--max-error", "20", "--image", "--json"];
        assert_eq!(terrabite(verify.iter().chain(marks)).succeeds().json()["missing_samples"], missing);
    }
    // Without the mark the mesh leaves ground out.
    assert_eq!(terrabite(["verify", &plain, &tin, "--max-error", "20", "--image"]).code, Some(1));
}

#[test]
fn verify_judges_colours() {
    let (folder, image) = with_image();
    let tin = folder.with("tin.ply", coloured(0.0));
    let exact = terrabite(["verify", &image, &tin, "--max-error", "1e-9", "--image"]).succeeds();
    assert!(exact.out.contains("max error of heights and attributes") && exact.out.contains("PASS"), "{exact:#?}");
    let tin = folder.with("tin.ply", coloured(3.0));
    let judge = |tolerance| terrabite(["verify", &image, &tin, "--max-error", tolerance, "--image", "--json"]);
    let passed = judge("3").json();
    assert!((passed["attributes"]["worst"]["error"].as_f64().unwrap() - 3.0).abs() < 1e-12, "{passed}");
    let failed = judge("2.9");
    assert_eq!((failed.code, &failed.json()["attributes"]["above_tolerance"]["count"]), (Some(1), &200.into()));
    // Heights alone do not ask for attributes, and a report without channels does not speak of them.
    let plain = terrabite(["verify", &image, &tin, "--max-error", "300", "--json", "--band", "1"]).succeeds().json();
    assert!(plain.get("attributes").is_none());
    // With heights: (1 − 0.25)·|Δz| and a quarter of the colours' share of the range of heights, 199.
    let weighted =
        ["verify", &image, &tin, "--max-error", "300", "--attributes", "1,2,3", "--attribute-weight", "0.25", "--json"];
    let found = terrabite(weighted).succeeds().json()["attributes"]["worst"]["error"].as_f64().unwrap();
    let expected = 0.75 * 199.0 + 0.25 * 199.0 * 3.0 / 255.0;
    assert!((found - expected).abs() < 1e-9, "{found} against {expected}");
}

#[test]
fn attributes_that_are_missing_are_named() {
    let (folder, image) = with_image();
    let tin = folder.with("tin.ply", coloured(0.0).replace("property float green", "property float grün"));
    terrabite(["verify", &image, &tin, "--max-error", "1", "--image"]).fails(1, &[&tin, "attribute \"green\""]);
    terrabite(["preview", &image, &tin, &folder.at("out.png"), "--mode", "colour"])
        .fails(1, &[&tin, "attribute \"green\""]);
    assert_eq!(folder.names(), ["image.tif", "tin.ply"]);
}
