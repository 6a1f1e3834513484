//! Every way to break a mesh is found, by the finding that is meant for it.

use super::scene::{Mesh, SOUTH_UP, Scene, TURNED};
use crate::verify::Verdict;
use crate::verify::grid::orientation;

fn spoilt(spoil: impl FnOnce(&mut Scene)) -> Verdict {
    let mut scene = Scene::flat();
    spoil(&mut scene);
    let verdict = scene.judge(0.0).unwrap();
    assert!(!verdict.passes(), "{verdict}");
    assert!(verdict.to_string().contains("FAIL"));
    verdict
}

fn double_area(mesh: &Mesh, face: usize) -> i128 {
    let [a, b, c] = mesh.faces[face].map(|v| mesh.places[v as usize]);
    orientation(a, b, c).abs()
}

#[test]
fn a_whole_mesh_passes_whichever_way_the_map_lies() {
    for transform in [Scene::flat().transform, SOUTH_UP, TURNED] {
        let verdict = Scene { transform, ..Scene::flat() }.judge(0.0).unwrap();
        assert!(verdict.passes(), "{verdict}");
        assert_eq!((verdict.samples, verdict.vertices, verdict.triangles), (63, 10, 12));
        assert_eq!((verdict.worst.unwrap().error, verdict.rms_error), (0.0, 0.0));
    }
}

#[test]
fn a_dropped_triangle_leaves_samples_bare_and_edges_unmatched() {
    let verdict = spoilt(|s| {
        s.mesh.faces.remove(4);
    });
    assert!(verdict.uncovered.count > 0 && verdict.unmatched_edges.count > 0);
    assert!(verdict.double_area < verdict.expected_double_area);
}

#[test]
fn a_dropped_triangle_at_the_rim_leaves_gaps() {
    let verdict = spoilt(|s| {
        let on_first_row = |v: &&u64| s.mesh.places[**v as usize].1 == 0;
        let at = s.mesh.faces.iter().position(|f| f.iter().filter(on_first_row).count() == 2).unwrap();
        s.mesh.faces.remove(at);
    });
    // The side of every cell that the triangle had on the rim.
    assert_eq!(verdict.boundary_gaps.count, 4);
}

#[test]
fn a_dropped_triangle_without_samples_is_missed_all_the_same() {
    let mut area = 0;
    let verdict = spoilt(|s| {
        s.mesh.insert((13, 5), 0.0);
        s.mesh.insert((14, 5), 0.0);
        s.mesh.insert((14, 6), 0.0);
        let smallest = (0..s.mesh.faces.len()).min_by_key(|&f| double_area(&s.mesh, f)).unwrap();
        area = double_area(&s.mesh, smallest);
        s.mesh.faces.remove(smallest);
    });
    assert_eq!((verdict.uncovered.count, verdict.unmatched_edges.count), (0, 3));
    assert_eq!(verdict.expected_double_area - verdict.double_area, area);
}

#[test]
fn a_flipped_triangle_is_clockwise_and_shares_edges_in_the_same_direction() {
    let verdict = spoilt(|s| s.mesh.faces[5].swap(0, 1));
    assert_eq!(verdict.clockwise.count, 1);
    assert_eq!(verdict.clockwise.first.unwrap().face, 5);
    assert!(verdict.same_direction_edges.count > 0);
    assert_eq!(verdict.overlapped.count, 0);
}

#[test]
fn a_vertex_moved_across_the_opposite_edge_folds_the_mesh() {
    let verdict = spoilt(|s| s.mesh.places[9] = (4, 16));
    assert!(verdict.clockwise.count > 0 && verdict.overlapped.count > 0);
    assert_eq!(verdict.unmatched_edges.count, 0);
    assert_eq!(verdict.double_area, verdict.expected_double_area);
}

#[test]
fn a_vertex_moved_off_the_lattice_is_found() {
    let scene = Scene::flat();
    let ply = scene.mesh.ply(scene.transform, (9, 7));
    let (x, _) = crate::base::GeoTransform::new(scene.transform, 9, 7).unwrap().apply(12, 8);
    let verdict = scene.judge_ply(&ply.replace(&format!("\n{x} "), &format!("\n{} ", x.next_up())), 0.0).unwrap();
    assert_eq!((verdict.off_lattice.count, verdict.off_lattice.first.unwrap().vertex), (1, 4));
    assert_eq!(verdict.failures().len(), 1, "{verdict}");
}

#[test]
fn a_vertex_outside_the_raster_is_found() {
    let verdict = spoilt(|s| s.mesh.places[2] = (36, 24));
    assert_eq!((verdict.outside.count, verdict.outside.first.unwrap().vertex), (1, 2));
    assert!(verdict.boundary_gaps.count > 0);
}

#[test]
fn a_vertex_nowhere_is_found() {
    let scene = Scene::flat();
    let ply = scene.mesh.ply(scene.transform, (9, 7));
    let line = ply.lines().nth(13).unwrap();
    for nowhere in ["nan 0 0", "0 inf 0", "1e300 1e300 0"] {
        let verdict = scene.judge_ply(&ply.replace(line, nowhere), 0.0).unwrap();
        assert_eq!(verdict.off_lattice.count, 1);
        assert!(verdict.unplaced.count > 0 && verdict.uncovered.count > 0);
    }
}

#[test]
fn a_t_junction_is_unmatched_edges() {
    // The face below the edge from vertex 0 to vertex 2 keeps the long edge, the one above gets the short ones.
    let mut scene = Scene { mesh: Mesh::rectangle(9, 7), ..Scene::flat() };
    scene.mesh.places.push((16, 12));
    scene.mesh.heights.push(0.0);
    scene.mesh.faces = vec![[0, 4, 1], [4, 2, 1], [0, 3, 2]];
    let verdict = scene.judge(0.0).unwrap();
    assert_eq!(verdict.unmatched_edges.count, 3);
    assert_eq!(verdict.failures().len(), 1, "{verdict}");
}

#[test]
fn a_duplicated_vertex_tears_the_mesh() {
    let verdict = spoilt(|s| {
        let face = s.mesh.faces.iter().position(|f| f.contains(&4)).unwrap();
        let corner = s.mesh.faces[face].iter().position(|&v| v == 4).unwrap();
        s.mesh.faces[face][corner] = s.mesh.places.len() as u64;
        s.mesh.places.push(s.mesh.places[4]);
        s.mesh.heights.push(0.0);
    });
    assert_eq!((verdict.duplicate_vertices.count, verdict.duplicate_vertices.first.unwrap().vertex), (1, 10));
    assert_eq!(verdict.unmatched_edges.count, 4);
    assert_eq!((verdict.uncovered.count, verdict.overlapped.count, verdict.unused_vertices.count), (0, 0, 0));
}

#[test]
fn an_unused_vertex_is_found_wherever_it_stands() {
    for at in [0, 4, 10] {
        let verdict = spoilt(|s| {
            s.mesh.faces.iter_mut().flatten().filter(|v| **v >= at).for_each(|v| *v += 1);
            s.mesh.places.insert(at as usize, (4, 4));
            s.mesh.heights.insert(at as usize, 0.0);
        });
        assert_eq!((verdict.unused_vertices.count, verdict.unused_vertices.first.unwrap().vertex), (1, at));
        assert_eq!(verdict.failures().len(), 1, "{verdict}");
    }
}

#[test]
fn a_triangle_written_twice_overlaps() {
    let verdict = spoilt(|s| {
        let largest = (0..s.mesh.faces.len()).max_by_key(|&f| double_area(&s.mesh, f)).unwrap();
        s.mesh.faces.push(s.mesh.faces[largest]);
    });
    assert!(verdict.overlapped.count > 0 && verdict.overused_edges.count > 0);
}

#[test]
fn a_second_mesh_over_the_first_doubles_the_rim() {
    let verdict = spoilt(|s| {
        let other = Mesh::rectangle(9, 7);
        let base = s.mesh.places.len() as u64;
        s.mesh.faces.extend(other.faces.iter().map(|f| f.map(|v| v + base)));
        s.mesh.places.extend(other.places);
        s.mesh.heights.extend(other.heights);
    });
    // All but the 28 on the rim, and the one that is a vertex of one mesh and lies on an edge of the other.
    assert_eq!(verdict.overlapped.count, 63 - 28 - 1);
    assert!(verdict.boundary_doubled.count == 28 && verdict.duplicate_vertices.count == 4);
    assert_eq!(verdict.double_area, 2 * verdict.expected_double_area);
}

#[test]
fn degenerate_triangles_are_found() {
    let verdict = spoilt(|s| s.mesh.faces.extend([[0, 0, 1], [0, 9, 2], [3, 3, 3]]));
    assert_eq!((verdict.degenerate.count, verdict.degenerate.first.unwrap().face), (3, 12));
}

#[test]
fn heights_that_are_no_numbers_are_failures() {
    for height in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let verdict = spoilt(|s| s.mesh.heights[4] = height);
        assert_eq!((verdict.heights_not_finite.count, verdict.heights_not_finite.first.unwrap().vertex), (1, 4));
        assert!(verdict.above_tolerance.count > 0 && verdict.uncovered.count == 0);
        assert_eq!(verdict.rms_error, 0.0);
    }
}

#[test]
fn an_empty_mesh_covers_nothing() {
    let verdict = spoilt(|s| s.mesh = Mesh::default());
    assert_eq!(verdict.uncovered.count, 63);
    assert_eq!((verdict.boundary_gaps.count, verdict.worst), (28, None));
}

#[test]
fn an_exact_tie_passes_and_one_ulp_more_fails() {
    for tolerance in [0.1, 1.0, 1e-300, 12345.678] {
        let mut scene = Scene::flat();
        scene.samples[9 * 2 + 3] = tolerance;
        let verdict = scene.judge(tolerance).unwrap();
        assert!(verdict.passes(), "{verdict}");
        assert_eq!(verdict.worst.unwrap().error, tolerance);
        scene.samples[9 * 2 + 3] = tolerance.next_up();
        let verdict = scene.judge(tolerance).unwrap();
        let first = verdict.above_tolerance.first.unwrap();
        assert_eq!((verdict.above_tolerance.count, first.column, first.row), (1, 3, 2));
        assert!(verdict.worst.unwrap().error > tolerance);
    }
}

#[test]
fn a_tie_that_rounding_would_miss_is_settled_exactly() {
    // One triangle of heights 0, 0 and 1e16 + 2: the surface is a third of it at a sample, no double is.
    let mut scene = Scene { width: 4, height: 2, samples: vec![0.0; 8], ..Scene::flat() };
    scene.mesh = Mesh::rectangle(4, 2);
    scene.mesh.heights[1] = 10.0;
    scene.samples[1..4].copy_from_slice(&[10.0 / 3.0, 20.0 / 3.0, 10.0]);
    assert_eq!(scene.judge(0.0).unwrap().above_tolerance.count, 2);
    let ulp = (20.0f64 / 3.0).next_up() - 20.0 / 3.0;
    let verdict = scene.judge(ulp).unwrap();
    assert!(verdict.passes() && verdict.worst.unwrap().error <= ulp, "{verdict}");
}
