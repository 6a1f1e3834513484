//! Zarr as others write it: what marks missing samples.

use gdal::DriverManager;

use crate::util::{Folder, terrabite};

/// Writes an array of 30 × 20 samples of 16 bits, one chunk, as zarr-python does.
fn array(
    folder: &Folder,
    name: &str,
    fill_value: &str,
    attributes: &str,
    height: impl Fn(usize, usize) -> i16,
) -> String {
    std::fs::create_dir(folder.join(name)).unwrap();
    let about = format!(
        r#"{{"shape": [20, 30], "chunks": [20, 30], "dtype": "<i2", "fill_value": {fill_value}, "order": "C",
        "filters": null, "dimension_separator": ".", "compressor": null, "zarr_format": 2}}"#
    );
    folder.with(&format!("{name}/.zarray"), about);
    folder.with(&format!("{name}/.zattrs"), attributes);
    let chunk: Vec<u8> = (0..600).flat_map(|i| height(i % 30, i / 30).to_le_bytes()).collect();
    folder.with(&format!("{name}/0.0"), chunk);
    folder.at(name)
}

fn codes(dem: &str) -> Vec<(String, String)> {
    let info = terrabite(["info", dem, "--json"]).succeeds().json();
    let text = |value: &serde_json::Value| value.as_str().unwrap().to_string();
    info["warnings"].as_array().unwrap().iter().map(|w| (text(&w["code"]), text(&w["message"]))).collect()
}

#[test]
fn a_fill_value_that_was_made_up_is_told() {
    if DriverManager::get_driver_by_name("Zarr").is_err() {
        return;
    }
    let folder = Folder::new();
    let coast = |c: usize, r: usize| (c as i16 - 10).max(0) + r as i16;
    let none = array(&folder, "none.zarr", "null", "{}", coast);
    assert_eq!(codes(&none), []);
    let zero = array(&folder, "zero.zarr", "0", "{}", coast);
    let found = codes(&zero);
    assert_eq!(found.len(), 1, "{found:?}");
    let words = ["the nodata tag is 0", "Zarr's fill_value", "11 samples", "--nodata none"];
    assert!(found[0].0 == "zero_nodata" && words.iter().all(|w| found[0].1.contains(w)), "{found:?}");
    let attributes = r#"{"_FillValue": -32768, "scale_factor": 0.5, "add_offset": 5.0}"#;
    let packed = array(&folder, "packed.zarr", "0", attributes, |c, r| if c < 3 { -32768 } else { (1 + c + r) as i16 });
    let found = codes(&packed);
    let words = ["it names -32768 as the value of missing samples (_FillValue), and GDAL takes 0", "--nodata"];
    assert!(found.iter().any(|(c, m)| c == "fill_value" && words.iter().all(|w| m.contains(w))), "{found:?}");
    let agreed = array(&folder, "agreed.zarr", "-32768", attributes, coast);
    assert_eq!(codes(&agreed), []);
}

#[test]
fn zarr_3_is_refused_by_name() {
    let folder = Folder::new();
    std::fs::create_dir(folder.join("dem.zarr")).unwrap();
    folder.with("dem.zarr/zarr.json", r#"{"zarr_format": 3, "node_type": "no kind of node"}"#);
    terrabite(["info", &folder.at("dem.zarr")]).fails(1, &["dem.zarr", "it is Zarr 3, which GDAL", "zarr_format=2"]);
}
