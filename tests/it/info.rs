//! `terrabite info`.

use serde_json::json;

use crate::util::{Dem, Folder, Kind, shared_data, terrabite};

#[test]
fn describes_a_raster() {
    let folder = Folder::new();
    let dem = Dem::new(100, 70).on_the_map().nodata(-32768.0).tiled(32).compressed().write(&folder, "dem.tif");
    let info = terrabite(["info", &dem, "--json"]).succeeds().json();
    let expected = [
        ("driver", json!("GTiff")),
        ("band", json!(1)),
        ("width", json!(100)),
        ("height", json!(70)),
        ("type", json!("Int16")),
        ("nodata", json!(-32768.0)),
        ("scale", json!(1.0)),
        ("crs", json!("EPSG:32633 (WGS 84 / UTM zone 33N)")),
        ("georeferenced", json!(true)),
        ("geotransform", json!([500_000.0, 10.0, 0.0, 5_200_000.0, 0.0, -10.0])),
        ("block", json!([32, 32])),
        ("compression", json!("DEFLATE")),
        ("mapped_in_place", json!(false)),
        ("not_in_place_because", json!("it is compressed (DEFLATE)")),
    ];
    for (key, value) in expected {
        assert_eq!(info[key], value, "{key} of {info:#}");
    }
    assert_eq!(info["estimate"]["field_bytes"], json!(0), "blocks are read as they are wanted");
    assert!(info["memory"]["needed_bytes"].as_u64() > Some(0));
}

#[test]
fn text_has_a_line_for_each() {
    let folder = Folder::new();
    let dem = Dem::new(100, 70).scaling(0.1, -50.0).write(&folder, "dem.tif");
    let text = terrabite(["info", &dem]).succeeds().out;
    for line in [
        "size          100 × 70 samples",
        "type          Int16",
        "heights       stored value × 0.1 + -50",
        "nodata        none",
        "CRS           none",
        "geotransform  0, 1, 0, 0, 0, -1 (default: the raster has none)",
        "compression   none",
        "in place      yes, its samples are mapped where they lie",
    ] {
        assert!(text.lines().any(|l| l == line), "expected {line:?} in\n{text}");
    }
    assert!(text.contains("80 samples per triangle"), "{text}");
}

#[test]
fn every_type_in_every_layout() {
    use Kind::*;
    let folder = Folder::new();
    let kinds = [Byte, SignedByte, UInt16, Int16, UInt32, Int32, UInt64, Int64, Float32, Float64];
    for kind in kinds {
        let plain = Dem::new(50, 40).kind(kind);
        for (name, dem, mapped) in [
            ("stripped", plain.clone().stripped(7), true),
            ("tiled", plain.clone().tiled(16), true),
            ("compressed", plain.clone().compressed(), false),
            ("big-endian", plain.clone().big_endian(), false),
        ] {
            let path = dem.write(&folder, &format!("{kind:?}-{name}.tif"));
            let info = terrabite(["info", &path, "--json"]).succeeds().json();
            let called = if kind == SignedByte { "Int8".to_string() } else { format!("{kind:?}") };
            assert_eq!(info["type"], json!(called));
            assert_eq!(info["mapped_in_place"], json!(mapped), "{kind:?} {name}: {info:#}");
            assert_eq!(info["read_by_windows"], json!(!mapped));
            assert_eq!(info["estimate"]["field_bytes"], json!(0));
        }
    }
}

/// A window of a wide raster in strips would decode much more than itself.
#[test]
fn strips_of_a_large_raster_are_decoded_beforehand() {
    let folder = Folder::new();
    let path = Dem::new(1100, 1000).compressed().write(&folder, "strips.tif");
    let info = terrabite(["info", &path, "--json"]).succeeds().json();
    assert_eq!(info["read_by_windows"], json!(false));
    assert_eq!(info["estimate"]["field_bytes"], json!(5 * 4 * 256 * 256 * 2));
}

#[test]
fn nodata_of_every_sort() {
    let folder = Folder::new();
    let nodata = |name: &str, kind, value| {
        let dem = Dem::new(9, 9).kind(kind).nodata(value).write(&folder, name);
        terrabite(["info", &dem, "--json"]).succeeds().json()["nodata"].clone()
    };
    assert_eq!(nodata("nan.tif", Kind::Float32, f64::NAN), json!("nan"));
    assert_eq!(nodata("i64.tif", Kind::Int64, -9999.0), json!(-9999));
    assert_eq!(nodata("u8.tif", Kind::Byte, 255.0), json!(255.0));
}

#[test]
fn formats_that_are_no_geotiff_are_decoded() {
    let folder = Folder::new();
    for (driver, name) in [("HFA", "dem.img"), ("EHdr", "dem.bil")] {
        let dem = Dem::new(30, 20).driver(driver).on_the_map().write(&folder, name);
        let info = terrabite(["info", &dem, "--json"]).succeeds().json();
        assert_eq!((&info["driver"], &info["width"]), (&json!(driver), &json!(30)));
        assert_eq!(info["not_in_place_because"], json!(format!("its format is {driver}, only GeoTIFF is mapped")));
    }
}

#[test]
fn georeferencing_is_optional_and_may_turn() {
    let folder = Folder::new();
    // The first is the identity, which is a georeferencing like any other.
    for coefficients in [[0.0, 1.0, 0.0, 0.0, 0.0, 1.0], [5e5, 8.0, 6.0, 5.2e6, 6.0, -8.0]] {
        let dem = Dem::new(30, 20).geo_transform(coefficients).write(&folder, "dem.tif");
        let info = terrabite(["info", &dem, "--json"]).succeeds().json();
        assert_eq!((&info["georeferenced"], &info["geotransform"]), (&json!(true), &json!(coefficients)));
        assert_eq!(info["crs"], json!("none"));
    }
}

#[test]
fn bad_input() {
    let folder = Folder::new();
    let text = folder.with("notes.txt", "no raster");
    let dem = Dem::new(20, 10).bands(2).write(&folder, "dem.tif");
    let missing = folder.at("none.tif");
    terrabite(["info", &missing]).fails(1, &[&missing, "No such file"]);
    terrabite(["info", &text]).fails(1, &[&text, "cannot be opened as a raster"]);
    terrabite(["info", &dem, "--band", "3"]).fails(1, &[&dem, "band 3", "bands 1 to 2", "--band"]);
    terrabite(["info", &dem, "--band", "0"]).fails(1, &[&dem, "band 0", "bands 1 to 2"]);
    for (width, height) in [(1, 1), (1, 9), (9, 1)] {
        let thin = Dem::new(width, height).write(&folder, "thin.tif");
        terrabite(["info", &thin]).fails(1, &[&thin, &format!("{width} × {height}")]);
    }
    let flat = Dem::new(9, 9).geo_transform([0.0, 1.0, 2.0, 0.0, 2.0, 4.0]).write(&folder, "flat.tif");
    terrabite(["info", &flat]).fails(1, &[&flat, "geotransform"]);
}

#[test]
fn a_real_terrain() {
    let Some(dem) = shared_data("srtm3_S33W071.tif") else { return };
    let info = terrabite(["info".into(), dem.into_os_string(), "--json".into()]).succeeds().json();
    assert_eq!((&info["width"], &info["type"]), (&json!(1201), &json!("Int16")));
    assert_eq!(info["crs"], json!("EPSG:4326 (WGS 84)"));
}
