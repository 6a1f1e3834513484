use proptest::prelude::*;

use super::*;
use crate::control::CancelToken;
use crate::field::{Heights, Tile};
use crate::mesh::Domain;
use crate::seam::{MinLink, Rim};
use crate::triangulate::conformance::{check, domain, hole, holes_that_touch, ring, tile};

fn triangulate(tile: &Tile, domain: &Domain, tolerance: f64, feasibility: Feasibility) -> TileMesh {
    let mut mesh = TileMesh::default();
    let task = Task { tile, domain, tolerance, feasibility, cancel: &CancelToken::default() };
    GreedyCuts.triangulate(&task, &mut Scratch::default(), &mut mesh).expect("nobody cancels");
    mesh
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_tile_is_covered_within_the_tolerance(
        width in 2usize..30, height in 2usize..30, seed in any::<u64>(), kind in 0u8..4,
        tolerance in prop_oneof![Just(0.0), Just(0.25), Just(1.0), Just(2.0), Just(5.0), 0.0f64..4.0],
        strong in any::<bool>(),
    ) {
        let tile = tile(width, height, seed, kind);
        let cancel = CancelToken::default();
        let rim = Rim::new(&tile, tolerance, (true, true), &mut MinLink::default(), &cancel).expect("nobody cancels");
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let mesh = triangulate(&tile, &rim.domain, tolerance, feasibility);
        check(&tile, &rim.domain, &mesh, tolerance);
        if !strong {
            prop_assert_eq!(mesh.relaxed, 0);
        }
    }
}

fn check_all(tile: &Tile, domain: &Domain) {
    for tolerance in [0.0, 1.0, 3.0, 9.0] {
        for feasibility in [Feasibility::Weak, Feasibility::Strong] {
            check(tile, domain, &triangulate(tile, domain, tolerance, feasibility), tolerance);
        }
    }
}

#[test]
fn a_pinch_is_two_nodes_at_one_vertex() {
    let tile = tile(9, 9, 5, 0);
    let domain = domain(&tile, &[ring((0, 0), 4), ring((4, 4), 4)]);
    assert_eq!(domain.vertices.len(), 31);
    check_all(&tile, &domain);
}

#[test]
fn a_hole_stays_empty() {
    let tile = tile(14, 12, 77, 0);
    let one = domain(&tile, &[ring((0, 0), 11), hole((4, 4), 3)]);
    assert_eq!(one.area(), 32 * (121 - 9));
    check_all(&tile, &one);
    // On flat ground nothing but the holes stands against large triangles.
    let flat = Tile::from_heights(14, 12, Heights::F32(vec![0.0; 14 * 12]));
    for loops in &holes_that_touch() {
        check_all(&tile, &domain(&tile, loops));
        check_all(&flat, &domain(&flat, loops));
    }
}
