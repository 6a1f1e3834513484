//! Whole sets of tiles, and the heights of the finest grid.

use std::path::{Path, PathBuf};

use gdal::spatial_ref::{AxisMappingStrategy, CoordTransform, SpatialRef};

use super::{
    Patch, PyramidError, SampleBlock, TilesReport, TilesRequest, lay_out_tiles, merge_tiles, prepare, tiles,
    work_on_tiles,
};
use crate::base::control::Control;
use crate::job::shards::Shard;
use crate::raster::{GeodesyError, Raster, View};
use crate::testing::{folder, raster};
use crate::tiles_verify::{TilesVerifyRequest, Verdict, tiles_verify};

fn hills(column: usize, row: usize) -> f32 {
    let (x, y) = (column as f32, row as f32);
    600.0 + 400.0 * (x / 5.0).sin() * (y / 7.0).cos() + 30.0 * ((x * 1.3 + y * 2.1) % 5.0)
}

fn request(input: &Path, output: &Path, max_error: f64) -> TilesRequest {
    TilesRequest { temp_dir: Some(crate::fuzzing::temp_dir()), ..TilesRequest::new(input, output, max_error) }
}

#[test]
fn heights_of_the_grid_are_bilinear_at_the_exact_place() {
    agrees(32633, [500_000.0, 300.0, 60.0, 5_200_000.0, 40.0, -280.0], 17);
}

/// There the grid spans longitudes, and has most of its blocks beside the raster.
#[test]
fn near_a_pole_no_sample_is_passed_by() {
    let transform = [30_000.0, 900.0, 0.0, 40_000.0, 0.0, -900.0];
    assert!(agrees(3413, transform, 15) < 0.5);
    // Around the pole itself.
    assert!(agrees(3413, [-12_000.0, 900.0, 0.0, 12_000.0, 0.0, -900.0], 15) > 0.5);
}

#[test]
fn a_raster_that_has_nothing_but_a_pole_has_a_grid() {
    let folder = folder();
    let transform = [-4_000.0, 200.0, 0.0, 3_000.0, 0.0, -200.0];
    let path = raster(folder.path(), "dem.tif", (40, 30), transform, "EPSG:3413", &hills);
    let prepared = prepare::open(&request(&path, Path::new("out"), 10.0), &Control::default()).expect("a raster");
    let grid = prepared.source.grid(0).expect("a grid");
    // 200 m are 0.00179°, and the projection makes 1.03 of a metre at the pole.
    assert_eq!(grid.exponent, 17);
}

/// The naive way: each sample by itself, from the samples themselves. Tells the share of the blocks that have any.
fn agrees(epsg: u32, transform: [f64; 6], exponent: u32) -> f64 {
    let folder = folder();
    let size = (40, 30);
    let path = raster(folder.path(), "dem.tif", size, transform, &format!("EPSG:{epsg}"), &hills);
    let request = request(&path, Path::new("out"), 10.0);
    let prepared = prepare::open(&request, &Control::default()).expect("a raster");
    let grid = prepared.source.grid(0).expect("a grid");
    assert_eq!(grid.exponent, exponent);
    let area = prepared.source.area(grid).expect("an area");
    let samples = prepare::resample(&prepared, grid, &request, &Control::default()).expect("samples");
    let mut block = SampleBlock::default();
    let (column, row, width, height) = (area.column, area.row, area.width, area.height);
    samples.read(Patch { column, row, width, height, step: 1 }, &mut block).expect("heights");
    let crs = |epsg| {
        let mut crs = SpatialRef::from_epsg(epsg).expect("known");
        crs.set_axis_mapping_strategy(AxisMappingStrategy::TraditionalGisOrder);
        crs
    };
    let way = CoordTransform::new(&crs(4326), &crs(epsg)).expect("a way");
    let [x0, xc, xr, y0, yc, yr] = transform;
    let mut inside = 0;
    for (i, (&found, &is_inside)) in block.heights.iter().zip(&block.inside).enumerate() {
        let (column, row) = (area.column + (i % area.width) as i64, area.row + (i / area.width) as i64);
        let (mut x, mut y) = ([grid.longitude(column)], [grid.latitude(row)]);
        way.transform_coords(&mut x, &mut y, &mut []).expect("a place");
        let (dx, dy, det) = (x[0] - x0, y[0] - y0, xc * yr - xr * yc);
        let (c, r) = ((dx * yr - dy * xr) / det - 0.5, (dy * xc - dx * yc) / det - 0.5);
        // The poles belong to no column.
        let is_pole = [0, grid.rows()].contains(&row);
        if !(0.0..=39.0).contains(&c) || !(0.0..=29.0).contains(&r) || is_pole {
            assert!(!is_inside, "{c}, {r}");
            continue;
        }
        assert!(is_inside, "{c}, {r}");
        inside += 1;
        let (left, top) = (c.floor().min(38.0), r.floor().min(28.0));
        let at = |dc: usize, dr: usize| f64::from(hills(left as usize + dc, top as usize + dr));
        let (p, q) = (c - left, r - top);
        let expected = at(0, 0)
            + p * (at(1, 0) - at(0, 0))
            + q * (at(0, 1) - at(0, 0))
            + p * q * (at(1, 1) - at(1, 0) - at(0, 1) + at(0, 0));
        assert!((found - expected).abs() < 1e-6, "{found} for {expected} at {c}, {r}");
    }
    assert!(inside > 1000, "{inside}");
    samples.store.share_filled()
}

/// All files of a folder, with their names.
pub(super) fn content(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for path in next.read_dir().expect("a folder").map(|entry| entry.expect("an entry").path()) {
            match path.is_dir() {
                true => folders.push(path),
                false => all.push((
                    path.strip_prefix(folder).expect("inside").to_path_buf(),
                    std::fs::read(&path).expect("a file"),
                )),
            }
        }
    }
    all.sort();
    all
}

/// What `tiles_verify` says of a set.
pub(super) fn judged(input: &Path, set: &Path) -> Verdict {
    let request = TilesVerifyRequest {
        input: input.to_path_buf(),
        view: View::default(),
        tiles: set.to_path_buf(),
        memory: None,
        threads: None,
        temp_dir: Some(crate::fuzzing::temp_dir()),
    };
    tiles_verify(&request, &Control::default()).expect("a verdict")
}

fn made(input: &Path, output: &Path, threads: usize) -> Result<TilesReport, PyramidError> {
    let request = TilesRequest { threads: std::num::NonZeroUsize::new(threads), ..request(input, output, 100.0) };
    tiles(&request, &Control::default())
}

#[test]
fn threads_do_not_change_a_byte() {
    let folder = folder();
    let transform = [10.0, 0.02, 0.0, 47.0, 0.0, -0.02];
    let path = raster(folder.path(), "dem.tif", (50, 40), transform, "EPSG:4326", &hills);
    let (one, three) = (folder.path().join("one"), folder.path().join("three"));
    let report = made(&path, &one, 1).expect("tiles");
    made(&path, &three, 3).expect("tiles");
    assert_eq!(content(&one), content(&three));
    assert!(report.levels.iter().all(|l| l.largest_error <= l.max_error && l.tiles > 0), "{report:?}");
    assert_eq!(report.levels[0].tiles, 2);
    // No share of what the finest level is allowed was set aside for the sag of triangles, a seventh of it for one as large as a part.
    let finest = report.levels.last().expect("levels");
    assert!(finest.largest_error > 0.9 * finest.max_error, "{finest:?}");
    // Nothing else is left beside them.
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 3);
    refused(made(&path, &one, 1), "an earlier set of tiles");
}

/// Mountains 2500 m above the height outside and a metre allowed, their rim turned against the grid, with voids of which some have a single row
/// of samples between them. The finest level is kept beside its cliffs; at a coarse one, whose places are too far apart for vertices to be rounded away from
/// the raster, no mesh is found for twice what the next finer one keeps.
#[test]
fn a_level_without_a_mesh_has_the_error_that_clients_expect() {
    let folder = folder();
    let transform = [8.523, 0.000_83, 0.000_11, 45.99, 0.000_07, -0.000_83];
    let mountains = |column: usize, row: usize| {
        let is_void = column % 17 == 5 && row % 13 < 6 || column % 17 == 7 && row % 13 == 3;
        if is_void { f32::NAN } else { 2500.0 + 0.2 * hills(column, row) }
    };
    let path = raster(folder.path(), "dem.tif", (70, 60), transform, "EPSG:4326", &mountains);
    let asked = request(&path, &folder.path().join("whole"), 1.0);
    let levels = tiles(&asked, &Control::default()).expect("tiles").levels;
    let finest = levels.len() - 1;
    let is_loosened = |i: &usize| levels[*i].max_error > 2.01 * levels[*i + 1].max_error;
    let loosened: Vec<usize> = (1..finest).filter(is_loosened).collect();
    let is_expected = |&i: &usize| (levels[i].max_error * f64::from(1 << i) / 77_067.34 - 1.0).abs() < 1e-6;
    assert!(!loosened.is_empty() && loosened.iter().all(is_expected) && levels[finest].max_error == 1.0, "{levels:?}");
    let verdict = judged(&path, &asked.output);
    assert!(verdict.passed, "{verdict}");
    // Shards find out one by one which level that is.
    let (output, work) = (folder.path().join("shards"), folder.path().join("work"));
    let shards = TilesRequest { output, work_dir: Some(work), keep_work_dir: true, ..asked.clone() };
    lay_out_tiles(&shards, Vec::new(), &Control::default()).expect("laid out");
    for number in [2, 1, 2, 1] {
        work_on_tiles(&shards, Shard::new(number, 2).expect("a shard"), &Control::default()).expect("a share");
    }
    merge_tiles(&shards, &Control::default()).expect("merged");
    assert_eq!(content(&asked.output), content(&shards.output));
}

fn refused<T>(found: Result<T, PyramidError>, words: &str) {
    match found.err() {
        Some(PyramidError::Occupied { found, .. }) => assert!(found.contains(words), "{found}"),
        other => panic!("expected {words}, found {other:?}"),
    }
}

#[test]
fn folders_with_other_files_are_left_alone() {
    let folder = folder();
    let transform = [10.0, 0.02, 0.0, 47.0, 0.0, -0.02];
    let path = raster(folder.path(), "dem.tif", (10, 10), transform, "EPSG:4326", &hills);
    let out = folder.path().join("out");
    std::fs::create_dir(&out).expect("a folder");
    std::fs::write(out.join("layer.json"), "{}").expect("a file");
    for overwrite in [false, true] {
        let found = tiles(&TilesRequest { overwrite, ..request(&path, &out, 100.0) }, &Control::default());
        refused(found, "other files");
    }
    assert_eq!(content(&out), [(PathBuf::from("layer.json"), b"{}".to_vec())]);
    std::fs::remove_file(out.join("layer.json")).expect("removed");
    made(&path, &out, 1).expect("an empty folder is taken");
    let again = TilesRequest { overwrite: true, gzip: true, ..request(&path, &out, 100.0) };
    tiles(&again, &Control::default()).expect("an earlier set is replaced");
    assert!(
        content(&out).iter().any(|(name, bytes)| name.ends_with("0/0/0.terrain") && bytes.starts_with(&[0x1f, 0x8b]))
    );
    assert_eq!(folder.path().read_dir().expect("a folder").count(), 2);
}

#[test]
fn rasters_that_lie_nowhere_are_refused() {
    let folder = folder();
    let transform = [10.0, 0.02, 0.0, 47.0, 0.0, -0.02];
    let out = folder.path().join("out");
    let local = "LOCAL_CS[\"site\",UNIT[\"metre\",1]]";
    for crs in ["", local] {
        let path = raster(folder.path(), "dem.tif", (10, 10), transform, crs, &hills);
        let found = made(&path, &out, 1);
        assert!(matches!(found, Err(PyramidError::Geodesy { source: GeodesyError::Local { .. }, .. })), "{found:?}");
    }
    let nothing = raster(folder.path(), "nothing.tif", (10, 10), transform, "EPSG:4326", &|_, _| f32::NAN);
    assert!(matches!(made(&nothing, &out, 1), Err(PyramidError::Nothing { .. })));
    assert!(!out.exists());
}

/// Above and below it is the height outside, and what is below is on a line of parts, which nothing in a part changes.
#[test]
fn a_single_row_beside_a_line_has_a_mesh() {
    let folder = folder();
    let (cell, out) = (180.0 / f64::from(1 << 16), folder.path().join("out"));
    // The first row of samples is the 57th of a tile that is cut into parts of 8 rows.
    let at = |degrees: f64, more: f64| ((degrees / cell / 128.0).floor() * 128.0 + more - 0.5) * cell;
    let transform = [at(191.0, 10.0) - 180.0, cell, 0.0, 90.0 - at(45.0, 57.0), 0.0, -cell];
    let strip = |column: usize, row: usize| {
        if (1..5).contains(&row) { f32::NAN } else { 2400.0 + 0.1 * hills(column, row) }
    };
    let path = raster(folder.path(), "dem.tif", (16, 8), transform, "EPSG:4326", &strip);
    tiles(&request(&path, &out, 2.0), &Control::default()).expect("tiles");
    let verdict = judged(&path, &out);
    assert!(verdict.passed, "{verdict}");
}

/// No place on the rim of the raster is on the globe.
#[test]
fn a_whole_disc_is_taken() {
    let folder = folder();
    let (disc, out) = ("+proj=ortho +lat_0=40 +lon_0=10 +datum=WGS84", folder.path().join("out"));
    let transform = [-6.6e6, 220_000.0, 0.0, 6.6e6, 0.0, -220_000.0];
    let path = raster(folder.path(), "disc.tif", (60, 60), transform, disc, &hills);
    tiles(&request(&path, &out, 60_000.0), &Control::default()).expect("tiles");
    let verdict = judged(&path, &out);
    assert!(verdict.passed && verdict.levels[0].samples > 1000, "{verdict:?}");
}

#[test]
fn heights_are_brought_to_the_ellipsoid_or_refused() {
    let folder = folder();
    let at =
        |name: &str, crs: &str, transform: [f64; 6]| raster(folder.path(), name, (3, 3), transform, crs, &|_, _| 0.0);
    let (alps, plains) = ([7.99, 0.01, 0.0, 46.01, 0.0, -0.01], [-100.01, 0.01, 0.0, 40.01, 0.0, -0.01]);
    let height = |path: &Path, vertical: Option<&str>, (lon, lat): (f64, f64)| {
        let geodesy = Raster::open(path, 1).expect("a raster").geodesy(vertical)?;
        let (mut x, mut y, mut z) = ([lon], [lat], [0.0]);
        geodesy.ways()?.to_ellipsoidal(&mut x, &mut y, &mut z);
        Ok::<f64, GeodesyError>(z[0])
    };
    let compound = at("compound.tif", "EPSG:4326+5773", alps);
    let flat = at("flat.tif", "EPSG:4326", alps);
    for (path, vertical) in [(&compound, None), (&flat, Some("EPSG:5773"))] {
        let found = height(path, vertical, (8.0, 46.0)).expect("EGM96 comes with PROJ's data");
        assert!((found - 51.853).abs() < 0.001, "{found}");
    }
    assert_eq!(height(&flat, None, (8.0, 46.0)).expect("ellipsoidal"), 0.0);
    let refused =
        [("EPSG:4326+3855", alps), ("EPSG:7415", [1.2e5, 10.0, 0.0, 4.8e5, 0.0, -10.0]), ("EPSG:4269+5703", plains)];
    for (crs, transform) in refused {
        let found = height(&at("refused.tif", crs, transform), None, (8.0, 46.0));
        assert!(
            matches!(&found, Err(GeodesyError::NoGrid { vertical, .. }) if !vertical.is_empty()),
            "{crs}: {found:?}"
        );
    }
    let wrong = height(&flat, Some("EPSG:4326"), (8.0, 46.0));
    assert!(matches!(wrong, Err(GeodesyError::NotVertical { .. })), "{wrong:?}");
}
