//! Meshes that end short of the ground, as they may and as they may not.

use super::ground::{PATTERNS, scene};
use super::scene::{Mesh, NORTH_UP, SOUTH_UP, Scene, TURNED};
use crate::verify::{GroundOptions, TrimVerdict, Verdict};

/// Nodata in the first column and, where nothing else is said, a strip of two cells along it.
const SIDE: &[&str] = &[".########"; 7];

fn judge(scene: &Scene, trim: u32) -> Verdict {
    judge_on(scene, GroundOptions { fill_holes: 0, trim })
}

fn judge_on(scene: &Scene, ground: GroundOptions) -> Verdict {
    let verdict = scene.judge_ground(100.0, ground, 1).unwrap();
    for rows in 2..=scene.height {
        assert_eq!(scene.judge_ground(100.0, ground, rows).unwrap(), verdict, "{rows}");
    }
    let Verdict { checked, nodata, bridged, without_ground, samples, trim, .. } = verdict;
    assert_eq!(checked + nodata + bridged + without_ground.count + trim.map_or(0, |t| t.trimmed), samples);
    verdict
}

/// Judges [`SIDE`] with a changed mesh, whichever way the map is turned.
fn changed(change: impl Fn(&mut Mesh)) -> (Verdict, TrimVerdict) {
    let mut changed = scene(SIDE);
    change(&mut changed.mesh);
    let verdict = judge(&changed, 2);
    for transform in [SOUTH_UP, TURNED] {
        assert_eq!(judge(&Scene { transform, ..changed.clone() }, 2).passes(), verdict.passes());
    }
    (verdict.clone(), verdict.trim.unwrap())
}

/// The corners of a cell.
fn cell(column: i64, row: i64) -> [(i64, i64); 4] {
    [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)]
}

#[test]
fn a_mesh_of_exactly_the_ground_passes_whatever_may_be_trimmed() {
    for (name, rows, (checked, _)) in PATTERNS {
        for (transform, trim) in [(NORTH_UP, 1), (SOUTH_UP, 2), (TURNED, 9)] {
            let verdict = judge(&Scene { transform, ..scene(rows) }, trim);
            assert!(verdict.passes(), "{name}: {verdict}");
            assert_eq!((verdict.checked, verdict.trim.unwrap().trimmed), (checked, 0), "{name}");
        }
    }
}

#[test]
fn the_strip_may_be_bare_as_far_as_it_goes() {
    let (verdict, trim) = changed(|_| {});
    assert!(verdict.passes() && verdict.double_area == verdict.expected_double_area, "{verdict}");
    assert_eq!((trim.cells, trim.trimmed, trim.core_double_area), (2, 0, 32 * 5 * 6));
    let (verdict, trim) = changed(|mesh| {
        mesh.remove(&(0..7).flat_map(|row| [(1, row), (2, row), (3, row)]).collect::<Vec<_>>());
    });
    assert!(verdict.passes(), "{verdict}");
    assert_eq!((trim.trimmed, verdict.checked, verdict.double_area), (14, 42, trim.core_double_area));
    assert!(verdict.to_string().contains("trimmed, uncovered within 2 cells of missing samples: 14"), "{verdict}");
    // A face after another from the rim on.
    let (verdict, trim) = changed(|mesh| mesh.remove(&cell(1, 3)));
    assert!(verdict.passes() && trim.trimmed == 0, "{verdict}");
    // A rim that is simplified sideways.
    let (verdict, trim) = changed(|mesh| {
        mesh.remove(&(0..7).flat_map(|row| [(1, row), (2, row)]).collect::<Vec<_>>());
        for row in 0..3 {
            mesh.add([(2, row), (2, row + 1), (1, 0)]);
            mesh.add([(2, 6 - row), (2, 5 - row), (1, 6)]);
        }
    });
    assert!(verdict.passes(), "{verdict}");
    assert_eq!(trim.trimmed, 5);
}

#[test]
fn the_core_may_not_be_bare() {
    let (verdict, trim) = changed(|mesh| mesh.remove(&[(3, 3), (3, 4), (4, 4)]));
    assert!(trim.bare_core.count == 4 && trim.enclosed.count == 1, "{verdict}");
    // Not at the raster's edge, either.
    let (verdict, trim) = changed(|mesh| mesh.remove(&[(8, 3), (8, 4), (7, 3)]));
    assert_eq!((trim.bare_core.count, trim.enclosed.count), (4, 0), "{verdict}");
    assert!(
        verdict
            .to_string()
            .contains("4 stretches of quarter rows are uncovered more than 2 cells from missing samples"),
        "{verdict}"
    );
    // One that the strip of two leaves out is in that of three.
    let mut scene = scene(SIDE);
    scene.mesh.remove(&(0..7).flat_map(|row| (1..=4).map(move |column| (column, row))).collect::<Vec<_>>());
    assert!(judge(&scene, 3).passes() && !judge(&scene, 2).passes());
    let verdict = judge(&scene, 2);
    assert_eq!((verdict.uncovered.count, verdict.trim.unwrap().trimmed), (7, 14), "{verdict}");
    assert!(verdict.double_area < verdict.trim.unwrap().core_double_area);
}

#[test]
fn bare_ground_that_faces_enclose_is_a_fault() {
    let (verdict, trim) = changed(|mesh| mesh.remove(&cell(2, 3)));
    assert!(!verdict.passes() && trim.enclosed.count == 1 && trim.bare_core.count == 0, "{verdict}");
    assert_eq!(verdict.failures().len(), 1, "{verdict}");
    // At the raster's edge, or open to the rim, it is none.
    assert!(changed(|mesh| mesh.remove(&cell(2, 0))).0.passes());
    assert!(changed(|mesh| [cell(2, 3), cell(1, 3)].iter().for_each(|c| mesh.remove(c))).0.passes());
    // At a point alone it is.
    let (_, trim) = changed(|mesh| [cell(2, 3), cell(1, 2)].iter().for_each(|c| mesh.remove(c)));
    assert_eq!(trim.enclosed.count, 1);
    let (_, trim) = changed(|mesh| [cell(2, 3), cell(2, 1), cell(2, 4)].iter().for_each(|c| mesh.remove(c)));
    assert_eq!(trim.enclosed.count, 2);
    let first = trim.enclosed.first.unwrap();
    assert_eq!((first.x, first.y), (500_000.25 + 30.0 * 2.5, 5_200_000.5 - 30.0 * 1.5));
}

#[test]
fn overlaps_are_found_although_areas_agree() {
    let (verdict, trim) = changed(|mesh| {
        mesh.remove(&cell(1, 0));
        mesh.remove(&[(1, 1), (2, 1), (2, 2)]);
        mesh.add([(2, 2), (1, 3), (2, 5)]);
    });
    assert!(trim.overlapping_edges.count > 0, "{verdict}");
    assert_eq!(verdict.double_area, verdict.expected_double_area);
}

#[test]
fn junctions_in_the_strip_are_found() {
    let long = |mesh: &mut Mesh| {
        mesh.remove(&cell(1, 2));
        mesh.remove(&cell(1, 3));
        mesh.add([(1, 2), (1, 3), (2, 2)]);
        mesh.add([(1, 3), (2, 4), (2, 2)]);
        mesh.add([(1, 3), (1, 4), (2, 4)]);
    };
    let (verdict, trim) = changed(long);
    assert!(!verdict.passes() && trim.crossed_edges.count == 2 && trim.enclosed.count == 0, "{verdict}");
    // The same along a row.
    let (verdict, trim) = changed(|mesh| {
        mesh.remove(&[(1, 3), (2, 3), (3, 3), (1, 4), (2, 4), (3, 4)]);
        mesh.add([(1, 3), (1, 4), (2, 4)]);
        mesh.add([(1, 3), (2, 4), (3, 3)]);
        mesh.add([(3, 3), (2, 4), (3, 4)]);
    });
    assert!(!verdict.passes() && trim.crossed_edges.count > 0, "{verdict}");
    // Bare on one side, the long edge is well.
    let (verdict, _) = changed(|mesh| {
        long(mesh);
        mesh.remove(&[(1, 3), (2, 4), (2, 2)]);
        mesh.remove(&[(1, 2), (1, 3), (2, 2)]);
        mesh.remove(&[(1, 3), (1, 4), (2, 4)]);
    });
    assert!(verdict.passes(), "{verdict}");
}

#[test]
fn a_thin_crack_is_enclosed() {
    let (verdict, trim) = changed(|mesh| {
        let at = |mesh: &Mesh, column: i64, row: i64| {
            mesh.places.iter().position(|p| *p == (4 * column, 4 * row)).unwrap() as u64
        };
        // The faces to the left of (2, 3) get a vertex of their own, a quarter of a cell away.
        let middle = at(mesh, 2, 3);
        let twin = mesh.places.len() as u64;
        mesh.places.push((7, 12));
        mesh.heights.push(0.0);
        let places = mesh.places.clone();
        let to_the_left = |f: &&mut [u64; 3]| f.contains(&middle) && f.iter().all(|&v| places[v as usize].0 <= 8);
        mesh.faces.iter_mut().filter(to_the_left).flatten().filter(|v| **v == middle).for_each(|v| *v = twin);
    });
    assert_eq!((trim.enclosed.count, verdict.failures().len()), (1, 1), "{verdict}");
}

#[test]
fn faces_beyond_the_ground_are_found() {
    let (verdict, trim) = changed(|mesh| mesh.add([(0, 3), (1, 3), (1, 4)]));
    assert!(trim.beyond_ground.count > 0 && verdict.touched_nodata.count == 1, "{verdict}");
    let (verdict, trim) = changed(|mesh| {
        mesh.places.push((2, 14));
        mesh.heights.push(0.0);
        let apex = mesh.places.len() as u64 - 1;
        let at = |row: i64| mesh.places.iter().position(|p| *p == (4, 4 * row)).unwrap() as u64;
        mesh.faces.push([at(4), at(3), apex]);
    });
    assert_eq!((trim.beyond_ground.count, verdict.touched_nodata.count, verdict.passes()), (4, 0, false), "{verdict}");
}

#[test]
fn an_island_in_the_strip_may_be_left_out() {
    let mut lake = scene(&["#########", "#.......#", "#.##....#", "#.##....#", "#.......#", "#########"]);
    lake.mesh.remove(&cell(2, 2));
    let verdict = judge(&lake, 1);
    assert!(verdict.passes() && verdict.trim.unwrap().trimmed == 4, "{verdict}");
    assert!(!judge(&lake, 0).passes());
}

#[test]
fn nothing_is_trimmed_along_holes_that_are_bridged() {
    let rows = ["#######", "#######", "##..###", "#######", "#######"];
    let mut bridged = scene(&["#######"; 5]);
    bridged.samples = super::ground::samples(&rows);
    let ground = |fill_holes, trim| GroundOptions { fill_holes, trim };
    assert!(judge_on(&bridged, ground(2, 1)).passes());
    assert!(!judge_on(&bridged, ground(1, 1)).passes());
    let hole = |mesh: &mut Mesh| mesh.remove(&(1..4).flat_map(|r| (1..5).map(move |c| (c, r))).collect::<Vec<_>>());
    let mut bare = bridged.clone();
    hole(&mut bare.mesh);
    assert!(judge_on(&bare, ground(1, 1)).passes());
    let verdict = judge_on(&bare, ground(2, 1));
    assert!(verdict.trim.unwrap().bare_core.count > 0 && verdict.uncovered.count == 2, "{verdict}");
}
