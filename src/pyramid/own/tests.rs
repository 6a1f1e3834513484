//! Sets that promise to be within their errors at the raster's own samples, judged by whoever shares no code with their making.

use std::path::Path;

use proptest::prelude::*;

use super::store::{OwnSample, OwnStore, Rectangle};
use crate::base::control::Control;
use crate::job::shards::Shard;
use crate::pyramid::tests::{content, judged};
use crate::pyramid::{PyramidError, TilesRequest, lay_out_tiles, merge_tiles, prepare, store, tiles, work_on_tiles};
use crate::testing::{cases, folder, raster};
use crate::tiles_verify::Verdict;

/// The same for the same numbers, and spread out.
fn mixed(seed: u64, column: usize, row: usize) -> u64 {
    let mut x =
        seed ^ (column as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (row as u64).wrapping_mul(0xd1b5_4a32_d192_ed03);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (x ^ (x >> 27)) >> 16
}

/// A gentle slope with spikes at random samples, about one of every `one_of`.
fn spikes(seed: u64, one_of: u64) -> impl Fn(usize, usize) -> f32 {
    move |column, row| {
        let number = mixed(seed, column, row);
        if number.is_multiple_of(one_of) { 200.0 + (number % 97) as f32 } else { 100.0 + (column + row) as f32 * 0.5 }
    }
}

fn request(input: &Path, output: &Path, max_error: f64) -> TilesRequest {
    TilesRequest {
        temp_dir: Some(crate::fuzzing::temp_dir()),
        outside: 100.0,
        own_samples: true,
        ..TilesRequest::new(input, output, max_error)
    }
}

/// Makes a set of a raster in a folder, and has it judged.
fn made(folder: &Path, input: &Path, max_error: f64, own_samples: bool) -> Verdict {
    let set = folder.join(if own_samples { "own" } else { "grid" });
    let request = TilesRequest { own_samples, ..request(input, &set, max_error) };
    tiles(&request, &Control::default()).unwrap_or_else(|e| panic!("{e}"));
    judged(input, &set)
}

fn passes(verdict: &Verdict) {
    assert!(verdict.passed, "{verdict}");
    assert!(verdict.levels.iter().all(|level| level.own_samples.above == 0), "{verdict}");
}

proptest! {
    #![proptest_config(cases(2, 60))]
    /// The raster is turned against the grid and sheared, so that its samples lie at all places between those of the grid.
    #[test]
    fn spikes_between_samples_of_the_grid_are_kept(
        seed in 0u64..1 << 40,
        one_of in 3u64..60,
        turn in -3.0f64..3.0,
        shear in -0.2f64..0.2,
        max_error in 3.0f64..40.0,
    ) {
        let folder = folder();
        let (cos, sin) = (60.0 * turn.cos(), 60.0 * turn.sin());
        let transform = [500_000.0, cos, sin + shear * cos, 5_200_000.0, sin, -cos + shear * sin];
        let input = raster(folder.path(), "dem.tif", (50, 40), transform, "EPSG:32633", &spikes(seed, one_of));
        passes(&made(folder.path(), &input, max_error, true));
    }
}

#[test]
fn without_the_option_spikes_are_lost_and_a_set_that_denies_it_fails() {
    let folder = folder();
    let transform = [500_000.0, 50.0, 31.0, 5_200_000.0, 31.0, -50.0];
    let input = raster(folder.path(), "dem.tif", (50, 40), transform, "EPSG:32633", &spikes(7, 30));
    let verdict = made(folder.path(), &input, 10.0, false);
    let finest = verdict.levels.last().expect("levels");
    assert!(verdict.passed && finest.own_samples.above > 10, "{verdict}");
    let promise = folder.path().join("grid/terrabite.json");
    let text = std::fs::read_to_string(&promise).expect("a promise");
    let changed = text.replace("\"own_samples\": false", "\"own_samples\": true");
    assert_ne!(text, changed);
    std::fs::write(&promise, changed).expect("written");
    let verdict = judged(&input, &folder.path().join("grid"));
    let said = verdict.failures.join("\n");
    let expected =
        format!("{} of {} samples of the raster itself", finest.own_samples.above, finest.own_samples.samples);
    assert!(!verdict.passed && said.contains("samples of the raster itself"), "{said}");
    assert!(verdict.failures.len() == 1 && (said.contains(&expected) || said.contains("more of this kind")), "{said}");
}

/// Some spikes on rough ground: each costs a few triangles around it, and the others stay.
#[test]
fn a_sample_costs_triangles_around_it_alone() {
    let folder = folder();
    let transform = [500_000.0, 50.0, 31.0, 5_200_000.0, 31.0, -50.0];
    let rough = |column: usize, row: usize| {
        let (x, y) = (column as f32, row as f32);
        let ground = 400.0 + 150.0 * (x / 4.0).sin() * (y / 5.0).cos();
        if column % 30 == 17 && row % 30 == 11 { ground + 60.0 } else { ground }
    };
    let input = raster(folder.path(), "dem.tif", (120, 120), transform, "EPSG:32633", &rough);
    let [grid, own] = [false, true].map(|own_samples| made(folder.path(), &input, 12.0, own_samples));
    passes(&own);
    let [(triangles, beyond), (with_own, _)] = [&grid, &own].map(|verdict| {
        let finest = verdict.levels.last().expect("levels");
        (finest.triangles, finest.own_samples.above)
    });
    // Triangulated anew, its parts had 32 for each.
    assert!(beyond > 10 && with_own <= triangles + 8 * beyond, "{with_own} after {triangles} for {beyond} samples");
}

/// A comb of peaks and pits: no mesh on the lattice of a coarse level is near all of them, and the ends of its sides are beyond the last
/// sample by what places are rounded.
#[test]
fn what_no_mesh_reaches_is_refused() {
    let folder = folder();
    let cell = 0.000342353764323;
    let transform = [168.73990056395246, cell, 0.0, -22.474323467675745, 0.0, -cell];
    let comb = |column: usize, row: usize| match (column % 5, row % 7) {
        (0, 0) => 7700.0,
        (2, 3) => -7700.0,
        _ => 0.0,
    };
    let input = raster(folder.path(), "dem.tif", (60, 150), transform, "EPSG:4326", &comb);
    let asked = TilesRequest { outside: 0.0, ..request(&input, &folder.path().join("set"), 3966.0) };
    let refused = tiles(&asked, &Control::default()).expect_err("no mesh");
    let said = refused.to_string();
    let (lon, lat) = match refused {
        PyramidError::OwnSamples { lon, lat, .. } => (lon, lat),
        PyramidError::Unreachable { worst: Some(worst), .. } => (worst.lon, worst.lat),
        other => panic!("{other}"),
    };
    assert!((168.69..168.81).contains(&lon) && (-22.58..-22.42).contains(&lat), "{said}");
    assert!(said.contains(&format!("m off at {lon:.6}°, {lat:.6}°")), "{said}");
    assert!(!folder.path().join("set").exists());
}

/// Spikes on a line between tiles, so near to it that no place of the lattice is between, and farther off; at a meridian, at the
/// antimeridian and at a parallel.
#[test]
fn spikes_on_and_near_the_borders_of_tiles_are_kept() {
    let cell = 180.0 / f64::from(1 << 16);
    let places =
        [(0.0, 11.25, 45.0), (0.001, 180.0, -33.75), (0.003, 11.25, -22.5), (0.02, 180.0, -33.75), (0.11, 11.25, 45.0)];
    for (number, (offset, lon, lat)) in places.into_iter().enumerate() {
        let folder = folder();
        // The tenth column and the seventh row are at the line, but for the offset.
        let step = 1.03 * cell;
        let first = (lon - (9.5 - offset) * step, lat + (6.5 + offset) * step);
        let at = |column: usize, row: usize| {
            let on_line = column == 9 && row % 3 == number % 3 || row == 6 && column % 4 == number % 4;
            if on_line { 220.0 + row as f32 } else { 100.0 + column as f32 }
        };
        let input =
            raster(folder.path(), "dem.tif", (20, 16), [first.0, step, 0.0, first.1, 0.0, -step], "EPSG:4326", &at);
        let verdict = made(folder.path(), &input, 15.0, true);
        passes(&verdict);
        assert!(verdict.levels.last().expect("levels").tiles == 4, "{verdict}");
    }
}

#[test]
fn threads_shards_and_work_dirs_give_the_same_bytes() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let transform = [11.2, 0.0011, 0.0003, 45.02, 0.0002, -0.0012];
    let input = raster(folder.path(), "dem.tif", (60, 50), transform, "EPSG:4326", &spikes(3, 9));
    let control = Control::default();
    let with = |name: &str, threads: usize| TilesRequest {
        threads: std::num::NonZeroUsize::new(threads),
        ..request(&input, &at(name), 15.0)
    };
    tiles(&with("one", 1), &control).expect("tiles");
    tiles(&with("three", 3), &control).expect("tiles");
    let expected = content(&at("one"));
    assert_eq!(expected, content(&at("three")));

    let request = TilesRequest { work_dir: Some(at("work")), keep_work_dir: true, ..with("shards", 2) };
    lay_out_tiles(&request, Vec::new(), &control).expect("laid out");
    for number in [3, 1, 2] {
        work_on_tiles(&request, Shard::new(number, 3).expect("a shard"), &control).expect("a share");
    }
    merge_tiles(&request, &control).expect("merged");
    assert_eq!(expected, content(&at("shards")));

    // The raster may have changed: its samples are compared. They are the same.
    std::fs::write(&input, std::fs::read(&input).expect("a raster")).expect("written");
    let again = TilesRequest { output: at("again"), ..request.clone() };
    let report = tiles(&again, &control).expect("tiles");
    assert_eq!(report.tiles_found, report.levels.iter().map(|level| level.tiles).sum::<u64>());
    assert_eq!(expected, content(&at("again")));

    // A file that is cut short is none.
    let kept = content(&at("work")).into_iter().map(|(name, _)| name).find(|name| name.ends_with("own.samples"));
    let file = std::fs::OpenOptions::new().write(true).open(at("work").join(kept.expect("kept"))).expect("a file");
    file.set_len(file.metadata().expect("a length").len() - 1).expect("cut");
    let found = work_on_tiles(&request, Shard::new(1, 1).expect("a shard"), &control);
    assert!(matches!(found, Err(PyramidError::Gone { .. })), "{found:?}");

    let other = TilesRequest { output: at("other"), own_samples: false, ..request };
    let refused = tiles(&other, &control).expect_err("other options").to_string();
    assert!(refused.contains("own samples"), "{refused}");
}

/// Rectangles give the samples in them, once each, and count on over the antimeridian.
#[test]
fn rectangles_have_their_samples() {
    let folder = folder();
    let step = 0.05;
    let transform = [179.0, step, 0.0, 12.0, 0.0, -step];
    let (width, height) = (60usize, 30usize);
    let input = raster(folder.path(), "dem.tif", (width, height), transform, "EPSG:4326", &|c, r| (100 * r + c) as f32);
    let request = request(&input, Path::new("out"), 100.0);
    let prepared = prepare::open(&request, &Control::default()).expect("a raster");
    let grid = prepared.source.grid(0).expect("a grid");
    let samples = prepare::resample(&prepared, grid, &request, &Control::default()).expect("samples");
    let file = store::temporary(folder.path()).expect("a file");
    let own = OwnStore::make(&prepared, &samples, (file, folder.path()), &Control::default()).expect("samples");
    let around = grid.columns() as f64;
    // Those near the raster's border do not count.
    let inner = |c: usize, r: usize| (1..width - 1).contains(&c) && (1..height - 1).contains(&r);
    for first in [around - 40.0, around - 5.5, -20.25, 3.0] {
        for (wide, rows) in [(30.0, (1100.0, 1125.5)), (12.5, (1000.0, 3000.0)), (around / 2.0, (0.0, 4096.0))] {
            let rectangle = Rectangle { columns: (first, first + wide), rows };
            let mut found: Vec<OwnSample> = Vec::new();
            own.read(rectangle, &mut found).expect("samples");
            let mut heights: Vec<f64> = found.iter().map(|sample| sample.height).collect();
            heights.sort_by(f64::total_cmp);
            assert!(heights.windows(2).all(|pair| pair[0] < pair[1]), "{rectangle:?}: one twice");
            for (c, r) in (0..width).flat_map(|c| (0..height).map(move |r| (c, r))) {
                let (lon, lat) = (179.0 + (c as f64 + 0.5) * step, 12.0 - (r as f64 + 0.5) * step);
                let column = (lon + 180.0) / grid.cell();
                let column =
                    [column - around, column, column + around].into_iter().find(|c| (first..=first + wide).contains(c));
                let row = (90.0 - lat) / grid.cell();
                let is_in = column.is_some() && (rows.0..=rows.1).contains(&row);
                let sample = found.iter().find(|sample| sample.height == (100 * r + c) as f64);
                if inner(c, r) {
                    assert_eq!(sample.is_some(), is_in, "{c}, {r} of {rectangle:?}");
                }
                if let (Some(sample), Some(column)) = (sample, column) {
                    assert!((sample.column - column).abs() < 1e-6 && (sample.row - row).abs() < 1e-6, "{sample:?}");
                }
            }
        }
    }
}
