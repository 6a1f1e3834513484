//! How far edges stray, against a slow way to find it, and sets that are held to a limit.

use std::collections::BTreeSet;
use std::path::Path;

use super::decode::{LAST, decode};
use super::tests::{change, verdict};
use crate::base::control::Control;
use crate::pyramid::{PROMISE, Promise, TilesRequest, tiles};
use crate::testing::{folder, raster};

const SIZE: (usize, usize) = (60, 50);
const CELL: f64 = 180.0 / (1 << 16) as f64;
/// The raster's first sample, which is one of the grid.
const FIRST: (usize, usize) = ((191.0 / CELL) as usize, (45.0 / CELL) as usize);

/// Blocks with walls, beside which edges stray.
fn walls(column: usize, row: usize) -> f32 {
    let (x, y) = (column as f32, row as f32);
    900.0 + 170.0 * ((column / 7 + row / 5) % 2) as f32 + 9.0 * ((x * 1.3 + y * 2.1) % 5.0)
}

fn make(folder: &Path, name: &str, max_stray: f64) {
    let corner = [FIRST.0 as f64 * CELL - 180.0 - 0.5 * CELL, 90.0 - FIRST.1 as f64 * CELL + 0.5 * CELL];
    let transform = [corner[0], CELL, 0.0, corner[1], 0.0, -CELL];
    let input = raster(folder, "dem.tif", SIZE, transform, "EPSG:4326", &walls);
    let temp_dir = Some(crate::fuzzing::temp_dir());
    let request = TilesRequest { max_stray, temp_dir, ..TilesRequest::new(input, folder.join(name), 20.0) };
    tiles(&request, &Control::default()).expect("tiles");
}

#[test]
fn edges_keep_to_the_limit_that_is_promised() {
    let folder = folder();
    let [free, held] = [("free", f64::INFINITY), ("held", 1.5)].map(|(name, max_stray)| {
        make(folder.path(), name, max_stray);
        verdict(&folder.path().join("dem.tif"), &folder.path().join(name))
    });
    assert!(free.passed && held.passed, "{free}\n{held}");
    let share = |of: &super::LevelVerdict| of.strays.largest / of.max_error;
    assert!(free.levels.iter().any(|level| share(level) > 1.5), "{free}");
    assert!(held.levels.iter().all(|level| share(level) <= 1.5 && level.strays.beyond == 0), "{held}");

    let finest = free.levels.last().expect("levels");
    let (largest, left_out) = found_one_by_one(&folder.path().join("free"), finest.level);
    // Triangles are small, so that edges are nearly straight on the grid.
    assert!((finest.strays.largest - largest).abs() < 0.5, "{:?}, not {largest}", finest.strays);
    assert!((finest.strays.largest_left_out - left_out).abs() < 0.5, "{:?}, not {left_out}", finest.strays);

    let promise = folder.path().join("free").join(PROMISE);
    change(&promise, |bytes| {
        let text = String::from_utf8_lossy(bytes).replacen('{', "{\"max_stray\": 1.5,", 1);
        *bytes = text.into_bytes();
    });
    let fooled = verdict(&folder.path().join("dem.tif"), &folder.path().join("free"));
    assert!(!fooled.passed && fooled.failures.join("\n").contains("beyond the heights around"), "{fooled}");
}

/// The largest strays of a level, on lines that are straight on the grid: inside of parts, and beside their lines.
fn found_one_by_one(set: &Path, level: u32) -> (f64, f64) {
    let cells = 1i64 << (16 - level);
    let promise = std::fs::read_to_string(set.join(PROMISE)).expect("a promise");
    let promise: Promise = serde_json::from_str(&promise).expect("a promise");
    let part = cells / i64::from(promise.levels[level as usize].parts);
    let (mut largest, mut left_out) = (0.0f64, 0.0f64);
    let is_inside = |column: i64, row: i64| {
        let [column, row] = [column - FIRST.0 as i64, row - FIRST.1 as i64];
        (0..SIZE.0 as i64).contains(&column) && (0..SIZE.1 as i64).contains(&row)
    };
    let folder = set.join(level.to_string());
    let entries =
        |path: &Path| path.read_dir().expect("a folder").map(|e| e.expect("an entry").path()).collect::<Vec<_>>();
    for path in entries(&folder).iter().flat_map(|column| entries(column)) {
        let tile = decode(&std::fs::read(&path).expect("a tile")).expect("a tile");
        let number =
            |path: &Path| path.file_stem().expect("a name").to_string_lossy().parse::<i64>().expect("a number");
        let x = number(path.parent().expect("a folder"));
        let y = number(&path);
        let corner = [x * cells, (1i64 << 16) - (y + 1) * cells];
        let at = |vertex: u32| {
            let [u, v, _] = tile.vertices[vertex as usize].map(f64::from);
            let scale = cells as f64 / f64::from(LAST);
            [
                corner[0] as f64 + u * scale,
                corner[1] as f64 + (f64::from(LAST) - v) * scale,
                tile.height(vertex as usize),
            ]
        };
        let edges: BTreeSet<(u32, u32)> = tile
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a.min(b), a.max(b)), (b.min(c), b.max(c)), (c.min(a), c.max(a))])
            .collect();
        for (p, q) in edges.into_iter().map(|(p, q)| (at(p), at(q))) {
            let is_on_border = (0..2).any(|k| p[k] == q[k] && (p[k] - corner[k] as f64) % cells as f64 == 0.0);
            for axis in [0, 1].into_iter().filter(|_| !is_on_border) {
                let (low, high) = (p[axis].min(q[axis]), p[axis].max(q[axis]));
                for line in low.floor() as i64 + 1..=high.ceil() as i64 - 1 {
                    let share = (line as f64 - p[axis]) / (q[axis] - p[axis]);
                    let along = p[1 - axis] + share * (q[1 - axis] - p[1 - axis]);
                    let height = p[2] + share * (q[2] - p[2]);
                    let before = along.floor() as i64;
                    let sample = |at: i64| {
                        let [column, row] = if axis == 0 { [line, at] } else { [at, line] };
                        let height = || f64::from(walls(column as usize - FIRST.0, row as usize - FIRST.1));
                        is_inside(column, row).then(height)
                    };
                    let (Some(one), Some(two)) = (sample(before), sample(before + 1)) else { continue };
                    let by = (height - one.max(two)).max(one.min(two) - height);
                    let is_at_rim = (-1..=1).any(|k| {
                        (-1..=2).any(|i| {
                            let [column, row] = if axis == 0 { [line + k, before + i] } else { [before + i, line + k] };
                            !is_inside(column, row)
                        })
                    });
                    let is_beside = [(line, corner[axis]), (before, corner[1 - axis]), (before + 1, corner[1 - axis])];
                    match is_at_rim || is_beside.iter().any(|(at, corner)| (at - corner) % part == 0) {
                        true => left_out = left_out.max(by),
                        false => largest = largest.max(by),
                    }
                }
            }
        }
    }
    (largest, left_out)
}
