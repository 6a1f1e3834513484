//! Made terrain: the same bits everywhere, and what is refused.

use std::path::Path;

use super::*;
use crate::base::Mark;
use crate::base::Window;
use crate::base::control::{CancelToken, Control};
use crate::base::staged::OutputError;
use crate::raster::Raster;
use crate::verify::HeightReader;

fn terrain(options: TerrainOptions) -> Terrain {
    Terrain::new(&options).expect("valid options")
}

fn filled(terrain: &Terrain, window: Window) -> Vec<f64> {
    let mut out = vec![0.0; window.len()];
    terrain.fill(window, &mut out);
    out
}

fn square(side: usize) -> Window {
    Window { column: 0, row: 0, width: side, height: side }
}

fn everything() -> TerrainOptions {
    TerrainOptions { seed: 7, lakes: 0.2, nodata_share: 0.1, cliffs: true, ..TerrainOptions::default() }
}

fn bits(heights: &[f64]) -> Vec<u64> {
    heights.iter().map(|h| h.to_bits()).collect()
}

#[test]
fn any_window_of_the_terrain_has_the_same_bits() {
    let terrain = terrain(everything());
    let whole = filled(&terrain, square(300));
    for window in [
        Window { column: 0, row: 0, width: 1, height: 300 },
        Window { column: 37, row: 211, width: 131, height: 5 },
        Window { column: 255, row: 255, width: 45, height: 45 },
        Window { column: 3, row: 299, width: 2, height: 1 },
    ] {
        let part = filled(&terrain, window);
        for (k, h) in part.iter().enumerate() {
            let (column, row) = (window.column + k % window.width, window.row + k / window.width);
            assert_eq!(h.to_bits(), whole[row * 300 + column].to_bits(), "column {column} row {row} of {window:?}");
        }
    }
    let mut line = vec![0.0; 300];
    terrain.fill_row(123, &mut line);
    assert_eq!(bits(&line), bits(&whole[123 * 300..124 * 300]));
    assert_eq!(terrain.height(299, 0).to_bits(), whole[299].to_bits());
}

/// Golden numbers: the same bits on every machine, and a change of the ground is a change of every measurement.
#[test]
fn heights_are_the_same_everywhere() {
    let terrain = terrain(everything());
    let found = [(0, 0), (1000, 1), (77_777, 99_999), (1_000_000_000, 2_000_000_000)]
        .map(|(column, row)| terrain.height(column, row).to_bits());
    assert_eq!(found, GOLDEN.map(f64::to_bits), "{:?}", found.map(f64::from_bits));
}

const GOLDEN: [f64; 4] = [355.225293516933, 650.7146873408685, 515.5180132587973, 645.9130845516662];

#[test]
fn ground_far_away_has_the_relief_it_has_here() {
    let terrain = terrain(TerrainOptions::default());
    let spread = |column: usize, row: usize| {
        let heights: Vec<f64> =
            (0..10_000).map(|k| terrain.height(column + k % 100 * 80, row + k / 100 * 80)).collect();
        let mean = heights.iter().sum::<f64>() / 10_000.0;
        (heights.iter().map(|h| (h - mean) * (h - mean)).sum::<f64>() / 10_000.0).sqrt()
    };
    let (here, there) = (spread(0, 0), spread(90_000, 4_000_000));
    assert!((here / there - 1.0).abs() < 0.25, "standard deviations {here} and {there}");
    assert!((100.0..400.0).contains(&here), "standard deviation {here} for a relief of 1500");
}

#[test]
fn lakes_are_exactly_flat_and_take_their_share() {
    let side = 2048;
    let heights = filled(&terrain(TerrainOptions { seed: 5, lakes: 0.3, ..TerrainOptions::default() }), square(side));
    let flat = |k: usize| heights[k] == heights[k + 1] && heights[k] == heights[k + side];
    let inner = (0..side - 1).flat_map(|row| (0..side - 1).map(move |column| row * side + column));
    let share = inner.filter(|&k| flat(k)).count() as f64 / (side * side) as f64;
    assert!((0.22..0.38).contains(&share), "{share} of the area is flat");
}

#[test]
fn without_lakes_nothing_is_flat() {
    let heights = filled(&terrain(TerrainOptions::default()), square(512));
    assert!(heights.windows(2).all(|w| w[0] != w[1]));
}

#[test]
fn gaps_take_their_share() {
    for share in [0.1, 0.5] {
        let options = TerrainOptions { nodata_share: share, ..TerrainOptions::default() };
        let heights = filled(&terrain(options), square(2048));
        let found = heights.iter().filter(|h| h.is_nan()).count() as f64 / heights.len() as f64;
        assert!((found - share).abs() < 0.05, "{found} of the area has no heights, expected {share}");
    }
}

#[test]
fn cliffs_are_steps_between_two_samples() {
    let steepest = |cliffs| {
        let heights = filled(&terrain(TerrainOptions { cliffs, ..TerrainOptions::default() }), square(1024));
        heights
            .windows(2)
            .enumerate()
            .filter(|(k, _)| k % 1024 != 1023)
            .map(|(_, w)| (w[1] - w[0]).abs())
            .fold(0.0, f64::max)
    };
    let (with, without) = (steepest(true), steepest(false));
    assert!(with > 60.0 && without < 30.0, "steepest step {with} m with cliffs, {without} m without");
}

fn run(path: &Path, options: &SynthOptions, threads: usize) -> Result<SynthReport, SynthError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
    pool.install(|| synth(path, options, &Control::default()))
}

#[test]
fn one_thread_and_two_write_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, layout) in [("tiles", BlockLayout::Tiles(64)), ("strips", BlockLayout::Strips(5))] {
        let options =
            SynthOptions { width: 700, height: 333, terrain: everything(), layout, ..SynthOptions::default() };
        let (one, two) = (folder.path().join(format!("{name}1.tif")), folder.path().join(format!("{name}2.tif")));
        assert_eq!(run(&one, &options, 1).expect("one"), run(&two, &options, 2).expect("two"));
        let read = |path| std::fs::read(path).expect("written");
        assert!(read(&one) == read(&two), "{name} differ");
    }
}

#[test]
fn files_hold_the_terrain_in_every_type_and_layout() {
    let folder = tempfile::tempdir().expect("a folder");
    let kinds = [
        (StoredAs::Int16, BlockLayout::Tiles(16), Compression::Lzw, false),
        (StoredAs::Float32, BlockLayout::Strips(1), Compression::None, true),
        (StoredAs::Float64, BlockLayout::Tiles(256), Compression::Deflate, true),
        (StoredAs::Float32, BlockLayout::Strips(64), Compression::Zstd, false),
    ];
    let heights = filled(&terrain(everything()), Window { column: 0, row: 0, width: 190, height: 170 });
    for (stored_as, layout, compression, big_endian) in kinds {
        let options = SynthOptions {
            width: 190,
            height: 170,
            terrain: everything(),
            stored_as,
            layout,
            compression,
            big_endian,
            overwrite: true,
            ..SynthOptions::default()
        };
        let path = folder.path().join("raster.tif");
        let report = run(&path, &options, 2).expect("made");
        let raster = Raster::open(&path, 1).expect("opened");
        assert_eq!(raster.geo_transform().coefficients(), [300_000.0, 10.0, 0.0, 5_400_000.0, 0.0, -10.0]);
        assert!(raster.crs_name().starts_with("EPSG:32633"));
        let nodata = if stored_as == StoredAs::Int16 { -32768.0 } else { -9999.0 };
        assert_eq!(raster.tag(), Some(Mark::Real(nodata)));
        let mut stored = vec![0.0; heights.len()];
        let window = Window { column: 0, row: 0, width: 190, height: 170 };
        HeightReader::new(&raster.to_band().expect("told")).read_stored(window, &mut stored).expect("read");
        let expected = heights.iter().map(|&h| match stored_as {
            _ if h.is_nan() => nodata,
            StoredAs::Int16 => (h + 0.5).floor(),
            StoredAs::Float32 => f64::from(h as f32),
            StoredAs::Float64 => h,
        });
        assert!(stored.iter().copied().eq(expected), "{options:?}");
        assert_eq!(report.nodata_samples as usize, heights.iter().filter(|h| h.is_nan()).count());
    }
}

#[test]
fn whole_metres_stay_in_range_at_any_relief() {
    let folder = tempfile::tempdir().expect("a folder");
    let terrain = TerrainOptions { relief_m: 25_000.0, roughness: 1.0, cliffs: true, ..TerrainOptions::default() };
    let options = SynthOptions { terrain, stored_as: StoredAs::Int16, ..SynthOptions::default() };
    let report = run(&folder.path().join("high.tif"), &options, 2).expect("made");
    assert!(report.lowest_m > -9000.0 && report.highest_m < 32_767.0, "{report:?}");
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect()
}

#[test]
fn an_existing_file_is_kept_without_overwrite() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("mine.tif");
    std::fs::write(&path, "mine").expect("written");
    let options = SynthOptions { width: 20, height: 20, ..SynthOptions::default() };
    assert!(matches!(run(&path, &options, 1), Err(SynthError::Output(OutputError::Exists { .. }))));
    assert_eq!(std::fs::read(&path).expect("kept"), b"mine");
    run(&path, &SynthOptions { overwrite: true, ..options }, 1).expect("replaced");
    assert_eq!(names(folder.path()), ["mine.tif"]);
}

#[test]
fn cancelling_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let cancel = CancelToken::default();
    cancel.cancel();
    let control = Control { cancel, ..Control::default() };
    let found = synth(&folder.path().join("never.tif"), &SynthOptions::default(), &control);
    assert!(matches!(found, Err(SynthError::Cancelled(_))));
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_missing_folder_is_named() {
    let found = run(Path::new("/no/such/folder/out.tif"), &SynthOptions::default(), 1);
    assert!(
        matches!(&found, Err(SynthError::Output(OutputError::NoFolder { path, .. })) if path == Path::new("/no/such/folder/out.tif"))
    );
}

#[test]
fn numbers_out_of_range_are_named() {
    let ground = |f: fn(&mut TerrainOptions)| {
        let mut options = SynthOptions::default();
        f(&mut options.terrain);
        options.check().expect_err("out of range").option
    };
    assert_eq!(ground(|t| t.relief_m = 0.0), "relief");
    assert_eq!(ground(|t| t.relief_m = f64::NAN), "relief");
    assert_eq!(ground(|t| t.roughness = 1.5), "roughness");
    assert_eq!(ground(|t| t.lakes = 0.8), "lakes");
    assert_eq!(ground(|t| t.nodata_share = -0.1), "nodata-share");
    let file = |options: SynthOptions| options.check().expect_err("out of range").option;
    assert_eq!(file(SynthOptions { width: 1, ..SynthOptions::default() }), "size");
    assert_eq!(file(SynthOptions { cell_m: -1.0, ..SynthOptions::default() }), "cell");
    assert_eq!(file(SynthOptions { layout: BlockLayout::Tiles(100), ..SynthOptions::default() }), "block");
    assert_eq!(file(SynthOptions { layout: BlockLayout::Strips(0), ..SynthOptions::default() }), "strip");
}
