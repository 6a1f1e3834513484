//! The fast tests of triangles against naive ones.

use std::cmp::Ordering;

use proptest::prelude::*;

use super::*;
use crate::base::exact;
use crate::base::lattice::{Point, orient};
use crate::base::mesh::Vertex;
use crate::base::{Heights, Tile};
use crate::kernel::triangulate::Feasibility;

const SIDE: usize = 24;

fn inside(corners: [Vertex; 3], p: Point) -> Option<[i64; 3]> {
    let [a, b, c] = corners.map(|v| v.at);
    let weights = [orient(b, c, p), orient(c, a, p), orient(a, b, p)];
    weights.iter().all(|&w| w >= 0).then_some(weights)
}

/// Every sample of the tile, asked whether it is inside and within, in exact arithmetic.
fn naive(tile: &Tile, corners: [Vertex; 3], tolerance: f64) -> bool {
    let samples = (0..tile.height()).flat_map(|r| (0..tile.width()).map(move |c| (c, r)));
    samples.into_iter().all(|(c, r)| {
        let Some(w) = inside(corners, Point::of_sample(c as i32, r as i32)) else { return true };
        let area: i64 = w.iter().sum();
        let [za, zb, zc] = corners.map(|v| v.height);
        exact::within(&[(w[0], za), (w[1], zb), (w[2], zc), (-area, tile.at(c, r))], area, tile.limit(c, r, tolerance))
    })
}

fn tile() -> impl Strategy<Value = Tile> {
    let kinds = prop_oneof![Just(0u8), Just(1), Just(2), Just(3)];
    (kinds, any::<u64>())
        .prop_map(|(kind, seed)| {
            let noise = |i: usize| (((i as u64 + 1).wrapping_mul(seed | 1) >> 40) & 0xffff) as f64 / 65536.0;
            let slope = |i: usize| (i % SIDE) as f64 * 0.5 + (i / SIDE) as f64 * 0.25;
            match kind {
                0 => Heights::F32((0..SIDE * SIDE).map(|i| (slope(i) + noise(i) * 3.0).floor() as f32).collect()),
                1 => Heights::F32((0..SIDE * SIDE).map(|i| (8000.0 + slope(i) + noise(i)) as f32).collect()),
                2 => Heights::F64((0..SIDE * SIDE).map(|i| slope(i) + 0.1 * noise(i)).collect()),
                _ => Heights::F32(vec![17.0; SIDE * SIDE]),
            }
        })
        .prop_map(|heights| Tile::from_heights(SIDE, SIDE, heights))
}

/// Weights for a tile: one for all, two halves, or any.
fn weights() -> impl Strategy<Value = Vec<f64>> {
    let weight = || prop_oneof![Just(0.0), Just(0.3), Just(1.0), Just(2.0), Just(1e6), 0.0f64..3.0];
    prop_oneof![
        weight().prop_map(|w| vec![w; SIDE * SIDE]),
        (weight(), weight()).prop_map(|(a, b)| (0..SIDE * SIDE).map(|i| if i % SIDE < 12 { a } else { b }).collect()),
        prop::collection::vec(weight(), SIDE * SIDE),
    ]
}

/// A triangle with positive orientation, at samples or at any lattice points, its heights those of the ground or near.
fn corners(tile: &Tile, places: [(u8, u8); 3], off_grid: bool, lift: [f64; 3]) -> Option<[Vertex; 3]> {
    let far = 4 * (SIDE as i32 - 1);
    let vertex = |i: usize| {
        let (x, y) = (i32::from(places[i].0) % (far + 1), i32::from(places[i].1) % (far + 1));
        let at = if off_grid { Point { x, y } } else { Point { x: x / 4 * 4, y: y / 4 * 4 } };
        let ground = tile.at((x / 4) as usize, (y / 4) as usize);
        Vertex { at, height: if off_grid { ground + lift[i] } else { ground } }
    };
    let [a, b, c] = [vertex(0), vertex(1), vertex(2)];
    match orient(a.at, b.at, c.at) {
        0 => None,
        o if o > 0 => Some([a, b, c]),
        _ => Some([a, c, b]),
    }
}

/// Whether an edge is farther than `limit` from the range of the two samples of a side that it crosses: every side of the
/// tile, in exact arithmetic.
fn strays_somewhere(tile: &Tile, p: Vertex, q: Vertex, limit: f64) -> bool {
    let crosses = |columns: bool, line: i64, before: i64| {
        let place = |v: Vertex| if columns { (v.at.x, v.at.y) } else { (v.at.y, v.at.x) };
        let ([px, py], [qx, qy]) = [p, q].map(place).map(|(x, y)| [i64::from(x), i64::from(y)]).into();
        let (span, done) = if px < qx { (qx - px, 4 * line - px) } else { (px - qx, px - 4 * line) };
        // Where it crosses the line, times the span.
        let along = py * (span - done) + qy * done;
        if done <= 0 || done >= span || along <= 4 * before * span || along >= 4 * (before + 1) * span {
            return false;
        }
        let sample = |along: i64| {
            let (column, row) = if columns { (line, along) } else { (along, line) };
            tile.at(column as usize, row as usize)
        };
        let (z0, z1) = (sample(before), sample(before + 1));
        let beyond = |z: f64, side| {
            let terms = [(span - done, p.height), (done, q.height), (-span, z)];
            exact::sign(&terms) == side && !exact::within(&terms, span, limit)
        };
        beyond(z0.max(z1), Ordering::Greater) || beyond(z0.min(z1), Ordering::Less)
    };
    let lines = 0..SIDE as i64;
    lines
        .into_iter()
        .any(|line| (0..SIDE as i64 - 1).any(|before| crosses(true, line, before) || crosses(false, line, before)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Edges anywhere, along the tile's sides, too; limits that one crossing just keeps or just does not are met often, as
    /// heights and tolerances are whole and halves.
    #[test]
    fn straying_is_that_of_exact_arithmetic(
        tile in tile(), places in any::<[(u8, u8); 2]>(), off_grid in any::<bool>(), at_side in any::<bool>(),
        lift in prop::array::uniform2(prop_oneof![Just(0.0), Just(1.5), -3.0f64..3.0]),
        tolerance in prop_oneof![Just(0.0), Just(0.5), Just(1.0), Just(2.0), 0.0f64..3.0],
    ) {
        let far = 4 * (SIDE as i32 - 1);
        let vertex = |i: usize| {
            let (x, y) = (i32::from(places[i].0) % (far + 1), i32::from(places[i].1) % (far + 1));
            let y = if at_side { far } else { y };
            let at = if off_grid { Point { x, y } } else { Point { x: x / 4 * 4, y: y / 4 * 4 } };
            Vertex { at, height: tile.at((x / 4) as usize, (y / 4) as usize) + lift[i] }
        };
        let (p, q) = (vertex(0), vertex(1));
        let tester = Tester::new(&tile, tolerance, Feasibility::Weak).with_max_stray(1.5);
        let mut sides = Vec::new();
        tester.list_strays(p, q, &mut sides);
        let expected = strays_somewhere(&tile, p, q, 1.5 * tolerance);
        prop_assert_eq!((tester.strays(p, q), !sides.is_empty()), (expected, expected));
    }

    #[test]
    fn spans_are_the_samples_inside(places in any::<[(u8, u8); 3]>(), off_grid in any::<bool>()) {
        let tile = Tile::from_heights(SIDE, SIDE, Heights::F32(vec![0.0; SIDE * SIDE]));
        let Some(t) = corners(&tile, places, off_grid, [0.0; 3]) else { return Ok(()) };
        let spans = Spans::new(t[0].at, t[1].at, t[2].at);
        let area = orient(t[0].at, t[1].at, t[2].at);
        let bound = (1..=SIDE).find(|&samples| spans.longest_has_at_most(samples, area)).expect("rows end on the tile");
        for row in 0..SIDE as i32 {
            let (first, last) = if spans.rows().contains(&row) { spans.columns(row) } else { (1, 0) };
            prop_assert!(last - first < bound as i32, "row {}: {} to {}", row, first, last);
            for column in 0..SIDE as i32 {
                let expected = inside(t, Point::of_sample(column, row)).is_some();
                prop_assert_eq!((first..=last).contains(&column), expected, "column {} row {}", column, row);
            }
        }
    }

    #[test]
    fn weak_feasibility_is_that_of_exact_arithmetic(
        tile in tile(), places in any::<[(u8, u8); 3]>(), off_grid in any::<bool>(), lift in prop::array::uniform3(-1.0f64..1.0),
        tolerance in prop_oneof![Just(0.0), Just(0.5), Just(1.0), Just(2.0), 0.0f64..3.0, Just(1e-7)],
    ) {
        let Some(t) = corners(&tile, places, off_grid, lift) else { return Ok(()) };
        let tester = Tester::new(&tile, tolerance, Feasibility::Weak);
        prop_assert_eq!(tester.weakly_feasible(t), naive(&tile, t, tolerance));
    }

    #[test]
    fn so_it_is_with_weights(
        tile in tile(), weights in weights(), places in any::<[(u8, u8); 3]>(), off_grid in any::<bool>(),
        lift in prop::array::uniform3(-1.0f64..1.0),
        tolerance in prop_oneof![Just(0.0), Just(0.5), Just(1.0), Just(2.0), 0.0f64..3.0, Just(1e-7), Just(1e-300)],
    ) {
        let tile = tile.with_weights(weights);
        let Some(t) = corners(&tile, places, off_grid, lift) else { return Ok(()) };
        let tester = Tester::new(&tile, tolerance, Feasibility::Weak);
        prop_assert_eq!(tester.weakly_feasible(t), naive(&tile, t, tolerance));
    }

    /// Tolerances at which one sample's error is the limit, or beside it by little, are where a wrong bound would show.
    #[test]
    fn near_ties_with_weights_are_decided_exactly(
        tile in tile(), weight in prop_oneof![Just(0.3), Just(1.0), Just(3.0), 0.01f64..100.0],
        places in any::<[(u8, u8); 3]>(), off_grid in any::<bool>(), lift in prop::array::uniform3(-1.0f64..1.0),
        which in any::<prop::sample::Index>(), nudge in -40i64..40,
    ) {
        let Some(t) = corners(&tile, places, off_grid, lift) else { return Ok(()) };
        let inner: Vec<(usize, usize)> = (0..SIDE * SIDE)
            .map(|i| (i % SIDE, i / SIDE))
            .filter(|&(c, r)| inside(t, Point::of_sample(c as i32, r as i32)).is_some())
            .collect();
        if inner.is_empty() { return Ok(()) }
        let (c, r) = inner[which.index(inner.len())];
        let error = (Plane::new(t[0], t[1], t[2]).at(Point::of_sample(c as i32, r as i32)) - tile.at(c, r)).abs();
        let tolerance = f64::from_bits((error * weight).to_bits().saturating_add_signed(nudge)).min(1e9);
        // The others are free.
        let mut weights = vec![0.0; SIDE * SIDE];
        weights[r * SIDE + c] = weight;
        let tile = tile.with_weights(weights);
        let tester = Tester::new(&tile, tolerance, Feasibility::Weak);
        prop_assert_eq!(tester.weakly_feasible(t), naive(&tile, t, tolerance));
    }

    /// A strong edge between samples of different limits is held to the smaller one.
    #[test]
    fn strong_edges_keep_the_smaller_limit(
        tile in tile(), weights in weights(), places in any::<[(u8, u8); 2]>(), tolerance in 0.0f64..3.0,
    ) {
        let at = |(x, y): (u8, u8)| (usize::from(x) % SIDE, usize::from(y) % SIDE);
        let ((pc, pr), (qc, qr)) = (at(places[0]), at(places[1]));
        if (pc, pr) == (qc, qr) { return Ok(()) }
        let vertex = |c: usize, r: usize| Vertex { at: Point::of_sample(c as i32, r as i32), height: tile.at(c, r) };
        let (p, q) = (vertex(pc, pr), vertex(qc, qr));
        let greatest = weights.iter().fold(0.0f64, |m, w| m.max(*w));
        let passes = |weights: Vec<f64>| {
            let tile = tile.clone().with_weights(weights);
            let tester = Tester::new(&tile, tolerance, Feasibility::Strong);
            let (passes, deviation) = (tester.strong_edge(p, q), tester.edge_deviation(p, q));
            assert!(passes == (deviation <= tolerance) || (deviation - tolerance).abs() <= 1e-9 * (1.0 + greatest));
            passes
        };
        // Weights that are raised can only forbid.
        prop_assert!(passes(weights.clone()) || !passes(vec![greatest; SIDE * SIDE]));
        let plain = Tester::new(&tile, tolerance, Feasibility::Strong);
        prop_assert_eq!(plain.strong_edge(p, q), passes(vec![1.0; SIDE * SIDE]));
    }

    /// The distance at crossings, found by walking the line densely, never exceeds the one computed, and reaches it.
    #[test]
    fn strong_edges_bound_the_distance_to_the_grid_surface(
        tile in tile(), places in any::<[(u8, u8); 2]>(),
    ) {
        let at = |(x, y): (u8, u8)| (usize::from(x) % SIDE, usize::from(y) % SIDE);
        let ((pc, pr), (qc, qr)) = (at(places[0]), at(places[1]));
        if (pc, pr) == (qc, qr) { return Ok(()) }
        let vertex = |c: usize, r: usize| Vertex { at: Point::of_sample(c as i32, r as i32), height: tile.at(c, r) };
        let (p, q) = (vertex(pc, pr), vertex(qc, qr));
        let surface = |x: f64, y: f64| {
            let (c, r) = ((x as usize).min(SIDE - 2), (y as usize).min(SIDE - 2));
            let (fx, fy) = (x - c as f64, y - r as f64);
            let h = |i: usize, j: usize| tile.at(c + i, r + j);
            if fx >= fy { h(0, 0) + fx * (h(1, 0) - h(0, 0)) + fy * (h(1, 1) - h(1, 0)) }
            else { h(0, 0) + fy * (h(0, 1) - h(0, 0)) + fx * (h(1, 1) - h(0, 1)) }
        };
        let mut walked = 0.0f64;
        let mut at_samples = 0.0f64;
        const WALK: usize = 20_000;
        for i in 0..=WALK {
            let t = i as f64 / WALK as f64;
            let (x, y) = (pc as f64 + t * (qc as f64 - pc as f64), pr as f64 + t * (qr as f64 - pr as f64));
            let gap = (surface(x, y) - (p.height + t * (q.height - p.height))).abs();
            walked = walked.max(gap);
        }
        for r in 0..SIDE { for c in 0..SIDE {
            let s = Point::of_sample(c as i32, r as i32);
            let (cross, along) = (orient(p.at, q.at, s), crate::base::lattice::dot(p.at, q.at, s));
            let length = crate::base::lattice::distance2(p.at, q.at);
            if cross == 0 && (0..=length).contains(&along) {
                let t = along as f64 / length as f64;
                at_samples = at_samples.max((tile.at(c, r) - (p.height + t * (q.height - p.height))).abs());
            }
        } }
        let tester = Tester::new(&tile, 1.0, Feasibility::Strong);
        let computed = tester.edge_deviation(p, q).max(at_samples);
        prop_assert!(walked <= computed + 1e-6, "walked {} computed {}", walked, computed);
        prop_assert!(walked >= computed - 0.02, "walked {} computed {}", walked, computed);
    }
}
