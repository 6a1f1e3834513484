//! Files beside a raster that change, come up or go, between two runs of a work dir or under a run: a clear refusal that
//! names the file, whatever was to be made of it.

use std::fs;

use gdal::raster::Buffer;
use gdal::{Dataset, DatasetOptions, GdalOpenFlags};

use crate::util::{Dem, Folder, Halted, Kind, Run, terrabite, terrabite_with_fault};

/// A raster with a mask of its own file beside it, `dem.tif.msk`, that takes away `holes` columns from the 20th on.
fn masked(folder: &Folder, name: &str, holes: usize) -> String {
    let path = Dem::new(120, 90).compressed().write(folder, name);
    mask(folder, name, holes);
    path
}

fn mask(folder: &Folder, name: &str, holes: usize) {
    let _ = fs::remove_file(folder.join(&format!("{name}.msk")));
    gdal::config::set_thread_local_config_option("GDAL_TIFF_INTERNAL_MASK", "NO").unwrap();
    let flags = GdalOpenFlags::GDAL_OF_UPDATE;
    let options = DatasetOptions { open_flags: flags, ..DatasetOptions::default() };
    let before = fs::read(folder.join(name)).unwrap();
    let modified = folder.join(name).metadata().unwrap().modified().unwrap();
    let dataset = Dataset::open_ex(folder.join(name), options).unwrap();
    dataset.rasterband(1).unwrap().create_mask_band(true).unwrap();
    let valid = (0..120 * 90).map(|i| if (20..20 + holes).contains(&(i % 120)) { 0 } else { 255 });
    let mut buffer = Buffer::new((120, 90), valid.collect::<Vec<u8>>());
    dataset.rasterband(1).unwrap().open_mask_band().unwrap().write((0, 0), (120, 90), &mut buffer).unwrap();
    dataset.close().unwrap();
    // Nothing but the mask is new.
    fs::write(folder.join(name), before).unwrap();
    fs::File::options().append(true).open(folder.join(name)).unwrap().set_modified(modified).unwrap();
}

fn command(folder: &Folder, options: &[&str]) -> Vec<String> {
    let [dem, tin, work] = ["dem.tif", "tin.ply", "work"].map(|name| folder.at(name));
    let fixed = ["simplify", &dem, &tin, "--max-error", "3", "--tile", "40", "--work-dir", &work, "--json"];
    fixed.iter().chain(options).map(|word| word.to_string()).collect()
}

#[track_caller]
fn killed(folder: &Folder, fault: &str, options: &[&str]) {
    let run: Run = terrabite_with_fault(&format!("kill:{fault}"), command(folder, options));
    assert_eq!(run.code, None, "{run:#?}");
}

/// What the mask is of counts in both passes.
#[test]
fn a_mask_that_changed_between_two_runs_is_named() {
    for point in ["chunk-renamed:3", "chunk-renamed:14", "vertices:1"] {
        let folder = Folder::new();
        masked(&folder, "dem.tif", 10);
        killed(&folder, point, &[]);
        mask(&folder, "dem.tif", 14);
        terrabite(command(&folder, &[])).fails(1, &["dem.tif: the raster has changed", "before dem.tif.msk changed"]);
    }
}

#[test]
fn a_mask_that_comes_up_or_goes_between_two_runs_is_named() {
    let folder = Folder::new();
    Dem::new(120, 90).compressed().write(&folder, "dem.tif");
    killed(&folder, "vertices:1", &[]);
    mask(&folder, "dem.tif", 10);
    terrabite(command(&folder, &[])).fails(1, &["the raster has changed", "before dem.tif.msk changed"]);
    // As it was: what was kept serves.
    fs::remove_file(folder.join("dem.tif.msk")).unwrap();
    let run = terrabite(command(&folder, &[])).succeeds();
    assert_eq!(run.json()["tiles_found"], 9);
}

#[test]
fn tags_beside_a_raster_count_where_they_change_it() {
    let folder = Folder::new();
    Dem::new(120, 90).compressed().write(&folder, "dem.tif");
    killed(&folder, "vertices:1", &[]);
    // Statistics change no sample: the run continues, with another look at them.
    let statistics = "<PAMDataset><PAMRasterBand band='1'><Metadata><MDI key='STATISTICS_MEAN'>7</MDI></Metadata>\
                      </PAMRasterBand></PAMDataset>";
    folder.with("dem.tif.aux.xml", statistics);
    killed(&folder, "vertices:1", &[]);
    let nodata = "<PAMDataset><PAMRasterBand band='1'><NoDataValue>75</NoDataValue></PAMRasterBand></PAMDataset>";
    folder.with("dem.tif.aux.xml", nodata);
    terrabite(command(&folder, &[])).fails(1, &["nodata"]);
}

#[test]
fn a_file_that_changes_under_a_run_is_named() {
    for (point, count) in [("tile-begun", 4), ("tile-begun", 12), ("vertices", 2)] {
        let folder = Folder::new();
        masked(&folder, "dem.tif", 10);
        let halted = Halted::at(point, count, command(&folder, &["--threads", "1"]));
        mask(&folder, "dem.tif", 30);
        let run = halted.go_on();
        run.fails(1, &["dem.tif: the raster has changed", "file dem.tif.msk", "modified"]);
        assert!(!folder.join("tin.ply").exists(), "{point}");
    }
}

#[test]
fn a_file_that_comes_up_under_a_run_is_named() {
    let folder = Folder::new();
    Dem::new(120, 90).compressed().write(&folder, "dem.tif");
    let halted = Halted::at("tile-begun", 4, command(&folder, &["--threads", "1"]));
    folder.with("dem.tif.aux.xml", "<PAMDataset/>");
    halted.go_on().fails(1, &["dem.tif: the raster has changed: expected file dem.tif.aux.xml no such file"]);
}

/// Another raster takes the name of one that is read by windows.
#[test]
fn a_raster_that_is_replaced_under_a_run_is_named() {
    for size in [(60, 50), (300, 200)] {
        let folder = Folder::new();
        Dem::new(120, 90).compressed().tiled(16).write(&folder, "dem.tif");
        let halted = Halted::at("tile-begun", 2, command(&folder, &["--access", "windows"]));
        Dem::new(size.0, size.1).kind(Kind::Float32).compressed().tiled(16).write(&folder, "dem.tif");
        halted.go_on().fails(1, &["dem.tif: the raster has changed"]);
    }
}

#[test]
fn importance_points_cutlines_and_breaklines_are_watched() {
    let polygon = r#"{"type": "Polygon", "coordinates": [[[5, -5], [110, -5], [110, -80], [5, -80], [5, -5]]]}"#;
    for (option, file, words) in [
        ("--importance", "weights.tif", "weights.tif: the raster has changed"),
        ("--points", "peaks.csv", "peaks.csv: the layer has changed"),
        ("--cutline", "cut.geojson", "cut.geojson: the layer has changed"),
        ("--breaklines", "road.geojson", "road.geojson: the layer has changed"),
    ] {
        let folder = Folder::new();
        Dem::new(120, 90).compressed().write(&folder, "dem.tif");
        Dem::new(120, 90).heights(|_, _| 1.0).write(&folder, "weights.tif");
        folder.with("peaks.csv", "x,y\n50.5,-40.5\n");
        folder.with("cut.geojson", format!(r#"{{"type": "Feature", "properties": {{}}, "geometry": {polygon}}}"#));
        folder.with("road.geojson", r#"{"type": "LineString", "coordinates": [[5, -5], [110, -80]]}"#);
        let path = folder.at(file);
        let halted = Halted::at("tile-begun", 3, command(&folder, &["--threads", "1", option, &path]));
        fs::File::options().append(true).open(&path).unwrap().set_modified(std::time::SystemTime::UNIX_EPOCH).unwrap();
        halted.go_on().fails(1, &[words, "modified"]);
    }
}
