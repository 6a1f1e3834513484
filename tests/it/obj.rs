//! OBJ from end to end: written, certified, drawn, with its CRS beside it.

use crate::util::{Dem, Folder, Kind, hills, terrabite, terrabite_with_fault};

fn dem(folder: &Folder) -> String {
    let dem = Dem::new(70, 50).kind(Kind::Float64).heights(|c, r| hills(c, r) / 7.0).on_the_map();
    dem.write(folder, "dem.tif")
}

#[test]
fn written_certified_drawn() {
    let folder = Folder::new();
    let dem = dem(&folder);
    let (ply, obj, png) = (folder.at("tin.ply"), folder.at("tin.obj"), folder.at("tin.png"));
    let prj = folder.join("tin.prj");
    let of_ply = terrabite(["simplify", &dem, &ply, "--max-error", "0.5", "--tile", "20", "--json"]).succeeds().json();
    let verdict = |tin: &str| terrabite(["verify", &dem, tin, "--max-error", "0.5", "--json"]).succeeds().json();
    let of_ply = (of_ply["triangles"].clone(), verdict(&ply));
    for options in [&["--local"][..], &["--precision", "float"], &["--z-scale", "0.3048"], &[]] {
        let simplify = ["simplify", &dem, &obj, "--max-error", "0.5", "--tile", "20", "--json", "--overwrite"];
        let report = terrabite(simplify.iter().chain(options)).succeeds().json();
        let found = verdict(&obj);
        let is_plain = options.is_empty();
        // Coordinates less an origin are not those of the CRS.
        assert_eq!(prj.exists(), is_plain || options[0] == "--z-scale", "{options:?}");
        if is_plain {
            // The same doubles: the same verdict.
            assert_eq!((report["triangles"].clone(), found), of_ply);
        }
    }
    let text = std::fs::read_to_string(&obj).unwrap();
    assert!(text.contains("\n# crs:EPSG:32633\n") && text.contains("\n# max_error 0.5\n"), "{text}");
    assert!(std::fs::read_to_string(&prj).unwrap().starts_with("PROJCS[\"WGS_1984_UTM_Zone_33N\""));
    terrabite(["preview", &dem, &obj, &png, "--mode", "error", "-q"]).succeeds();
    // Under any name, by what it is.
    let other = folder.at("other.ply");
    terrabite(["simplify", &dem, &other, "--max-error", "0.5", "--tile", "20", "--format", "obj", "-q"]).succeeds();
    assert_eq!(std::fs::read_to_string(&other).unwrap(), text);
    terrabite(["verify", &dem, &other, "--max-error", "0.5", "-q"]).succeeds();
}

#[test]
fn torn_and_spoilt_files_name_the_line() {
    let folder = Folder::new();
    let dem = dem(&folder);
    let obj = folder.at("tin.obj");
    terrabite(["simplify", &dem, &obj, "--max-error", "2", "-q"]).succeeds();
    let text = std::fs::read_to_string(&obj).unwrap();
    let verify = |text: &str| {
        std::fs::write(&obj, text).unwrap();
        terrabite(["verify", &dem, &obj, "--max-error", "2", "-q"])
    };
    verify(&text[..text.len() / 2]).fails(1, &[&obj, "# end of mesh", "line "]);
    let lines = text.lines().count();
    let spoilt = text.replace("# end of mesh", "f 1 2 0\n# end of mesh");
    verify(&spoilt).fails(1, &[&obj, "triangles"]);
    let spoilt = spoilt.replacen("# mesh of ", "# a mesh of ", 1);
    verify(&spoilt).fails(1, &[&obj, &format!("line {lines}: expected vertices 1 to"), "found 0"]);
}

#[test]
fn a_crs_that_lies_there_already_is_not_replaced_unasked() {
    let folder = Folder::new();
    let dem = dem(&folder);
    let obj = folder.at("tin.obj");
    let prj = folder.with("tin.prj", "of something else");
    let run = ["simplify", &dem, &obj, "--max-error", "2", "-q"];
    terrabite(run).fails(1, &[&prj, "exists already"]);
    terrabite(run.iter().chain(&["--local"])).fails(1, &[&prj, "exists already"]);
    assert_eq!(folder.names(), ["dem.tif", "tin.prj"]);
    terrabite(run.iter().chain(&["--overwrite"])).succeeds();
    assert!(std::fs::read_to_string(&prj).unwrap().starts_with("PROJCS"));
    terrabite(run.iter().chain(&["--local", "--overwrite"])).succeeds();
    assert_eq!(folder.names(), ["dem.tif", "tin.obj"]);
}

/// The CRS has its name and the mesh has not: the same command goes on, without --overwrite.
#[test]
fn a_run_killed_between_the_two_files_continues() {
    let folder = Folder::new();
    let dem = dem(&folder);
    let (obj, work) = (folder.at("tin.obj"), folder.at("work"));
    let run = ["simplify", &dem, &obj, "--max-error", "2", "--work-dir", &work, "-q"];
    assert_eq!(terrabite_with_fault("kill:companion-placed:1", run).code, None);
    assert!(folder.join("tin.prj").exists() && !folder.join("tin.obj").exists());
    terrabite(run).succeeds();
    assert_eq!(folder.names(), ["dem.tif", "tin.obj", "tin.prj"]);
}

#[test]
fn attributes_that_are_left_out_are_told() {
    let folder = Folder::new();
    let dem =
        Dem::new(40, 30).bands(3).others(|band, c, r| (band * 40 + c + r) as f64 % 256.0).write(&folder, "dem.tif");
    let (ply, obj) = (folder.at("tin.ply"), folder.at("tin.obj"));
    for (tin, is_told) in [(&ply, false), (&obj, true)] {
        let simplify = ["simplify", &dem, tin, "--max-error", "5", "--attributes", "2,3"];
        let run = terrabite(simplify).succeeds();
        assert_eq!(run.err.contains("keeps no attributes of vertices: band_2, band_3"), is_told, "{}", run.err);
        let json = terrabite(simplify.iter().chain(&["--json", "--overwrite"])).succeeds().json();
        let codes: Vec<&str> = json["warnings"].as_array().unwrap().iter().filter_map(|w| w["code"].as_str()).collect();
        assert_eq!(codes.contains(&"attributes_lost"), is_told, "{codes:?}");
    }
    let verify = ["verify", &dem, &obj, "--max-error", "5"];
    terrabite(verify).succeeds();
    terrabite(verify.iter().chain(&["--attributes", "2,3"])).fails(1, &[&obj, "attribute \"band_2\""]);
}
