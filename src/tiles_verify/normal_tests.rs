//! Normals: sets in which one is changed, and ground whose slope is known.

use super::decode::{LAST, decode};
use super::tests::{change, copy, fails, u32_at, verdict};
use crate::base::control::Control;
use crate::pyramid::{TilesRequest, tiles};
use crate::testing::{folder, raster};

/// A vertex inside of a tile whose normal has a bit more or less, however little it is, is named with its place.
#[test]
fn a_normal_that_is_changed_is_found() {
    for bit in [0, 7] {
        let (_keep, set, tiles) = copy();
        let mut vertex = 0;
        change(tiles.last().expect("tiles"), |bytes| {
            let (decoded, count) = (decode(bytes).expect("a tile"), u32_at(bytes, 88));
            let is_inside = |i: &usize| decoded.vertices[*i][..2].iter().all(|c| (1..LAST).contains(c));
            vertex = (0..count).find(is_inside).expect("one inside");
            let at = bytes.len() - 2 * count + 2 * vertex;
            bytes[at] ^= 1 << bit;
        });
        fails(&set, &format!("the normal of vertex {vertex} at "));
        fails(&set, "° from that of the ground");
    }
    // Without a number there is no normal.
    let (_keep, set, tiles) = copy();
    change(tiles.last().expect("tiles"), |bytes| {
        let at = bytes.len() - 2 * u32_at(bytes, 88) - 5;
        bytes[at] = 2;
    });
    fails(&set, "normals are missing");
}

/// On ground that rises evenly on the grid, each normal leans by its slope, which is known from the Earth's radii there.
#[test]
fn normals_lean_as_the_ground_does() {
    const CELL: f64 = 180.0 / (1 << 14) as f64;
    let (column, row) = ((191.0 / CELL).round(), (45.0 / CELL).round());
    let (lon, lat) = ((column * CELL - 180.0).to_radians(), (90.0 - row * CELL).to_radians());
    // Metres in a cell at 45° N, by the radii of curvature of WGS 84.
    let (across, along) = (6_388_838.29 * lat.cos(), 6_367_381.82);
    let metres = [across, along].map(|radius| radius * CELL.to_radians());
    let (to_east, to_south) = (-0.7, 0.4);
    let folder = folder();
    let ground = |c: usize, r: usize| {
        (2000.0 + to_east * metres[0] * (c as f64 - 10.0) + to_south * metres[1] * (r as f64 - 10.0)) as f32
    };
    let corner = [column * CELL - 180.0 - 10.5 * CELL, 90.0 - row * CELL + 10.5 * CELL];
    let transform = [corner[0], CELL, 0.0, corner[1], 0.0, -CELL];
    let input = raster(folder.path(), "dem.tif", (21, 21), transform, "EPSG:4326", &ground);
    let set = folder.path().join("set");
    let request = TilesRequest { temp_dir: Some(crate::fuzzing::temp_dir()), ..TilesRequest::new(&input, &set, 20.0) };
    let levels = tiles(&request, &Control::default()).expect("tiles").levels;
    let judged = verdict(&input, &set);
    assert!(judged.passed, "{judged}");

    let level = levels.len() - 1;
    let side = 180.0 / f64::from(1u32 << level);
    let (x, y) = ((column * CELL / side) as u32, ((180.0 - row * CELL) / side) as u32);
    let tile = std::fs::read(set.join(format!("{level}/{x}/{y}.terrain"))).expect("a tile");
    let decoded = decode(&tile).expect("a tile");
    let normals = decoded.normals.expect("normals");
    let mut seen = 0;
    for (vertex, code) in decoded.vertices.iter().zip(normals) {
        let at = [(x, vertex[0]), (y, vertex[1])]
            .map(|(number, c)| side * (f64::from(number) + f64::from(c) / f64::from(LAST)));
        let off = [at[0] - column * CELL, at[1] - (180.0 - row * CELL)].map(|off| off.abs() / CELL);
        // The sample itself and those around it, between which the slope is the same.
        if off.iter().any(|off| *off > 8.5) {
            continue;
        }
        seen += 1;
        let [x, y] = code.map(|byte| f64::from(byte) / 255.0 * 2.0 - 1.0);
        assert!(x.abs() + y.abs() <= 1.0, "it looks north");
        let found = [x, y, 1.0 - x.abs() - y.abs()];
        let expected = [
            lat.cos() * lon.cos() + to_east * lon.sin() - to_south * lat.sin() * lon.cos(),
            lat.cos() * lon.sin() - to_east * lon.cos() - to_south * lat.sin() * lon.sin(),
            lat.sin() + to_south * lat.cos(),
        ];
        let size = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let cosine = (0..3).map(|k| found[k] * expected[k]).sum::<f64>() / size(found) / size(expected);
        // A degree for the bytes, and what the Earth turns in nine cells.
        assert!(cosine.acos().to_degrees() < 1.2, "{code:?} at {off:?}: {cosine}");
    }
    assert!(seen > 0, "{to_east}, {to_south}");
}
