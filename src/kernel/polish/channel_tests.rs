//! Tiles with channels: what tests and measures triangles against brute force, and polishing held to it.

use proptest::prelude::*;

use super::energy::{Meter, energy};
use super::*;
use crate::base::channels::{ChannelError, Range, Ranges};
use crate::base::control::CancelToken;
use crate::base::lattice::orient;
use crate::base::mesh::Vertex;
use crate::base::tiling::TilePlace;
use crate::kernel::measure::{Bare, measure};
use crate::kernel::seam::{MinLink, Rim};
use crate::kernel::triangulate::Engine;
use crate::kernel::triangulate::conformance::{check, tile, tolerances};
use crate::kernel::triangulate::insertion::GreedyInsertion;
use crate::testing::cases;

/// Channels for a tile: steps, stripes, noise, the heights again.
fn with_channels(tile: Tile, kinds: &[u8], emphasis: f64, seed: u64) -> Tile {
    let (width, height) = (tile.width(), tile.height());
    let noise = |i: usize| ((i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56) as f64;
    let value = |kind: u8, i: usize| match kind {
        0 => f64::from(u8::from(i % width > width / 2)) * 200.0,
        1 => (i / width % 5) as f64 * 40.0,
        2 => noise(i),
        _ => tile.at(i % width, i / width),
    };
    let channels: Vec<Vec<f64>> =
        kinds.iter().map(|&kind| (0..width * height).map(|i| value(kind, i)).collect()).collect();
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(Range::EMPTY, |range, v| range.and(Range { min: v, max: v }))
    };
    let heights = range(&mut (0..width * height).map(|i| tile.at(i % width, i / width)));
    let of_channels = channels.iter().map(|c| range(&mut c.iter().copied())).collect();
    let ranges = Ranges { heights, channels: of_channels, unit: heights.width().max(1.0) };
    tile.with_channels(channels, ChannelError::new(emphasis, &ranges))
}

/// What is off at a sample under a triangle, in height and in all: 0 at its corners.
fn off(tile: &Tile, corners: [Vertex; 3], (column, row): (usize, usize)) -> Option<(f64, f64)> {
    let ([a, b, c], p) = (corners.map(|v| v.at), Point::of_sample(column as i32, row as i32));
    let w = [orient(b, c, p), orient(c, a, p), orient(a, b, p)];
    if w.iter().any(|&w| w < 0) {
        return None;
    }
    if [a, b, c].contains(&p) {
        return Some((0.0, 0.0));
    }
    let area: i64 = w.iter().sum();
    let mean = |values: [f64; 3]| values.iter().zip(w).map(|(v, w)| v * w as f64).sum::<f64>() / area as f64;
    let dz = mean(corners.map(|v| v.height)) - tile.at(column, row);
    let channels = (0..tile.channels.len())
        .map(|i| mean(corners.map(|v| tile.channel_at_vertex(i, v))) - tile.channel_at(i, column, row));
    Some((dz.abs(), tile.channel_error.as_ref().expect("channels").weighted(dz, channels)))
}

fn samples(tile: &Tile) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (width, height) = (tile.width(), tile.height());
    (0..width * height).map(move |i| (i % width, i / width))
}

fn corners(tile: &Tile, places: [(u16, u16); 3]) -> Option<[Vertex; 3]> {
    let vertex = |(x, y): (u16, u16)| {
        let (column, row) = (usize::from(x) % tile.width(), usize::from(y) % tile.height());
        Vertex { at: Point::of_sample(column as i32, row as i32), height: tile.at(column, row) }
    };
    let [a, b, c] = places.map(vertex);
    match orient(a.at, b.at, c.at) {
        0 => None,
        o if o > 0 => Some([a, b, c]),
        _ => Some([a, c, b]),
    }
}

fn kinds() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(0u8..4, 1..5)
}

fn emphases() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0f64..1.0]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(600))]

    /// Rows of this tile are longer than what is looked at together.
    #[test]
    fn triangles_are_tested_and_measured_as_their_samples_are(
        places in any::<[(u16, u16); 3]>(), seed in any::<u64>(), kind in 0u8..4, kinds in kinds(), emphasis in emphases(),
        share in prop_oneof![Just(0.0), 0.2f64..2.0], is_flat in any::<bool>(),
    ) {
        let height = if is_flat { 3 } else { 40 };
        let tile = with_channels(tile(150, height, seed, kind), &kinds, emphasis, seed);
        let Some(triangle) = corners(&tile, places) else { return Ok(()) };
        let all: Vec<(f64, f64)> = samples(&tile).filter_map(|sample| off(&tile, triangle, sample)).collect();
        let worst = all.iter().fold(0.0f64, |worst, (dz, weighted)| worst.max(*dz).max(*weighted));
        // About as large as the error.
        let tolerance = worst * share;
        let tester = Tester::new(&tile, tolerance, Feasibility::Weak);
        let limit = tile.channel_error.as_ref().expect("channels").limit(tolerance);
        let within = all.iter().all(|e| e.0 <= tolerance && e.1 <= limit);
        prop_assert!(tester.weakly_feasible(triangle) == within || (worst - tolerance).abs() <= 1e-9 * tolerance);
        if let Some(place) = tester.violation(triangle) {
            let (dz, weighted) = off(&tile, triangle, place.sample().expect("a sample")).expect("inside");
            prop_assert!(dz > tolerance * (1.0 - 1e-9) || weighted > limit - 1e-9 * tolerance);
        }
        if tolerance > 1e-6 {
            let fit = Meter::new(tester, tolerance).fit(triangle, f32::INFINITY);
            let sum: f32 = all.iter().map(|e| energy((e.0.max(e.1) / tolerance) as f32)).sum();
            prop_assert!((f64::from(fit.worst) * tolerance - worst).abs() <= 1e-3 * worst, "{:?} {}", fit, worst / tolerance);
            prop_assert!((fit.energy - sum).abs() <= 1e-2 * sum + 1e-5, "{:?} {}", fit, sum);
        }
    }
}

/// Polishes insertion with all efforts, and checks everything that is promised.
fn check_all(tile: &Tile, tolerance: f64) {
    let (cancel, place) = (CancelToken::default(), TilePlace::alone(tile.width(), tile.height()));
    let rim = Rim::new(tile, tolerance, &[], &place, &mut MinLink::default(), &cancel).expect("nobody cancels");
    for (feasibility, max_stray) in
        [(Feasibility::Weak, f64::INFINITY), (Feasibility::Weak, 1.5), (Feasibility::Strong, 1.0)]
    {
        let task = Task { tile, domain: &rim.domain, tolerance, feasibility, max_stray, cancel: &cancel };
        let (mut start, mut scratch) = (TileMesh::default(), Scratch::default());
        GreedyInsertion::default().triangulate(&task, &mut Default::default(), &mut start).expect("nobody cancels");
        for effort in [Effort::Fast, Effort::Balanced, Effort::Best] {
            let options = Options { effort, ..Options::default() };
            let polished = |scratch: &mut Scratch| {
                let mut mesh = start.clone();
                polish(&task, &options, scratch, &mut mesh).expect("nobody cancels");
                mesh
            };
            let mesh = polished(&mut scratch);
            check(tile, &rim.domain, &mesh, tolerance);
            assert!(mesh.triangles.len() <= start.triangles.len());
            let found = measure(tile, &mesh, tolerance, &place, Bare::Nothing).extended.expect("channels");
            let brute = mesh.triangles.iter().flat_map(|&t| {
                let corners = mesh.corners(t);
                samples(tile).filter_map(move |sample| off(tile, corners, sample))
            });
            let brute = brute.fold(0.0f64, |most, (_, weighted)| most.max(weighted));
            assert!(brute <= tolerance && (brute - found.max).abs() <= 1e-9 * (1.0 + brute), "{brute} {found:?}");
            assert_eq!(mesh, polished(&mut Scratch::default()), "memory carries nothing over");
        }
    }
}

proptest! {
    #![proptest_config(cases(16, 80))]

    #[test]
    fn every_promise_holds_with_channels(
        width in 2usize..24, height in 2usize..24, seed in any::<u64>(), kind in 0u8..4,
        kinds in kinds(), emphasis in emphases(), tolerance in tolerances(),
    ) {
        check_all(&with_channels(tile(width, height, seed, kind), &kinds, emphasis, seed), tolerance);
    }
}

/// On level ground with a disc of another colour only the disc's edge needs triangles.
#[test]
fn what_colours_do_not_need_goes() {
    let (width, height) = (96, 80);
    let disc = |i: usize| {
        let (x, y) = ((i % width) as f64 - 40.0, (i / width) as f64 - 36.0);
        if x.hypot(y) < 22.0 { 200.0 } else { (i % width) as f64 * 0.5 }
    };
    let range = Range { min: 0.0, max: 255.0 };
    let ranges = Ranges { heights: Range { min: 0.0, max: 0.0 }, channels: vec![range], unit: 255.0 };
    let level = Tile::from_heights(width, height, crate::base::Heights::F32(vec![0.0; width * height]));
    let tile = level.with_channels(vec![(0..width * height).map(disc).collect()], ChannelError::new(1.0, &ranges));
    let cancel = CancelToken::default();
    let rim = Rim::new(&tile, 10.0, &[], &TilePlace::alone(width, height), &mut MinLink::default(), &cancel);
    let (rim, max_stray) = (rim.expect("nobody cancels"), f64::INFINITY);
    let task = Task {
        tile: &tile,
        domain: &rim.domain,
        tolerance: 10.0,
        feasibility: Feasibility::Weak,
        max_stray,
        cancel: &cancel,
    };
    let mut mesh = TileMesh::default();
    GreedyInsertion::default().triangulate(&task, &mut Default::default(), &mut mesh).expect("nobody cancels");
    let before = mesh.triangles.len();
    polish(&task, &Options::default(), &mut Scratch::default(), &mut mesh).expect("nobody cancels");
    assert!(10 * mesh.triangles.len() < 7 * before, "{} of {before}", mesh.triangles.len());
}
