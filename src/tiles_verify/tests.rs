//! Sets that keep their promise pass; a set that is changed in any one way fails for that.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;

use super::decode::decode;
use super::{TilesVerifyRequest, Verdict, tiles_verify};
use crate::base::control::Control;
use crate::pyramid::{TilesRequest, tiles};
use crate::testing::{folder, raster};

pub(super) fn hills(column: usize, row: usize) -> f32 {
    let (x, y) = (column as f32, row as f32);
    900.0 + 500.0 * (x / 9.0).sin() * (y / 7.0).cos() + 20.0 * ((x * 1.3 + y * 2.1) % 5.0)
}

pub(super) fn verdict(input: &Path, set: &Path) -> Verdict {
    let request = TilesVerifyRequest {
        input: input.to_path_buf(),
        view: crate::raster::View::default(),
        tiles: set.to_path_buf(),
        memory: None,
        threads: std::num::NonZeroUsize::new(2),
        temp_dir: Some(crate::fuzzing::temp_dir()),
    };
    tiles_verify(&request, &Control::default()).expect("a verdict")
}

fn make(input: &Path, set: &Path, max_error: f64) {
    let request = TilesRequest {
        temp_dir: Some(crate::fuzzing::temp_dir()),
        outside: 50.0,
        threads: std::num::NonZeroUsize::new(2),
        ..TilesRequest::new(input, set, max_error)
    };
    tiles(&request, &Control::default()).expect("tiles");
}

/// The files of a raster and its tiles, made once: two by two tiles of the finest level. They are held in memory, as nobody would
/// remove a folder of all tests.
fn scene() -> &'static [(PathBuf, Vec<u8>)] {
    static SCENE: OnceLock<Vec<(PathBuf, Vec<u8>)>> = OnceLock::new();
    SCENE.get_or_init(|| {
        let scene = folder();
        let place = [11.1, 0.005, 0.0, 45.15, 0.0, -0.005];
        let input = raster(scene.path(), "dem.tif", (60, 60), place, "EPSG:4326", &hills);
        make(&input, &scene.path().join("set"), 60.0);
        let (mut folders, mut files) = (vec![scene.path().to_path_buf()], Vec::new());
        while let Some(next) = folders.pop() {
            for path in next.read_dir().expect("a folder").map(|entry| entry.expect("an entry").path()) {
                if path.is_dir() {
                    folders.push(path);
                    continue;
                }
                let name = path.strip_prefix(scene.path()).expect("inside").to_path_buf();
                files.push((name, std::fs::read(path).expect("a file")));
            }
        }
        files
    })
}

/// A copy of the set that may be changed, and its tiles; the raster is beside it.
pub(super) fn copy() -> (TempDir, PathBuf, Vec<PathBuf>) {
    let to = folder();
    let mut tiles = Vec::new();
    for (name, bytes) in scene() {
        let file = to.path().join(name);
        std::fs::create_dir_all(file.parent().expect("a folder")).expect("a folder");
        std::fs::write(&file, bytes).expect("written");
        tiles.extend(Some(file).filter(|f| f.extension().is_some_and(|e| e == "terrain")));
    }
    // Finest level last.
    tiles.sort_by_key(|tile| (tile.components().rev().nth(2).map(|c| c.as_os_str().len()), tile.clone()));
    let set = to.path().join("set");
    (to, set, tiles)
}

/// The raster beside a set.
fn dem(set: &Path) -> PathBuf {
    set.with_file_name("dem.tif")
}

pub(super) fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes")) as usize
}

/// Adds to the height of a vertex, in steps.
fn raise(bytes: &mut [u8], vertex: usize, steps: i32) {
    let count = u32_at(bytes, 88);
    for (i, change) in [(vertex, steps), (vertex + 1, -steps)] {
        if i < count {
            let at = 92 + 4 * count + 2 * i;
            let code = u16::from_le_bytes([bytes[at], bytes[at + 1]]);
            let delta = i32::from(code >> 1) ^ -i32::from(code & 1);
            let delta = delta + change;
            let code = ((delta << 1) ^ (delta >> 31)) as u16;
            bytes[at..at + 2].copy_from_slice(&code.to_le_bytes());
        }
    }
}

pub(super) fn change(path: &Path, change: impl FnOnce(&mut Vec<u8>)) {
    let mut bytes = std::fs::read(path).expect("a file");
    change(&mut bytes);
    std::fs::write(path, bytes).expect("written");
}

pub(super) fn fails(set: &Path, word: &str) {
    let verdict = verdict(&dem(set), set);
    let said = verdict.failures.join("\n");
    assert!(!verdict.passed && said.contains(word), "expected {word}, found {said}");
}

#[test]
fn a_set_as_it_is_made_passes() {
    let (_keep, set, _) = copy();
    let verdict = verdict(&dem(&set), &set);
    assert!(verdict.passed, "{verdict}");
    assert!(verdict.levels.last().expect("levels").tiles >= 4 && verdict.gaps.len() > 2, "{verdict}");
    assert!(verdict.levels.iter().all(|l| l.samples >= 3600 && l.largest_error > 0.0), "{verdict}");
}

#[test]
fn a_vertex_that_is_moved_is_found() {
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| {
        let decoded = decode(bytes).expect("a tile");
        // Off the border, and where the raster has a height.
        let is_inside = |i: &usize| decoded.vertices[*i][..2].iter().all(|c| (1..32767).contains(c));
        let mut inside = (0..decoded.vertices.len()).filter(is_inside);
        let inner = inside.find(|&i| decoded.height(i) > 800.0).expect("one inside");
        let step = (decoded.maximum - decoded.minimum) / 32767.0;
        raise(bytes, inner, -(200.0 / step) as i32);
    });
    fails(&set, "from the sample");
}

#[test]
fn a_border_that_is_moved_is_found_however_little() {
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| {
        let decoded = decode(bytes).expect("a tile");
        raise(bytes, decoded.sides[1][decoded.sides[1].len() / 2] as usize, 1);
        raise(bytes, decoded.sides[0][decoded.sides[0].len() / 2] as usize, 1);
    });
    fails(&set, "same border vertices");
}

#[test]
fn a_tile_that_is_missing_is_found() {
    let (_keep, set, tiles) = copy();
    std::fs::remove_file(tiles.last().expect("tiles")).expect("removed");
    fails(&set, "available tiles are not those that there are");
    fails(&set, "of the raster's");
    // Nor does a level have more of them.
    let (_keep, set, tiles) = copy();
    let far = tiles.last().expect("tiles").with_file_name("4294967295.terrain");
    std::fs::copy(tiles.last().expect("tiles"), far).expect("a copy");
    fails(&set, "is beyond the columns and rows of its level");
}

#[test]
fn a_triangle_that_is_turned_over_or_missing_is_found() {
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| {
        let at = 92 + 6 * u32_at(bytes, 88);
        let last = at + 4 + 6 * (u32_at(bytes, at) - 1);
        // Its codes name old vertices or new ones: two that are not new change places.
        let codes: Vec<u16> = bytes[last..last + 6].chunks(2).map(|c| u16::from_le_bytes([c[0], c[1]])).collect();
        assert!(codes.iter().all(|c| *c > 0), "the last triangle has no new vertex: {codes:?}");
        bytes[last..last + 4].rotate_left(2);
    });
    fails(&set, "turned over");
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| {
        let at = 92 + 6 * u32_at(bytes, 88);
        let triangles = u32_at(bytes, at) - 1;
        bytes.drain(at + 4 + 6 * triangles..at + 10 + 6 * triangles);
        bytes[at..at + 4].copy_from_slice(&(triangles as u32).to_le_bytes());
    });
    fails(&set, "a triangle on one side only");
}

#[test]
fn manifests_that_lie_are_found() {
    let json = |set: &Path, name: &str, edit: &dyn Fn(&mut serde_json::Value)| {
        let path = set.join(name);
        let mut value = serde_json::from_str(&std::fs::read_to_string(&path).expect("a file")).expect("JSON");
        edit(&mut value);
        std::fs::write(path, value.to_string()).expect("written");
    };
    let (_keep, set, _) = copy();
    json(&set, "layer.json", &|layer| layer["maxzoom"] = 3.into());
    fails(&set, "maxzoom");
    let (_keep, set, _) = copy();
    json(&set, "layer.json", &|layer| layer["scheme"] = "xyz".into());
    fails(&set, "scheme");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["levels"][8]["max_error"] = 5.0.into());
    fails(&set, "from the sample");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["levels"][2]["max_error"] = 1e6.into());
    fails(&set, "where the rule gives");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["max_error"] = 61.0.into());
    fails(&set, "promises 60 m, where the rule gives 61 m");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["levels"][8]["parts"] = 4096.into());
    fails(&set, "level 8 has tiles of 4096 × 4096 parts, expected a power of two, at most");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["gzip"] = true.into());
    fails(&set, "expected gzip");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["outside"] = 50.5.into());
    fails(&set, "from the height outside");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["vertical_crs"] = "EPSG:5773".into());
    fails(&set, "expected the vertical CRS \"\", found \"EPSG:5773\"");
    let (_keep, set, _) = copy();
    json(&set, "terrabite.json", &|promise| promise["generator"] = "another program 1.0".into());
    fails(&set, "expected the generator \"terrabite\" and its version, found \"another program 1.0\"");
}

#[test]
fn lists_and_headers_are_judged() {
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| {
        let radius = f64::from_le_bytes(bytes[56..64].try_into().expect("eight bytes"));
        bytes[56..64].copy_from_slice(&(0.9 * radius).to_le_bytes());
        let at = 92 + 6 * u32_at(bytes, 88);
        let west = at + 4 + 6 * u32_at(bytes, at);
        // The first vertex of the list becomes its second.
        bytes.copy_within(west + 6..west + 8, west + 4);
    });
    fails(&set, "from the centre of a sphere");
    fails(&set, "west side");
    // Where readers take them from: centre, heights, sphere, occlusion point.
    let put = |at: usize, number: f64, words: &str| {
        let (_keep, set, tiles) = copy();
        change(tiles.last().expect("tiles"), |bytes| bytes[at..at + 8].copy_from_slice(&number.to_le_bytes()));
        fails(&set, words);
    };
    put(0, 0.0, "its centre is not in its sphere");
    put(56, 1e30, "from the centre of a sphere");
    put(64, 0.0, "a vertex can be seen");
    for at in [24, 28] {
        let (_keep, set, tiles) = copy();
        change(&tiles[0], |bytes| bytes[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes()));
        fails(&set, "found NaN");
    }
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| bytes[24..28].copy_from_slice(&(-3.3e6f32).to_le_bytes()));
    fails(&set, "its least height is -3300000 m, expected none below -3178376.1571");
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| bytes.truncate(200));
    fails(&set, "found the end");
}

/// Compressed sets pass; not those in which one file is not, or has something after its end.
#[test]
fn all_files_are_compressed_or_none() {
    let (_keep, plain, _) = copy();
    let (input, set) = (dem(&plain), plain.with_file_name("gzip"));
    let gzip = TilesRequest { gzip: true, outside: 50.0, ..TilesRequest::new(&input, &set, 60.0) };
    tiles(&gzip, &Control::default()).expect("tiles");
    assert!(verdict(&input, &set).passed);
    let tile = set.join("0/0/0.terrain");
    change(&tile, |bytes| bytes.extend([0, 1, 2]));
    fails(&set, "found 3 bytes more");
    std::fs::copy(plain.join("0/0/0.terrain"), &tile).expect("a copy");
    fails(&set, "found a plain file");
    // Files of others would go with an earlier set.
    std::fs::write(set.join("0/notes.txt"), "mine").expect("written");
    let again = tiles(&TilesRequest { overwrite: true, ..gzip }, &Control::default()).expect_err("refused").to_string();
    assert!(again.contains("notes.txt") && set.join("0/notes.txt").exists(), "{again}");
}

/// Over the antimeridian, in longitudes beyond 180°, on another body, at a pole, and with samples that are missing.
#[test]
fn odd_places_keep_the_promise() {
    let holes = |c: usize, r: usize| if c % 11 < 3 && r % 13 < 4 { f32::NAN } else { hills(c, r) };
    let moon = "GEOGCS[\"Moon\",DATUM[\"Moon\",SPHEROID[\"Moon\",1737400,0]],PRIMEM[\"0\",0],UNIT[\"degree\",0.0174532925199433]]";
    type Case<'a> = (&'a str, (usize, usize), [f64; 6], &'a str, f64, &'a dyn Fn(usize, usize) -> f32);
    let polar = "EPSG:3413";
    let cases: [Case<'_>; 5] = [
        ("polar.tif", (40, 40), [-400_000.0, 20_000.0, 0.0, 400_000.0, 0.0, -20_000.0], polar, 2000.0, &hills),
        ("over.tif", (40, 30), [178.3, 0.1, 0.0, -16.0, 0.0, -0.1], "EPSG:4326", 1000.0, &hills),
        ("utm.tif", (40, 30), [200_000.0, 9000.0, 0.0, 7_000_000.0, 0.0, -9000.0], "EPSG:32601", 1000.0, &hills),
        ("moon.tif", (360, 180), [0.0, 1.0, 0.0, 90.0, 0.0, -1.0], moon, 4000.0, &hills),
        ("holes.tif", (50, 40), [10.0, 0.02, 0.0, 47.0, 0.0, -0.02], "EPSG:4326", 1000.0, &holes),
    ];
    for (name, size, transform, crs, max_error, heights) in cases {
        let folder = folder();
        let input = raster(folder.path(), name, size, transform, crs, heights);
        let set = folder.path().join("set");
        make(&input, &set, max_error);
        let verdict = verdict(&input, &set);
        assert!(verdict.passed, "{name}: {verdict}");
        let valid = (0..size.0 * size.1).filter(|i| !heights(i % size.0, i / size.0).is_nan()).count() as f64;
        for level in &verdict.levels {
            let own = level.own_samples;
            assert!(own.samples as f64 > 0.6 * valid && own.samples as f64 <= valid, "{name}: {own:?} of {valid}");
            // Nowhere are cliffs to the height outside among them.
            assert!(own.largest_error < level.max_error + 500.0, "{name}: {own:?}");
        }
    }
}

/// With fine heights, the heights of every header are 4,095.875 m apart or more.
#[test]
fn fine_heights_are_judged() {
    let (_keep, plain, _) = copy();
    let (input, set) = (dem(&plain), plain.with_file_name("fine"));
    let fine = TilesRequest { fine_heights: true, outside: 50.0, ..TilesRequest::new(&input, &set, 60.0) };
    tiles(&fine, &Control::default()).expect("tiles");
    let judged = verdict(&input, &set);
    assert!(judged.passed, "{judged}");
    let header = |set: &Path| {
        let decoded = decode(&std::fs::read(set.join("0/0/0.terrain")).expect("a tile")).expect("a tile");
        decoded.maximum - decoded.minimum
    };
    // The other root has nothing but the height outside.
    assert_eq!(header(&set), 4095.875);
    assert!(header(&plain) < 10.0);
    std::fs::copy(plain.join("0/0/0.terrain"), set.join("0/0/0.terrain")).expect("a copy");
    let judged = verdict(&input, &set);
    assert!(judged.failures.join(" ").contains("expected 4095.875 or more"), "{judged}");
}
