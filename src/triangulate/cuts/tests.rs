use std::collections::HashMap;

use proptest::prelude::*;

use super::*;
use crate::control::CancelToken;
use crate::exact;
use crate::field::{Heights, Tile};
use crate::lattice::{Point, orient};
use crate::mesh::{Domain, Vertex};
use crate::seam::{MinLink, Rim};

const ENGINES: [GreedyCuts; 2] = [GreedyCuts::PLAIN, GreedyCuts::IMPROVED];

fn triangulate(engine: GreedyCuts, tile: &Tile, domain: &Domain, tolerance: f64, feasibility: Feasibility) -> TileMesh {
    let mut mesh = TileMesh::default();
    let task = Task { tile, domain, tolerance, feasibility, cancel: &CancelToken::default() };
    engine.triangulate(&task, &mut Scratch::default(), &mut mesh).expect("nobody cancels");
    mesh
}

/// Everything a tile mesh must be, by brute force.
fn check(tile: &Tile, domain: &Domain, mesh: &TileMesh, tolerance: f64) {
    let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
    let mut area = 0i128;
    for &t in &mesh.triangles {
        let [a, b, c] = mesh.corners(t);
        let o = orient(a.at, b.at, c.at);
        assert!(o > 0, "orientation {o}");
        area += i128::from(o);
        for i in 0..3 {
            *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
        }
        for row in 0..tile.height() {
            for column in 0..tile.width() {
                let p = Point::of_sample(column as i32, row as i32);
                let w = [orient(b.at, c.at, p), orient(c.at, a.at, p), orient(a.at, b.at, p)];
                if w.iter().all(|&w| w >= 0) {
                    let terms = [(w[0], a.height), (w[1], b.height), (w[2], c.height), (-o, tile.at(column, row))];
                    assert!(exact::within(&terms, o, tolerance), "sample {column}, {row}");
                }
            }
        }
    }
    assert_eq!(area, domain.area(), "the triangles cover the ground once");
    for l in &domain.loops {
        for i in 0..l.len() {
            let edge = (l[i], l[(i + 1) % l.len()]);
            assert_eq!(edges.remove(&edge), Some(1), "rim edge {edge:?}");
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!((count, edges.get(&(b, a))), (1, Some(&1)), "edge {a} {b}");
    }
    let mut places: Vec<Point> = mesh.vertices.iter().map(|v| v.at).collect();
    places.sort();
    places.dedup();
    assert_eq!(places.len(), mesh.vertices.len(), "no two vertices at one place");
}

fn tile(width: usize, height: usize, seed: u64, kind: u8) -> Tile {
    let noise = |i: usize| {
        let v = (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (v >> 40) as f64 / f64::from(1u32 << 24)
    };
    let wave = |i: usize| {
        let (c, r) = ((i % width) as f64, (i / width) as f64);
        (c * 3.0 - r) * 0.1 + (c - 7.0) * (r - 5.0) * 0.05
    };
    let n = width * height;
    Tile::from_heights(
        width,
        height,
        match kind {
            0 => Heights::F32((0..n).map(|i| (noise(i) * 8.0).floor() as f32).collect()),
            1 => Heights::F64((0..n).map(|i| wave(i) + noise(i) * 0.3).collect()),
            2 => Heights::F32((0..n).map(|i| wave(i).round() as f32).collect()),
            _ => Heights::F32(vec![-3.0; n]),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_tile_is_covered_within_the_tolerance(
        width in 2usize..30, height in 2usize..30, seed in any::<u64>(), kind in 0u8..4,
        tolerance in prop_oneof![Just(0.0), Just(0.25), Just(1.0), Just(2.0), Just(5.0), 0.0f64..4.0],
        strong in any::<bool>(), engine in prop::sample::select(&ENGINES[..]),
    ) {
        let tile = tile(width, height, seed, kind);
        let cancel = CancelToken::default();
        let rim = Rim::new(&tile, tolerance, (true, true), &mut MinLink::default(), &cancel).expect("nobody cancels");
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let mesh = triangulate(engine, &tile, &rim.domain, tolerance, feasibility);
        check(&tile, &rim.domain, &mesh, tolerance);
        if !strong {
            prop_assert_eq!(mesh.relaxed, 0);
        }
    }
}

type Place = (i32, i32);

/// The rim of a square of samples, from its low corner on, ground inside.
fn ring(low: Place, size: i32) -> Vec<Place> {
    let (c, r) = low;
    let mut places: Vec<Place> = (0..size).map(|i| (c + i, r)).collect();
    places.extend((0..size).map(|i| (c + size, r + i)));
    places.extend((0..size).map(|i| (c + size - i, r + size)));
    places.extend((0..size).map(|i| (c, r + size - i)));
    places
}

/// A domain from loops of samples; loops through one place share its vertex.
fn domain(tile: &Tile, loops: &[Vec<Place>]) -> Domain {
    let mut places: Vec<Place> = loops.concat();
    places.sort_unstable();
    places.dedup();
    let vertex = |&(c, r): &Place| Vertex { at: Point::of_sample(c, r), height: tile.at(c as usize, r as usize) };
    let index = |place: &Place| places.binary_search(place).expect("listed") as u32;
    Domain {
        vertices: places.iter().map(vertex).collect(),
        loops: loops.iter().map(|l| l.iter().map(index).collect()).collect(),
    }
}

fn check_all(tile: &Tile, domain: &Domain) {
    for tolerance in [0.0, 1.0, 3.0, 9.0] {
        for feasibility in [Feasibility::Weak, Feasibility::Strong] {
            for engine in ENGINES {
                check(tile, domain, &triangulate(engine, tile, domain, tolerance, feasibility), tolerance);
            }
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

/// One walk from two that share one place, with the ground between them on its left: a figure of eight.
fn joined(a: Vec<Place>, b: &[Place]) -> Vec<Place> {
    let (i, j) = (0..a.len()).find_map(|i| b.iter().position(|&p| p == a[i]).map(|j| (i, j))).expect("a shared place");
    let around_b = b[j..].iter().chain(&b[..j]);
    a[..i].iter().chain(around_b).chain(&a[i..]).copied().collect()
}

#[test]
fn a_hole_stays_empty() {
    let hole = |low, size| ring(low, size).into_iter().rev().collect::<Vec<_>>();
    let tile = tile(14, 12, 77, 0);
    let one = domain(&tile, &[ring((0, 0), 11), hole((4, 4), 3)]);
    assert_eq!(one.area(), 32 * (121 - 9));
    check_all(&tile, &one);
    let touching = [
        vec![ring((0, 0), 11), joined(hole((3, 3), 3), &hole((6, 6), 1))],
        vec![ring((0, 0), 11), joined(hole((5, 5), 2), &hole((7, 3), 2)), hole((2, 8), 1)],
    ];
    // On flat ground nothing but the holes stands against large triangles.
    let flat = Tile::from_heights(14, 12, Heights::F32(vec![0.0; 14 * 12]));
    for loops in &touching {
        check_all(&tile, &domain(&tile, loops));
        check_all(&flat, &domain(&flat, loops));
    }
}

/// Sweeps are what the improved order spends its time on. (That no edge is swept twice is asserted where they are made.)
#[test]
fn every_edge_is_swept_at_most_once() {
    for kind in 0..3 {
        let tile = tile(90, 80, 11, kind);
        let cancel = CancelToken::default();
        let rim = Rim::new(&tile, 1.0, (true, true), &mut MinLink::default(), &cancel).expect("nobody cancels");
        for feasibility in [Feasibility::Weak, Feasibility::Strong] {
            let (mut mesh, mut scratch) = (TileMesh::default(), Scratch::default());
            let task = Task { tile: &tile, domain: &rim.domain, tolerance: 1.0, feasibility, cancel: &cancel };
            GreedyCuts::IMPROVED.triangulate(&task, &mut scratch, &mut mesh).expect("nobody cancels");
            let swept = scratch.improved.seen.len();
            assert!(swept > 0 && swept < 3 * mesh.triangles.len(), "{swept} of {}", mesh.triangles.len());
        }
    }
}
