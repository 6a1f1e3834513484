//! Meshes that others have begun: what becomes of those that get further vertices, or whose vertices are moved.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::*;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;

/// A square of 100 steps.
fn square() -> Domain {
    let corners = [(0, 0), (100, 0), (100, 100), (0, 100)];
    Domain { vertices: corners.map(vertex).to_vec(), loops: vec![vec![0, 1, 2, 3]], ..Domain::default() }
}

fn vertex((x, y): (i32, i32)) -> Vertex {
    Vertex { at: Point { x, y }, height: 0.0 }
}

fn areas(mesh: &TileMesh) -> Vec<i64> {
    let area = |&t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(t).map(|v| v.at);
        orient(a, b, c)
    };
    mesh.triangles.iter().map(area).collect()
}

/// Every triangle faces up, and together they are the square.
fn covers(mesh: &TileMesh) -> bool {
    let areas = areas(mesh);
    areas.iter().all(|area| *area > 0) && areas.iter().sum::<i64>() == 20_000
}

fn started(places: &[(i32, i32)], scratch: &mut Scratch) -> TileMesh {
    let mut mesh = TileMesh::default();
    delaunay(&square(), places.iter().map(|&place| vertex(place)), scratch, &mut mesh);
    mesh
}

/// Triangles as places, wherever they begin.
fn faces(mesh: &TileMesh) -> BTreeSet<[Point; 3]> {
    let face = |&t: &[u32; 3]| {
        let [a, b, c] = mesh.corners(t).map(|v| v.at);
        [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().expect("three")
    };
    mesh.triangles.iter().map(face).collect()
}

proptest! {
    #[test]
    fn inserted_vertices_leave_what_is_not_theirs(
        first in prop::collection::vec((1i32..100, 1i32..100), 0..30),
        more in prop::collection::vec((0i32..=100, 0i32..=100), 1..12),
        turns in any::<u64>(),
    ) {
        let mut scratch = Scratch::default();
        let mesh = started(&first, &mut scratch);
        // Delaunay stays Delaunay.
        let mut all = mesh.clone();
        let locked = || more.iter().map(|&place| vertex(place));
        insert(locked(), Rim::Locked, is_not_delaunay, &mut scratch, &mut all);
        prop_assert!(covers(&all));
        prop_assert_eq!(&all.vertices[..mesh.vertices.len()], &mesh.vertices[..]);
        let rim = |p: Point| [p.x, p.y].iter().any(|x| [0, 100].contains(x));
        prop_assert!(all.vertices[mesh.vertices.len()..].iter().all(|v| !rim(v.at)));
        for &t in &all.triangles {
            let [a, b, c] = all.corners(t).map(|v| v.at);
            prop_assert!(all.vertices.iter().all(|v| !in_circle(a, b, c, v.at)));
        }
        // Whatever is turned: triangles without a new vertex are old ones, and each place has its vertex.
        let mut state = turns;
        let at_random = |_: [Vertex; 4]| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            state >> 63 == 1
        };
        let mut any = mesh.clone();
        insert(locked(), Rim::Free, at_random, &mut scratch, &mut any);
        prop_assert!(covers(&any));
        let places: BTreeSet<Point> = any.vertices.iter().map(|v| v.at).collect();
        let wanted: BTreeSet<Point> = mesh.vertices.iter().map(|v| v.at).chain(locked().map(|v| v.at)).collect();
        prop_assert_eq!(&places, &wanted);
        prop_assert_eq!(places.len(), any.vertices.len());
        let old: BTreeSet<Point> = mesh.vertices.iter().map(|v| v.at).collect();
        let mut kept = faces(&any).into_iter().filter(|face| face.iter().all(|p| old.contains(p)));
        let before = faces(&mesh);
        prop_assert!(kept.all(|face| before.contains(&face)));
    }

    #[test]
    fn moved_vertices_are_put_right_or_it_is_said(
        places in prop::collection::vec(((2i32..99, 2i32..99), (-2i32..=2, -2i32..=2)), 1..60),
    ) {
        let mut scratch = Scratch::default();
        let mut mesh = started(&places.iter().map(|(place, _)| *place).collect::<Vec<_>>(), &mut scratch);
        for v in &mut mesh.vertices[4..] {
            let (_, by) = places.iter().find(|(place, _)| vertex(*place).at == v.at).expect("one of them");
            v.at = Point { x: (v.at.x + by.0).clamp(1, 99), y: (v.at.y + by.1).clamp(1, 99) };
        }
        let before = areas(&mesh);
        let moved = mesh.clone();
        let is_straight = untangle(&mut scratch, &mut mesh);
        prop_assert_eq!(is_straight, covers(&mesh));
        prop_assert_eq!(&moved.vertices, &mesh.vertices);
        let wrong = |areas: &[i64]| areas.iter().filter(|area| **area <= 0).count();
        prop_assert!(wrong(&areas(&mesh)) <= wrong(&before));
        if wrong(&before) == 0 {
            prop_assert_eq!(&moved, &mesh);
        }
    }
}

/// A vertex that has been moved over the edge beyond it: the edge is turned.
#[test]
fn a_triangle_that_is_turned_over_is_put_right() {
    let mut scratch = Scratch::default();
    let mut mesh = started(&[(50, 40), (50, 60)], &mut scratch);
    mesh.vertices[4].at = Point { x: 50, y: 40 };
    let face = areas(&mesh);
    let across = mesh.triangles.iter().position(|t| t.contains(&4) && !t.contains(&5)).expect("a triangle");
    assert!(face[across] > 0);
    // Beside the other, beyond the edge from there to a corner.
    mesh.vertices[4].at = Point { x: 40, y: 62 };
    assert!(!covers(&mesh));
    assert!(untangle(&mut scratch, &mut mesh) && covers(&mesh));
}
