//! Errors at the raster's own samples, against slow ways to find them.

use std::collections::BTreeMap;
use std::path::Path;

use super::decode::{Decoded, LAST, decode};
use super::{LevelVerdict, TilesVerifyRequest, tiles_verify};
use crate::base::control::Control;
use crate::pyramid::{TilesRequest, tiles};
use crate::testing::{folder, raster};

const SIZE: (usize, usize) = (70, 50);

fn hills(column: usize, row: usize) -> f32 {
    let (x, y) = (column as f32, row as f32);
    900.0 + 60.0 * (x / 9.0).sin() * (y / 7.0).cos() + 9.0 * ((x * 1.3 + y * 2.1) % 5.0)
}

/// A set of tiles of hills in such a place, and what is found of its levels, the finest last.
fn found(folder: &Path, transform: [f64; 6], max_error: f64) -> Vec<LevelVerdict> {
    let input = raster(folder, "dem.tif", SIZE, transform, "EPSG:4326", &hills);
    let set = folder.join("set");
    let temp_dir = Some(crate::fuzzing::temp_dir());
    let request = TilesRequest { temp_dir: temp_dir.clone(), ..TilesRequest::new(&input, &set, max_error) };
    tiles(&request, &Control::default()).expect("tiles");
    let view = crate::raster::View::default();
    let request = TilesVerifyRequest { input, view, tiles: set, memory: None, threads: None, temp_dir };
    let verdict = tiles_verify(&request, &Control::default()).expect("a verdict");
    assert!(verdict.passed, "{verdict}");
    verdict.levels
}

/// Where the raster's samples are those of the grid, their errors are the same.
#[test]
fn on_the_grid_they_are_its_samples() {
    let folder = folder();
    let cell = 180.0 / f64::from(1 << 16);
    let first = |at: f64| (at / cell).round() * cell - 0.5 * cell;
    for level in found(folder.path(), [first(11.0), cell, 0.0, -first(-45.0), 0.0, -cell], 20.0) {
        let own = level.own_samples;
        assert!((own.largest_error - level.largest_error).abs() < 1e-6, "{level:?}");
        assert_eq!((own.samples, own.above), ((SIZE.0 * SIZE.1) as u64, 0), "{level:?}");
    }
}

/// Between samples of the grid, errors are those of planes over longitude and latitude, as triangles are small.
#[test]
fn between_they_are_found_one_by_one() {
    let folder = folder();
    let (west, north, step) = (11.0, 45.0, 0.0011);
    let levels = found(folder.path(), [west, step, 0.0, north, 0.0, -step], 20.0);
    let finest = levels.last().expect("levels");
    let side = 180.0 / f64::from(1u32 << finest.level);
    let mut tiles: BTreeMap<(u32, u32), Decoded> = BTreeMap::new();
    // Sag is less than that: no triangle is 3 km long.
    let sag = 0.2;
    let (mut samples, mut largest, mut above) = (0, 0.0f64, [0, 0]);
    for (column, row) in (0..SIZE.0).flat_map(|c| (0..SIZE.1).map(move |r| (c, r))) {
        let (lon, lat) = (west + (column as f64 + 0.5) * step, north - (row as f64 + 0.5) * step);
        // Those of the grid around it, of which there are no fewer than of the raster, are between the raster's samples.
        let cell = (7..).map(|e| 180.0 / f64::from(1u32 << e)).find(|cell| *cell <= step).expect("a grid");
        let around = |at: f64, first: f64, last: f64| {
            (at / cell).floor() * cell >= first - 1e-9 && (at / cell).ceil() * cell <= last + 1e-9
        };
        let (first, last) = (west + 0.5 * step, west + (SIZE.0 as f64 - 0.5) * step);
        let (bottom, top) = (north - (SIZE.1 as f64 - 0.5) * step, north - 0.5 * step);
        if !around(lon, first, last) || !around(lat, bottom, top) {
            continue;
        }
        let (x, y) = ((lon + 180.0) / side, (lat + 90.0) / side);
        let tile = tiles.entry((x as u32, y as u32)).or_insert_with_key(|(x, y)| {
            let path = folder.path().join(format!("set/{}/{x}/{y}.terrain", finest.level));
            decode(&std::fs::read(path).expect("a tile")).expect("a tile")
        });
        let at = [x.fract() * f64::from(LAST), y.fract() * f64::from(LAST)];
        let error = (height(tile, at) - f64::from(hills(column, row))).abs();
        samples += 1;
        largest = largest.max(error);
        above[0] += u64::from(error > finest.max_error + sag);
        above[1] += u64::from(error > finest.max_error - sag);
    }
    let own = finest.own_samples;
    assert_eq!(own.samples, samples, "{own:?}");
    assert!((own.largest_error - largest).abs() < sag && largest > finest.max_error, "{own:?}, not {largest}");
    assert!(above[0] > 0 && (above[0]..=above[1]).contains(&own.above), "{own:?}, not {above:?}");
    assert_eq!(own.share_above, own.above as f64 / samples as f64);
}

/// The height of a tile at coordinates of its format, from the triangle around them.
fn height(tile: &Decoded, at: [f64; 2]) -> f64 {
    let shares = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| tile.vertices[i as usize].map(f64::from));
        let area =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let [a, b, c] = [a, b, c].map(|v| [v[0], v[1]]);
        let whole = area(a, b, c);
        [area(at, b, c) / whole, area(a, at, c) / whole, area(a, b, at) / whole]
    };
    let least = |triangle: &&[u32; 3]| shares(triangle).into_iter().fold(f64::INFINITY, f64::min);
    let triangle = tile.triangles.iter().max_by(|a, b| least(a).total_cmp(&least(b))).expect("triangles");
    (0..3).map(|i| shares(triangle)[i] * tile.height(triangle[i] as usize)).sum()
}
