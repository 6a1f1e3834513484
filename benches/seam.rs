//! Seams: the polyline with the fewest links along one side, and the rim of a whole tile.

mod terrain;

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use terrabite::base::control::CancelToken;
use terrabite::base::tiling::TilePlace;
use terrabite::kernel::seam::{MinLink, Rim};

use terrain::{fractal, noise, tile};

const SIDE: usize = 513;

fn line(at: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..SIDE).map(at).collect()
}

fn links(c: &mut Criterion) {
    let mut group = c.benchmark_group("min_link");
    group.throughput(Throughput::Elements(SIDE as u64));
    let bend = |i: usize| (i as f64 - 256.0) * (i as f64 - 256.0) / 256.0;
    let cases = [
        ("rough", line(|i| 100.0 * noise(i, 0)), 20.0, 327),
        ("mountains", line(|i| fractal(i, 100)), 5.0, 31),
        ("smooth", line(bend), 1.0, 16),
        ("flat", line(|_| 7.0), 1.0, 1),
        ("flat_at_0", line(|_| 7.0), 0.0, 1),
    ];
    for (name, heights, tolerance, expected) in &cases {
        let (mut min_link, cancel) = (MinLink::default(), CancelToken::default());
        let mut count = || min_link.path(black_box(heights), *tolerance, &[], &cancel).expect("a path").len() - 1;
        assert_eq!(count(), *expected, "links of {name}");
        group.bench_function(*name, |b| b.iter(&mut count));
    }
    group.finish();
}

fn rim(c: &mut Criterion) {
    let mountains = tile(SIDE, SIDE, fractal);
    let (mut min_link, cancel) = (MinLink::default(), CancelToken::default());
    let place = TilePlace { last_column: false, last_row: false, ..TilePlace::alone(SIDE, SIDE) };
    let mut count = || {
        let rim = Rim::new(black_box(&mountains), 5.0, &[], &place, &mut min_link, &cancel);
        rim.expect("a rim").domain.vertices.len()
    };
    assert_eq!(count(), 135, "vertices on the rim");
    c.bench_function("rim", |b| b.iter(&mut count));
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .sample_size(20).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(800));
    targets = links, rim
}
criterion_main!(benches);
