//! `convert`, and the options that formats have, through the command.

use crate::util::{Dem, Folder, Kind, hills, terrabite};

/// Every extension that `simplify` and `convert` write.
const EXTENSIONS: [&str; 11] = ["ply", "obj", "glb", "stl", "xml", "landxml", "nc", "vtp", "2dm", "gpkg", "fgb"];

fn dem(folder: &Folder) -> String {
    Dem::new(60, 45).kind(Kind::Float32).heights(|c, r| hills(c, r) / 7.0).on_the_map().write(folder, "dem.tif")
}

#[test]
fn from_every_format_to_every_other() {
    let folder = Folder::new();
    let dem = dem(&folder);
    let ply = folder.at("tin.ply");
    let report = terrabite(["simplify", &dem, &ply, "--max-error", "1", "--json"]).succeeds().json();
    for (i, first) in EXTENSIONS.iter().enumerate() {
        let first = folder.at(&format!("first.{first}"));
        let converted = terrabite(["convert", &ply, &first, "--json"]).succeeds().json();
        assert_eq!(converted["schema"], 1);
        assert_eq!((&converted["triangles"], &converted["vertices"]), (&report["triangles"], &report["vertices"]));
        // The next one of the list, so that each is read and written once.
        let second = folder.at(&format!("second.{}", EXTENSIONS[(i + 1) % EXTENSIONS.len()]));
        // FlatGeobuf has no place for the frame of single precision.
        let is_single = first.ends_with("glb") || first.ends_with("stl");
        if second.ends_with("fgb") && is_single {
            continue;
        }
        let again = terrabite(["convert", &first, &second, "--json", "--overwrite"]).succeeds().json();
        assert_eq!(&again["triangles"], &report["triangles"], "{first} {second}");
        for mesh in [&first, &second] {
            terrabite(["verify", &dem, mesh, "--max-error", "1", "-q"]).succeeds();
        }
        terrabite(["preview", &dem, &first, &folder.at("picture.png"), "--overwrite", "-q"]).succeeds();
    }
}

#[test]
fn what_is_lost_is_said() {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).kind(Kind::Float64).bands(2).others(|_, c, r| (c * r) as f64 / 7.0).on_the_map();
    let dem = dem.heights(|c, r| hills(c, r) / 7.0).write(&folder, "dem.tif");
    let ply = folder.at("tin.ply");
    terrabite(["simplify", &dem, &ply, "--max-error", "1", "--attributes", "2", "-q"]).succeeds();
    let codes = |to: &str| {
        let report = terrabite(["convert", &ply, &folder.at(to), "--json"]).succeeds().json();
        let codes = report["warnings"].as_array().unwrap().iter().map(|w| w["code"].as_str().unwrap().to_string());
        (codes.collect::<Vec<_>>(), report["loss"].as_f64().unwrap(), report["max_error"].as_f64().unwrap())
    };
    assert_eq!(codes("tin.vtp"), (vec![], 0.0, 1.0));
    assert_eq!(codes("tin.obj"), (vec!["attributes_lost".to_string()], 0.0, 1.0));
    let (lost, loss, max_error) = codes("tin.stl");
    assert_eq!(lost, ["attributes_lost", "header_lost"]);
    assert!(loss > 0.0 && max_error == 1.0 + loss, "{loss} {max_error}");
    // A double attribute is refused beforehand where a run is to write it.
    let glb = folder.at("tin.glb");
    let simplify = ["simplify", &dem, &glb, "--max-error", "1", "--attributes", "2", "--z-scale", "1"];
    terrabite(simplify).fails(2, &["the format GLB", "--attributes"]);
    assert!(!folder.join("tin.glb").exists());
}

#[test]
fn options_of_other_formats_are_refused() {
    let folder = Folder::new();
    let dem = dem(&folder);
    for (output, option, words) in [
        ("tin.obj", &["--ascii"][..], "--ascii is for PLY, and this is OBJ"),
        ("tin.ply", &["--base-depth", "5"], "--base-depth is for STL, and this is PLY"),
        ("tin.ply", &["--mesh-compression", "meshopt"], "--mesh-compression is for GLB, and this is PLY"),
        ("tin.ply", &["--ogr-geometry", "tin"], "--ogr-geometry is for OGR, and this is PLY"),
        ("tin.stl", &["--normals", "area"], "--normals is for PLY, OBJ, GLB, VTP, and this is STL"),
        ("tin.ply", &["--texture", "none.tif"], "--texture is for OBJ, GLB, and this is PLY"),
    ] {
        let output = folder.at(output);
        let run = ["simplify", &dem, &output, "--max-error", "1"];
        terrabite(run.iter().chain(option)).fails(2, &[&output, words]);
    }
    let output = folder.at("tin.shp");
    let run = ["simplify", &dem, &output, "--max-error", "1", "--format"];
    terrabite(run.iter().chain(&["OGR:GeoJSON"])).fails(1, &["GPKG, FlatGeobuf", "GeoJSON, which"]);
    terrabite(run.iter().chain(&["OGR:Nonsense"])).fails(2, &["expected OGR:GPKG or OGR:FlatGeobuf"]);
    terrabite(run.iter().chain(&["wrl"])).fails(2, &["expected one of ply, obj, glb"]);
    let stl = folder.at("tin.stl");
    let run = ["simplify", &dem, &stl, "--max-error", "1", "--base-height", "1e6"];
    terrabite(run).fails(1, &["below the lowest height", "1000000"]);
    assert_eq!(folder.names(), ["dem.tif"]);
}

#[test]
fn solids_normals_and_textures() {
    let folder = Folder::new();
    let dem = dem(&folder);
    let image = Dem::new(30, 20).kind(Kind::Byte).bands(3).others(|b, c, r| ((b * 50 + c * 3 + r * 5) % 256) as f64);
    // The heights lie within 600 by 450 metres: the image has more.
    let image = image.geo_transform([499_000.0, 100.0, 0.0, 5_201_000.0, 0.0, -100.0]).epsg(32633);
    let image = image.write(&folder, "image.tif");
    let run = |output: &str, options: &[&str]| {
        let output = folder.at(output);
        let simplify = ["simplify", &dem, &output, "--max-error", "1", "--json"];
        let report = terrabite(simplify.iter().chain(options)).succeeds().json();
        terrabite(["verify", &dem, &output, "--max-error", "1", "-q"]).succeeds();
        (report, std::fs::read(&output).unwrap())
    };
    let (surface, bytes) = run("surface.stl", &[]);
    let triangles = surface["triangles"].as_u64().unwrap();
    assert_eq!(bytes.len() as u64, 84 + 50 * triangles);
    let (_, bytes) = run("solid.stl", &["--base-depth", "5"]);
    let count = u64::from(u32::from_le_bytes(bytes[80..84].try_into().unwrap()));
    assert!(count > 2 * triangles && bytes.len() as u64 == 84 + 50 * count);
    for normals in ["gradient", "area"] {
        let (_, bytes) = run(&format!("{normals}.ply"), &["--normals", normals]);
        let header = String::from_utf8_lossy(&bytes[..600]).into_owned();
        assert!(header.contains("property float nx\nproperty float ny\nproperty float nz\nelement face"), "{header}");
    }
    let (_, bytes) = run("draped.glb", &["--texture", &image, "--texture-size", "64", "--normals", "area"]);
    let json = String::from_utf8_lossy(&bytes[20..2000]).into_owned();
    assert!(json.contains("TEXCOORD_0") && json.contains("image/jpeg") && json.contains("NORMAL"), "{json}");
    run("draped.obj", &["--texture", &image]);
    assert!(folder.join("draped.mtl").exists() && folder.join("draped.jpg").exists());
    let (_, bytes) = run("packed.glb", &["--mesh-compression", "meshopt"]);
    assert!(String::from_utf8_lossy(&bytes[20..1500]).contains("EXT_meshopt_compression"));
    let (_, bytes) = run("text.ply", &["--ascii"]);
    assert!(bytes.starts_with(b"ply\nformat ascii 1.0\n"));
    let elsewhere = Dem::new(9, 9).kind(Kind::Byte).geo_transform([0.0, 1.0, 0.0, 0.0, 0.0, -1.0]).epsg(32633);
    let elsewhere = elsewhere.write(&folder, "elsewhere.tif");
    let glb = folder.at("none.glb");
    let run = ["simplify", &dem, &glb, "--max-error", "1", "--texture", &elsewhere];
    terrabite(run).fails(1, &["elsewhere.tif", "lies over the raster"]);
}

#[test]
fn degrees_become_metres_for_looking() {
    let folder = Folder::new();
    let dem = Dem::new(50, 40).heights(|c, r| hills(c, r) / 5.0);
    let dem = dem.geo_transform([-122.3, 0.001, 0.0, 46.2, 0.0, -0.001]).epsg(4326).write(&folder, "dem.tif");
    let scale = |output: &str| {
        let output = folder.at(output);
        let report = terrabite(["simplify", &dem, &output, "--max-error", "2", "--json"]).succeeds().json();
        terrabite(["verify", &dem, &output, "--max-error", "2", "-q"]).succeeds();
        report["map"]["xy_scale"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(scale("tin.ply"), [1.0, 1.0]);
    for output in ["tin.glb", "tin.stl"] {
        // A degree of longitude at 46.18 degrees, and one of latitude.
        let found = scale(output);
        assert!((found[0] - 77_212.0).abs() < 10.0 && (found[1] - 111_155.0).abs() < 10.0, "{found:?}");
    }
}

#[test]
fn coordinates_become_local_and_heights_scaled() {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).on_the_map().heights(|c, r| hills(c, r) / 7.0).write(&folder, "dem.tif");
    let (ply, local, single) = (folder.at("tin.ply"), folder.at("local.obj"), folder.at("single.glb"));
    terrabite(["simplify", &dem, &ply, "--max-error", "1", "-q"]).succeeds();
    let report = terrabite(["convert", &ply, &local, "--local", "--z-scale", "3", "--json"]).succeeds().json();
    assert_eq!((&report["z_scale"], &report["precision"]), (&3.0.into(), &"double".into()));
    assert!(report["offset"][0].as_f64().is_some_and(|x| x != 0.0));
    let loosened = report["max_error"].to_string();
    terrabite(["verify", &dem, &local, "--max-error", &loosened, "-q"]).succeeds();
    let again = ["convert", &local, &folder.at("b.ply"), "--z-scale", "2"];
    terrabite(again).fails(1, &["local.obj", "heights that were multiplied already", "--z-scale"]);
    terrabite(["convert", &ply, &single, "-q"]).succeeds();
    let again = ["convert", &single, &folder.at("b.ply"), "--z-scale", "2"];
    terrabite(again).fails(1, &["single.glb", "single precision", "--z-scale"]);
    terrabite(["convert", &single, &folder.at("b.ply"), "--local", "-q"]).succeeds();
    terrabite(["convert", &ply, &folder.at("c.ply"), "--z-scale", "0"]).fails(2, &["--z-scale"]);
}

#[test]
fn heights_beyond_single_precision_are_refused() {
    let folder = Folder::new();
    let dem = Dem::new(40, 30).on_the_map().write(&folder, "dem.tif");
    let ply = folder.at("tin.ply");
    terrabite(["simplify", &dem, &ply, "--max-error", "1", "-q"]).succeeds();
    for (to, options) in [
        ("far.stl", &["--z-scale", "1e38"][..]),
        ("far.ply", &["--z-scale", "1e38", "--precision", "float"]),
        ("far.obj", &["--z-scale", "1e308"]),
    ] {
        let output = folder.at(to);
        terrabite([&["convert", &ply, &output], options].concat()).fails(1, &[to, "expected finite coordinates"]);
        assert!(!folder.join(to).exists(), "{to}");
    }
}
