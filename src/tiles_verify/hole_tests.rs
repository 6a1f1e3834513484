//! Sets with holes over voids, and such that only say so.

use std::path::{Path, PathBuf};

use super::decode::decode;
use super::tests::{change, hills, u32_at, verdict};
use crate::base::control::Control;
use crate::pyramid::{TilesRequest, VoidAs, tiles};
use crate::testing::{folder, raster};

/// Voids in the middle, at a rim, of single samples, and an island in one of them.
fn voids(column: usize, row: usize) -> f32 {
    let is_island = (26..30).contains(&column) && (20..24).contains(&row);
    let is_void = (20..41).contains(&column) && (14..33).contains(&row) && !is_island;
    let is_speck = column % 13 == 5 && row % 11 == 3;
    if is_void || is_speck || column + row > 100 { f32::NAN } else { hills(column, row) }
}

/// Holes are as large as they have to be, and nowhere else; heights for voids are promised nothing.
#[test]
fn holes_are_judged() {
    let folder = folder();
    let place = [11.1, 0.005, 0.0, 45.15, 0.0, -0.005];
    let input = raster(folder.path(), "dem.tif", (60, 60), place, "EPSG:4326", &voids);
    let made = |name: &str, void_as: VoidAs| {
        let set = folder.path().join(name);
        let request = TilesRequest { void_as, outside: 50.0, ..TilesRequest::new(&input, &set, 60.0) };
        let report = tiles(&request, &Control::default()).expect("tiles");
        let judged = verdict(&input, &set);
        assert!(judged.passed, "{judged}");
        (set, report.levels, judged)
    };
    let (filled, _, whole) = made("filled", VoidAs::Height(700.0));
    let (cut, levels, judged) = made("cut", VoidAs::Hole);
    let covered = |set: &Path| {
        let mut area = 0;
        for tile in tiles_of(set) {
            let decoded = decode(&std::fs::read(tile).expect("a tile")).expect("a tile");
            for t in decoded.triangles {
                let [a, b, c] = t.map(|i| decoded.vertices[i as usize].map(i64::from));
                area += (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            }
        }
        area
    };
    assert!(levels.last().expect("levels").triangles > 0);
    for (a, b) in whole.levels.iter().zip(&judged.levels) {
        assert_eq!((a.samples, a.tiles), (b.samples, b.tiles));
    }
    // The void in the middle has a ninth of all samples.
    let finest = format!("{}", levels.len() - 1);
    let share = covered(&cut.join(&finest)) as f64 / covered(&filled.join(&finest)) as f64;
    assert!(share < 0.97, "{share}");
    let says = |set: &Path, void_as: serde_json::Value, words: &str| {
        let path = set.join("terrabite.json");
        let text = std::fs::read_to_string(&path).expect("a file");
        let mut promise: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        promise["void_as"] = void_as;
        std::fs::write(&path, promise.to_string()).expect("written");
        let said = verdict(&input, set).failures.join("\n");
        assert!(said.contains(words), "expected {words}, found {said}");
        std::fs::write(&path, text).expect("written");
    };
    says(&filled, "hole".into(), "is over a void, where a hole is promised");
    says(&cut, "outside".into(), "an edge inside has a triangle on one side only");
    // A triangle that is gone where the raster is not.
    let tile = cut.join("1/2/1.terrain");
    change(&tile, |bytes| {
        let at = 92 + 6 * u32_at(bytes, 88);
        let triangles = u32_at(bytes, at) - 1;
        bytes.drain(at + 4 + 6 * triangles..at + 10 + 6 * triangles);
        bytes[at..at + 4].copy_from_slice(&(triangles as u32).to_le_bytes());
    });
    says(&cut, "hole".into(), "is a hole where the raster has no void");
}

/// All tiles of a folder, in order.
fn tiles_of(folder: &Path) -> Vec<PathBuf> {
    let mut folders = vec![folder.to_path_buf()];
    let mut tiles = Vec::new();
    while let Some(next) = folders.pop() {
        for path in next.read_dir().expect("a folder").map(|entry| entry.expect("an entry").path()) {
            if path.is_dir() { folders.push(path) } else { tiles.push(path) }
        }
    }
    tiles.retain(|path| path.extension().is_some_and(|e| e == "terrain"));
    tiles.sort();
    tiles
}
