//! What every engine is held to: one suite, run by each of them.
//!
//! [`conformance!`] makes the tests of one engine. They judge by brute force ([`check`]), on small tiles of all kinds and
//! on domains with pinches and holes.

use std::collections::HashMap;

use proptest::prelude::*;

use super::{Engine, EngineScratch, Feasibility, Task};
use crate::base::control::CancelToken;
use crate::base::exact;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::{Domain, TileMesh, Vertex};
use crate::base::tiling::TilePlace;
use crate::base::{Heights, Tile};
use crate::kernel::seam::{MinLink, Rim};

/// Makes the tests of an engine, given as an expression, in a module of this name.
macro_rules! conformance {
    ($name:ident, $engine:expr) => {
        mod $name {
            use proptest::prelude::*;

            use super::*;
            use crate::kernel::triangulate::conformance;

            proptest! {
                #![proptest_config(ProptestConfig::with_cases(200))]

                #[test]
                fn every_tile_is_covered_within_the_tolerance(
                    size in (2usize..30, 2usize..30), seed in any::<u64>(), kind in 0u8..4,
                    tolerance in conformance::tolerances(), strong in any::<bool>(),
                ) {
                    conformance::covers(&$engine, size, seed, kind, tolerance, strong, &[]);
                }

                /// On sides and at corners by every engine, inside by those that can.
                #[test]
                fn points_are_vertices(
                    size in (2usize..30, 2usize..30), seed in any::<u64>(), kind in 0u8..4,
                    tolerance in conformance::tolerances(), strong in any::<bool>(),
                    points in prop::collection::vec((0usize..30, 0usize..30), 0..20),
                ) {
                    conformance::covers(&$engine, size, seed, kind, tolerance, strong, &points);
                }
            }

            #[test]
            fn a_pinch_is_one_vertex_with_two_wedges() {
                conformance::pinch(&$engine);
            }

            #[test]
            fn a_hole_stays_empty() {
                conformance::holes(&$engine);
            }
        }
    };
}
pub(crate) use conformance;

pub(crate) fn triangulate(
    engine: &dyn Engine,
    tile: &Tile,
    domain: &Domain,
    tolerance: f64,
    feasibility: Feasibility,
) -> TileMesh {
    let mut mesh = TileMesh::default();
    let task = Task { tile, domain, tolerance, feasibility, max_stray: f64::INFINITY, cancel: &CancelToken::default() };
    let mut scratch = EngineScratch::default();
    engine.triangulate(&task, &mut scratch, &mut mesh).expect("nobody cancels");
    // Memory that has been used makes no difference.
    let mut again = TileMesh::default();
    engine.triangulate(&task, &mut scratch, &mut again).expect("nobody cancels");
    assert!(mesh == again, "the same task gives the same mesh");
    mesh
}

/// Everything a tile mesh must be, by brute force; every sample is held to its limit.
pub(crate) fn check(tile: &Tile, domain: &Domain, mesh: &TileMesh, tolerance: f64) {
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
                    let limit = tile.limit(column, row, tolerance);
                    assert!(exact::within(&terms, o, limit), "sample {column}, {row}");
                }
            }
        }
    }
    let fixed: Vec<Vertex> = domain.fixed().collect();
    assert_eq!(mesh.vertices[..fixed.len()], fixed, "the loops' vertices and the points come first");
    let mut used: Vec<u32> = mesh.triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    assert_eq!(used.len(), mesh.vertices.len(), "every vertex is in a triangle");
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

pub(crate) fn tile(width: usize, height: usize, seed: u64, kind: u8) -> Tile {
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

pub(crate) fn tolerances() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(0.25), Just(1.0), Just(2.0), Just(5.0), 0.0f64..4.0]
}

/// The rim that a tile of its own has.
pub(crate) fn rim(tile: &Tile, tolerance: f64) -> Rim {
    let cancel = CancelToken::default();
    Rim::new(tile, tolerance, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
        .expect("nobody cancels")
}

pub(crate) fn covers(
    engine: &dyn Engine,
    (width, height): (usize, usize),
    seed: u64,
    kind: u8,
    tolerance: f64,
    strong: bool,
    points: &[(usize, usize)],
) {
    let tile = tile(width, height, seed, kind);
    let mut points: Vec<_> = points.iter().map(|&(column, row)| (row % height, column % width)).collect();
    points.sort_unstable();
    points.dedup();
    let on_rim = |&(row, column): &_| row == 0 || row + 1 == height || column == 0 || column + 1 == width;
    points.retain(|point| engine.capabilities().points || on_rim(point));
    let points: Vec<_> = points.into_iter().map(|(row, column)| (column, row)).collect();
    let (cancel, mut min_link) = (CancelToken::default(), MinLink::default());
    let rim =
        Rim::new(&tile, tolerance, &points, &TilePlace::alone(tile.width(), tile.height()), &mut min_link, &cancel)
            .expect("nobody cancels");
    let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
    let mesh = triangulate(engine, &tile, &rim.domain, tolerance, feasibility);
    check(&tile, &rim.domain, &mesh, tolerance);
    if !strong {
        assert_eq!(mesh.relaxed, 0);
    }
    for (column, row) in points {
        let at = Point::of_sample(column as i32, row as i32);
        assert!(mesh.vertices.iter().any(|v| v.at == at), "point {column}, {row}");
    }
}

pub(crate) type Place = (i32, i32);

/// The rim of a square of samples, from its low corner on, ground inside.
pub(crate) fn ring(low: Place, size: i32) -> Vec<Place> {
    let (c, r) = low;
    let mut places: Vec<Place> = (0..size).map(|i| (c + i, r)).collect();
    places.extend((0..size).map(|i| (c + size, r + i)));
    places.extend((0..size).map(|i| (c + size - i, r + size)));
    places.extend((0..size).map(|i| (c, r + size - i)));
    places
}

/// A domain from loops of samples; loops through one place share its vertex.
pub(crate) fn domain(tile: &Tile, loops: &[Vec<Place>]) -> Domain {
    let mut places: Vec<Place> = loops.concat();
    places.sort_unstable();
    places.dedup();
    let vertex = |&(c, r): &Place| Vertex { at: Point::of_sample(c, r), height: tile.at(c as usize, r as usize) };
    let index = |place: &Place| places.binary_search(place).expect("listed") as u32;
    Domain {
        vertices: places.iter().map(vertex).collect(),
        loops: loops.iter().map(|l| l.iter().map(index).collect()).collect(),
        ..Domain::default()
    }
}

fn check_all(engine: &dyn Engine, tile: &Tile, domain: &Domain) {
    for tolerance in [0.0, 1.0, 3.0, 9.0] {
        for feasibility in [Feasibility::Weak, Feasibility::Strong] {
            check(tile, domain, &triangulate(engine, tile, domain, tolerance, feasibility), tolerance);
        }
    }
}

/// Two squares that share a corner.
pub(crate) fn pinch(engine: &dyn Engine) {
    let tile = tile(9, 9, 5, 0);
    let domain = domain(&tile, &[ring((0, 0), 4), ring((4, 4), 4)]);
    assert_eq!(domain.vertices.len(), 31);
    check_all(engine, &tile, &domain);
}

/// One walk from two that share one place, with the ground between them on its left: a figure of eight.
fn joined(a: Vec<Place>, b: &[Place]) -> Vec<Place> {
    let (i, j) = (0..a.len()).find_map(|i| b.iter().position(|&p| p == a[i]).map(|j| (i, j))).expect("a shared place");
    let around_b = b[j..].iter().chain(&b[..j]);
    a[..i].iter().chain(around_b).chain(&a[i..]).copied().collect()
}

/// The rim of a hole.
pub(crate) fn hole(low: Place, size: i32) -> Vec<Place> {
    ring(low, size).into_iter().rev().collect()
}

/// Loops of grounds of 11 × 11 cells in which holes touch one another at a place.
pub(crate) fn holes_that_touch() -> [Vec<Vec<Place>>; 2] {
    [
        vec![ring((0, 0), 11), joined(hole((3, 3), 3), &hole((6, 6), 1))],
        vec![ring((0, 0), 11), joined(hole((5, 5), 2), &hole((7, 3), 2)), hole((2, 8), 1)],
    ]
}

/// A square hole, and holes that touch one another.
pub(crate) fn holes(engine: &dyn Engine) {
    let tile = tile(14, 12, 77, 0);
    let one = domain(&tile, &[ring((0, 0), 11), hole((4, 4), 3)]);
    assert_eq!(one.area(), 32 * (121 - 9));
    check_all(engine, &tile, &one);
    // On flat ground nothing but the holes stands against large triangles.
    let flat = Tile::from_heights(14, 12, Heights::F32(vec![0.0; 14 * 12]));
    // Wherever its loop begins: a triangle around a hole may have its apex there.
    let mut around = vec![(4, 4), (4, 5), (5, 5), (5, 4)];
    for _ in 0..4 {
        around.rotate_left(1);
        check_all(engine, &flat, &domain(&flat, &[ring((0, 0), 11), around.clone()]));
        let corners = vec![(0, 0), (11, 0), (11, 11), (0, 11)];
        check_all(engine, &flat, &domain(&flat, &[corners, around.clone()]));
    }
    for loops in &holes_that_touch() {
        check_all(engine, &tile, &domain(&tile, loops));
        check_all(engine, &flat, &domain(&flat, loops));
    }
}
