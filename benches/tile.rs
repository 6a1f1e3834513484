//! Greedy cuts of whole tiles, and measuring the errors of the result.
//!
//! The front has no door of its own: it is timed through tiles where hardly anything else is done. Noise leaves
//! triangles without samples (every cut is looked for in vain many times); the dense rim holds a long front, whose every
//! ear is feasible.

mod terrain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use terrabite::base::Tile;
use terrabite::base::control::CancelToken;
use terrabite::base::lattice::Point;
use terrabite::base::mesh::{Domain, TileMesh, Vertex};
use terrabite::base::tiling::TilePlace;
use terrabite::kernel::measure::{Bare, measure};
use terrabite::kernel::seam::{MinLink, Rim};
use terrabite::kernel::triangulate::cuts::GreedyCuts;
use terrabite::kernel::triangulate::{Engine, EngineScratch, Feasibility, Task};

use terrain::{fractal, noise, tile, wide};

const SIDE: usize = 513;

fn rim(tile: &Tile, tolerance: f64) -> Rim {
    let cancel = CancelToken::default();
    Rim::new(tile, tolerance, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
        .expect("nobody cancels")
}

/// The engine with its memory, reused from run to run as the program does from tile to tile.
#[derive(Default)]
struct Cutter {
    scratch: EngineScratch,
    mesh: TileMesh,
}

impl Cutter {
    /// Returns how many triangles there are.
    fn cut(
        &mut self,
        engine: GreedyCuts,
        tile: &Tile,
        domain: &Domain,
        tolerance: f64,
        feasibility: Feasibility,
    ) -> usize {
        let task =
            Task { tile, domain, tolerance, feasibility, max_stray: f64::INFINITY, cancel: &CancelToken::default() };
        engine.triangulate(&task, &mut self.scratch, &mut self.mesh).expect("nobody cancels");
        self.mesh.triangles.len()
    }
}

fn cuts(c: &mut Criterion) {
    use Feasibility::{Strong, Weak};
    const PLAIN: GreedyCuts = GreedyCuts::PLAIN;
    const IMPROVED: GreedyCuts = GreedyCuts::IMPROVED;
    let mountains = tile(SIDE, SIDE, fractal);
    let wide_mountains = wide(&mountains);
    let flat = tile(SIDE, SIDE, |_, _| 7.0);
    let white = tile(129, 129, |column, row| 100.0 * noise(column, row));
    let steps = tile(257, 257, |column, row| ((column + 3 * row) / 40) as f64 * 10.0);
    // A trench of one cell from corner to corner, beside a plain: its floor asks for slivers as long as the tile.
    let valley = tile(SIDE, SIDE, |column, row| if row == 200 + column / 9 { -50.0 } else { 0.02 * column as f64 });
    let cases = [
        ("fine_weak", PLAIN, &mountains, 2.0, Weak, 67993),
        ("fine_weak_f64", PLAIN, &wide_mountains, 2.0, Weak, 67993),
        ("fine_strong", PLAIN, &mountains, 2.0, Strong, 55201),
        ("coarse_weak", PLAIN, &mountains, 15.0, Weak, 1864),
        ("coarse_strong", PLAIN, &mountains, 15.0, Strong, 1692),
        ("flat_at_0", PLAIN, &flat, 0.0, Weak, 2),
        ("noise_weak", PLAIN, &white, 1.0, Weak, 32374),
        ("noise_strong", PLAIN, &white, 10.0, Strong, 31409),
        ("steps", PLAIN, &steps, 1.0, Weak, 5570),
        ("valley_weak", PLAIN, &valley, 1.0, Weak, 78),
        ("valley_strong", PLAIN, &valley, 1.0, Strong, 2700),
        ("improved_fine_weak", IMPROVED, &mountains, 2.0, Weak, 38385),
        ("improved_fine_strong", IMPROVED, &mountains, 2.0, Strong, 36073),
        ("improved_coarse_weak", IMPROVED, &mountains, 15.0, Weak, 1114),
        ("improved_coarse_strong", IMPROVED, &mountains, 15.0, Strong, 1074),
        ("improved_flat_at_0", IMPROVED, &flat, 0.0, Weak, 2),
        ("improved_noise_weak", IMPROVED, &white, 1.0, Weak, 32454),
        ("improved_steps", IMPROVED, &steps, 1.0, Weak, 860),
        ("improved_valley_weak", IMPROVED, &valley, 1.0, Weak, 50),
    ];
    let mut group = c.benchmark_group("cuts");
    for (name, engine, tile, tolerance, feasibility, expected) in cases {
        let rim = rim(tile, tolerance);
        let mut cutter = Cutter::default();
        let mut count = || cutter.cut(engine, black_box(tile), &rim.domain, tolerance, feasibility);
        assert_eq!(count(), expected, "triangles of {name}");
        group.throughput(Throughput::Elements((tile.width() * tile.height()) as u64));
        group.bench_function(name, |b| b.iter(&mut count));
    }
    group.finish();
}

/// All samples of the rim as its vertices.
fn dense_rim(tile: &Tile) -> Domain {
    let last = tile.width() as i32 - 1;
    let sides = [
        (0..last).map(|i| (i, 0)).collect::<Vec<_>>(),
        (0..last).map(|i| (last, i)).collect(),
        (0..last).map(|i| (last - i, last)).collect(),
        (0..last).map(|i| (0, last - i)).collect(),
    ];
    let vertex = |(column, row): (i32, i32)| Vertex {
        at: Point::of_sample(column, row),
        height: tile.at(column as usize, row as usize),
    };
    let vertices: Vec<Vertex> = sides.concat().into_iter().map(vertex).collect();
    let around = (0..vertices.len() as u32).collect();
    Domain { vertices, loops: vec![around], ..Domain::default() }
}

fn front(c: &mut Criterion) {
    // Rows and columns of the plain are cheap to scan: most of the time goes to the front.
    let plain = tile(SIDE, SIDE, |_, _| 0.0);
    let domain = dense_rim(&plain);
    let mut cutter = Cutter::default();
    let mut count = || cutter.cut(GreedyCuts::PLAIN, black_box(&plain), &domain, 1.0, Feasibility::Weak);
    assert_eq!(count(), 4 * 512 - 2, "triangles of a polygon");
    c.bench_function("front/dense_rim", |b| b.iter(&mut count));
}

fn errors(c: &mut Criterion) {
    let mountains = tile(SIDE, SIDE, fractal);
    let mut group = c.benchmark_group("measure");
    group.throughput(Throughput::Elements((SIDE * SIDE) as u64));
    for (name, tolerance) in [("fine", 2.0), ("coarse", 15.0)] {
        let rim = rim(&mountains, tolerance);
        let mut cutter = Cutter::default();
        cutter.cut(GreedyCuts::PLAIN, &mountains, &rim.domain, tolerance, Feasibility::Weak);
        let place = TilePlace::alone(SIDE, SIDE);
        let mut count = || measure(black_box(&mountains), &cutter.mesh, tolerance, &place, Bare::Nothing).samples;
        assert_eq!(count(), (SIDE * SIDE) as u64);
        group.bench_function(name, |b| b.iter(&mut count));
    }
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(1500));
    targets = cuts, front, errors
}
criterion_main!(benches);
