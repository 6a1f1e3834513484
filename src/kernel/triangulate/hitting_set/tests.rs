//! The engine of hitting sets: the suite of all engines, partitions and literal stitching by brute force.

use std::collections::HashMap;

use proptest::prelude::*;

use super::*;
use crate::base::Tile;
use crate::base::control::CancelToken;
use crate::base::mesh::Domain;
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::conformance::{check, conformance, rim, tile, tolerances, triangulate};

fn variant(squares: Squares, corners: Corners, stitching: Stitching) -> HittingSet {
    HittingSet { options: HittingSetOptions { squares, corners, stitching } }
}

conformance!(merged, HittingSet::default());
conformance!(free_corners, variant(Squares::Nested, Corners::Free, Stitching::Shared));
conformance!(sliding_squares, variant(Squares::Sliding, Corners::Samples, Stitching::Shared));

/// In how many squares each sample is.
fn counts(tile: &Tile, squares: &[Square]) -> Vec<usize> {
    let mut counts = vec![0; tile.width() * tile.height()];
    for Square { first, last, .. } in squares {
        (first.1..=last.1).for_each(|row| (first.0..=last.0).for_each(|c| counts[row * tile.width() + c] += 1));
    }
    counts
}

/// Whether every sample of a square is within the tolerance of its two triangles, in doubles with a little to spare.
fn holds(tile: &Tile, square: &Square, tolerance: f64) -> bool {
    let (first, last) = (square.first, square.last);
    let (width, height) = ((last.0 - first.0) as f64, (last.1 - first.1) as f64);
    let [a, b, c, d] = square.heights;
    let at = |x: f64, y: f64| match square.falling {
        true if x >= y => a + x * (b - a) + y * (c - b),
        true => a + y * (d - a) + x * (c - d),
        false if x + y <= 1.0 => a + x * (b - a) + y * (d - a),
        false => c + (1.0 - x) * (d - c) + (1.0 - y) * (b - c),
    };
    let share = |i: usize, len: f64| if len > 0.0 { i as f64 / len } else { 0.0 };
    (first.1..=last.1).all(|row| {
        (first.0..=last.0).all(|column| {
            let surface = at(share(column - first.0, width), share(row - first.1, height));
            (surface - tile.at(column, row)).abs() <= tolerance + 1e-9
        })
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn squares_hold_all_samples(
        size in (2usize..40, 2usize..40), seed in any::<u64>(), kind in 0u8..4, tolerance in tolerances(), free in any::<bool>(),
    ) {
        let tile = tile(size.0, size.1, seed, kind);
        let corners = if free { Corners::Free } else { Corners::Samples };
        let cancel = CancelToken::default();
        let nested = partition(&tile, tolerance, Squares::Nested, corners, &cancel).expect("nobody cancels");
        prop_assert!(counts(&tile, &nested.squares).iter().all(|&count| count == 1));
        prop_assert!(nested.squares.iter().all(|square| holds(&tile, square, tolerance)));
        let sliding = partition(&tile, tolerance, Squares::Sliding, corners, &cancel).expect("nobody cancels");
        prop_assert!(counts(&tile, &sliding.squares).iter().all(|&count| count >= 1));
        prop_assert!(sliding.squares.iter().all(|square| holds(&tile, square, tolerance)));
        prop_assert!(nested.counts.undecided == 0 || !free || kind != 3, "flat ground is within anything");
    }

    /// Both readings cover the tile with triangles within the tolerance; the disjoint one needs no repair.
    #[test]
    fn literal_stitching_is_within_the_tolerance(
        size in (2usize..24, 2usize..24), seed in any::<u64>(), kind in 0u8..4, tolerance in tolerances(), free in any::<bool>(),
    ) {
        let tile = tile(size.0, size.1, seed, kind);
        let corners = if free { Corners::Free } else { Corners::Samples };
        for reading in [Reading::Disjoint, Reading::Shared] {
            let literal = stitch_literally(&tile, tolerance, reading, corners, &CancelToken::default()).expect("nobody cancels");
            prop_assert!(reading == Reading::Shared || literal.failing == 0);
            prop_assert!(literal.failing > 0 || literal.before_repair == literal.mesh.triangles.len());
            check(&tile, &around(&literal.mesh), &literal.mesh, tolerance);
            let (right, bottom) = (tile.width() as i64 - 1, tile.height() as i64 - 1);
            prop_assert_eq!(around(&literal.mesh).area(), i128::from(2 * 16 * right * bottom));
        }
    }
}

/// Reweighting covers a tile with few of the largest valid squares, in as few iterations as its lemma says.
#[test]
fn reweighting_covers_a_tile() {
    let tile = tile(40, 30, 3, 2);
    let cancel = CancelToken::default();
    let squares = LargestSquares::new(&tile, 2.0, Corners::Free, &cancel).expect("nobody cancels");
    let found = reweighting::hitting_set(&squares, 1).expect("every sample has its square");
    let chosen: Vec<Square> = found.chosen.iter().map(|&element| *squares.square(element)).collect();
    assert!(counts(&tile, &chosen).iter().all(|&count| count > 0));
    let greedy = partition(&tile, 2.0, Squares::Sliding, Corners::Free, &cancel).expect("nobody cancels");
    // With c as large as the least cover, which is no larger than the greedy one, the iterations of the lemma are enough.
    assert!(found.believed < 2 * greedy.squares.len(), "{found:?} for {}", greedy.squares.len());
    assert!(chosen.len() <= 3 * greedy.squares.len(), "{} for {}", chosen.len(), greedy.squares.len());
}

/// A mesh's rim as a domain that has all of its vertices.
fn around(mesh: &TileMesh) -> Domain {
    let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let mut next: HashMap<u32, u32> = HashMap::new();
    let all: std::collections::HashSet<(u32, u32)> = sides.collect();
    all.iter().filter(|(a, b)| !all.contains(&(*b, *a))).for_each(|&(a, b)| assert_eq!(next.insert(a, b), None));
    let start = *next.keys().min().expect("a rim");
    let walk: Vec<u32> = std::iter::successors(Some(start), |v| Some(next[v]).filter(|&v| v != start)).collect();
    assert_eq!(walk.len(), next.len(), "one rim");
    Domain { vertices: mesh.vertices.clone(), loops: vec![walk], ..Domain::default() }
}

/// A plane is two triangles, whatever the tolerance: also where there is none.
#[test]
fn a_plane_is_two_triangles() {
    let heights = (0..33 * 17).map(|i| (i % 33) as f32 * 2.0 - (i / 33) as f32).collect();
    let tile = Tile::from_heights(33, 17, crate::base::Heights::F32(heights));
    for tolerance in [0.0, 0.5] {
        let cancel = CancelToken::default();
        let whole = partition(&tile, tolerance, Squares::Nested, Corners::Free, &cancel).expect("nobody cancels");
        assert_eq!((whole.squares.len(), whole.triangles(), whole.counts), (1, 2, Counts::default()));
        let domain = rim(&tile, tolerance).domain;
        let mesh = triangulate(&HittingSet::default(), &tile, &domain, tolerance, Feasibility::Weak);
        assert_eq!(mesh.triangles.len(), 2);
    }
}

/// Weights and missing samples: what the squares ignore or take lightly, the exact test and the loops decide.
#[test]
fn weights_are_kept() {
    let plain = tile(25, 21, 9, 1);
    let weights = (0..25 * 21).map(|i| [1.0, 0.0, 4.0, 0.25][(i / 7) % 4]).collect();
    let weighted = plain.with_weights(weights);
    for corners in [Corners::Samples, Corners::Free] {
        let engine = variant(Squares::Nested, corners, Stitching::Merged);
        let domain = rim(&weighted, 0.5).domain;
        check(&weighted, &domain, &triangulate(&engine, &weighted, &domain, 0.5, Feasibility::Weak), 0.5);
    }
}

/// Sharing corners and merging are worth what they are for: bounds that a change for the worse would break.
#[test]
fn stitching_saves_triangles() {
    let at = |i: usize| ((i % 97) as f64, (i / 97) as f64);
    let hills = |(x, y): (f64, f64)| 40.0 * ((x * 0.11).sin() + (y * 0.07).cos()) + 9.0 * ((x + 2.0 * y) * 0.2).sin();
    let heights = (0..97 * 97).map(|i| hills(at(i))).collect();
    let tile = Tile::from_heights(97, 97, crate::base::Heights::F64(heights));
    let domain = rim(&tile, 2.0).domain;
    let count = |stitching| {
        let engine = variant(Squares::Nested, Corners::Samples, stitching);
        triangulate(&engine, &tile, &domain, 2.0, Feasibility::Weak).triangles.len()
    };
    let literal = stitch_literally(&tile, 2.0, Reading::Disjoint, Corners::Free, &CancelToken::default());
    let literal = literal.expect("nobody cancels").mesh.triangles.len();
    let (shared, merged) = (count(Stitching::Shared), count(Stitching::Merged));
    assert!(2 * shared < literal && 4 * merged < literal, "{literal} literal, {shared} shared, {merged} merged");
}
