//! What every tile mesh is checked by, whoever made it, and the grounds it is tried on.

use std::collections::HashMap;

use crate::exact;
use crate::field::{Heights, Tile};
use crate::lattice::{Point, orient};
use crate::mesh::{Domain, TileMesh, Vertex};

/// Everything a tile mesh must be, by brute force.
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
    }
}

/// One walk from two that share one place, with the ground between them on its left: a figure of eight.
pub(crate) fn joined(a: Vec<Place>, b: &[Place]) -> Vec<Place> {
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
