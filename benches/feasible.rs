//! Scan conversion and the feasibility of triangles and edges.

mod terrain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use terrabite::base::Tile;
use terrabite::base::lattice::{Point, STEPS, orient};
use terrabite::base::mesh::Vertex;
use terrabite::kernel::triangulate::Feasibility;
use terrabite::kernel::triangulate::feasible::Tester;

use terrain::{fractal, hash, noise, tile, wide};

/// Triangles, or edges, of one measurement.
const BATCH: usize = 64;
const SIDE: usize = 513;

fn vertex(tile: &Tile, column: i32, row: i32) -> Vertex {
    Vertex { at: Point::of_sample(column, row), height: tile.at(column as usize, row as usize) }
}

/// Triangles of about `samples` samples, neither slivers nor regular, all over the tile.
fn triangles(tile: &Tile, samples: usize) -> Vec<[Vertex; 3]> {
    let side = (2.0 * samples as f64).sqrt() as i32;
    let room = |seed: u32, i: usize| (hash(i as u32, seed, 5) % (SIDE as u32 - side as u32 * 5 / 4 - 1)) as i32;
    let corners = |i: usize| {
        let (column, row, lean) = (room(1, i), room(2, i), (hash(i as u32, 3, 5) % (side as u32 / 4 + 1)) as i32);
        [(column, row + lean), (column + side, row), (column + lean, row + side)]
    };
    let triangle = |i: usize| corners(i).map(|(column, row)| vertex(tile, column, row));
    let all: Vec<_> = (0..BATCH).map(triangle).collect();
    assert!(all.iter().all(|[a, b, c]| orient(a.at, b.at, c.at) > 0));
    all
}

/// A slope with bumps up to 1 m: at 2 m every triangle between its samples is feasible.
fn bumpy_slope() -> Tile {
    tile(SIDE, SIDE, |column, row| 0.25 * column as f64 + 0.5 * row as f64 + noise(column, row))
}

fn weak(c: &mut Criterion) {
    let mut group = c.benchmark_group("weak");
    let slope = bumpy_slope();
    let mountains = tile(SIDE, SIDE, fractal);
    // Whole metres on a whole slope, half of them one tolerance above it: under triangles on the slope itself, every
    // other sample is a tie.
    let ties = tile(SIDE, SIDE, |column, row| (column + row) as f64 + f64::from((column ^ row) as u32 & 1));
    let cases = [
        ("pass_f32", slope.clone(), 2.0, [BATCH; 4]),
        ("pass_f64", wide(&slope), 2.0, [BATCH; 4]),
        ("fail_f32", mountains.clone(), 0.5, FAILING),
        ("fail_f64", wide(&mountains), 0.5, FAILING),
        ("ties_f32", ties, 1.0, [BATCH; 4]),
    ];
    for (name, tile, tolerance, expected) in &cases {
        let tester = Tester::new(tile, *tolerance, Feasibility::Weak);
        for (samples, expected) in [10, 100, 1000, 10_000].into_iter().zip(expected) {
            let mut triangles = triangles(tile, samples);
            if *name == "ties_f32" {
                triangles.as_flattened_mut().iter_mut().for_each(|v| v.height = f64::from((v.at.x + v.at.y) / STEPS));
            }
            let count = || triangles.iter().filter(|&&t| tester.weakly_feasible(black_box(t))).count();
            assert_eq!(count(), *expected, "feasible triangles of {name}/{samples}");
            // A failing triangle is left after its first samples.
            let elements = if *expected == BATCH { BATCH * samples } else { BATCH };
            group.throughput(Throughput::Elements(elements as u64));
            group.bench_function(BenchmarkId::new(*name, samples), |b| b.iter(count));
        }
    }
    group.finish();
}

/// How many triangles of 10, 100, 1000 and 10000 samples happen to be feasible on mountains at half a metre.
const FAILING: [usize; 4] = [2, 0, 0, 0];

fn strong_edges(c: &mut Criterion) {
    let mut group = c.benchmark_group("strong_edge");
    let slope = bumpy_slope();
    let mountains = tile(SIDE, SIDE, fractal);
    for (name, tile, tolerance, expected) in [("pass", &slope, 2.0, [BATCH; 3]), ("fail", &mountains, 0.5, [4, 1, 0])] {
        let tester = Tester::new(tile, tolerance, Feasibility::Strong);
        for (cells, expected) in [10, 100, 400].into_iter().zip(expected) {
            let edge = |i: usize| {
                let room = |seed: u32| (hash(i as u32, seed, 9) % (SIDE as u32 - cells)) as i32;
                let (column, row, down) = (room(1), room(2), (hash(i as u32, 3, 9) % cells) as i32);
                (vertex(tile, column, row), vertex(tile, column + cells as i32, row + down))
            };
            let edges: Vec<_> = (0..BATCH).map(edge).collect();
            let count = || edges.iter().filter(|&&(p, q)| tester.strong_edge(black_box(p), q)).count();
            assert_eq!(count(), expected, "feasible edges of {name}/{cells}");
            group.throughput(Throughput::Elements(BATCH as u64));
            group.bench_function(BenchmarkId::new(name, cells), |b| b.iter(count));
        }
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = weak, strong_edges
}
criterion_main!(benches);
