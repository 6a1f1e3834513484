//! Straying between samples against an oracle: every side against every face, in rationals.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_rational::BigRational;
use proptest::prelude::*;

use super::ground::{PATTERNS, samples};
use super::oracle::a_height;
use super::scene::{Mesh, NORTH_UP, SOUTH_UP, Scene, TURNED};
use crate::verify::grid::orientation;
use crate::verify::{GroundOptions, StrayVerdict, VerifyError};

type Place = (i64, i64);

fn rational(value: f64) -> BigRational {
    BigRational::from_float(value).unwrap()
}

fn whole(value: i64) -> BigRational {
    BigRational::from_integer(BigInt::from(value))
}

/// Which of the samples are bridged: groups of missing ones, eight neighbours to each, small and not at the raster's edge.
fn bridged(scene: &Scene, most: u64) -> Vec<bool> {
    let (w, h) = (scene.width as i64, scene.height as i64);
    let mut bridged = vec![false; scene.samples.len()];
    let mut seen = bridged.clone();
    for start in 0..scene.samples.len() {
        if seen[start] || !scene.samples[start].is_nan() {
            continue;
        }
        seen[start] = true;
        let mut group = vec![start];
        let (mut next, mut inside) = (0, true);
        while next < group.len() {
            let (x, y) = (group[next] as i64 % w, group[next] as i64 / w);
            inside &= x > 0 && y > 0 && x < w - 1 && y < h - 1;
            for (nx, ny) in (-1..2).flat_map(|dy| (-1..2).map(move |dx| (x + dx, y + dy))) {
                let at = (ny * w + nx) as usize;
                if (0..w).contains(&nx) && (0..h).contains(&ny) && scene.samples[at].is_nan() && !seen[at] {
                    seen[at] = true;
                    group.push(at);
                }
            }
            next += 1;
        }
        if inside && group.len() as u64 <= most {
            group.into_iter().for_each(|at| bridged[at] = true);
        }
    }
    bridged
}

/// What counts of straying at the points where the surface may be farthest: between which samples, and how much.
struct Oracle<'s> {
    scene: &'s Scene,
    weights: Option<&'s [f64]>,
    /// By the first and last sample of a side or a cell, in the order of the last one's row, the first one's column, and of
    /// column sides, cells and row sides.
    strays: BTreeMap<(i64, i64, u8), (BigRational, Place, Place)>,
}

impl Oracle<'_> {
    fn height(&self, (column, row): Place) -> f64 {
        self.scene.samples[row as usize * self.scene.width + column as usize]
    }

    /// A height of the surface among samples that have one.
    fn add(&mut self, kind: u8, (from, to): (Place, Place), among: &[Place], surface: &BigRational) {
        let heights = || among.iter().map(|&p| self.height(p));
        let low = rational(heights().fold(f64::INFINITY, f64::min));
        let high = rational(heights().fold(f64::NEG_INFINITY, f64::max));
        let beyond = (surface - high).max(low - surface);
        let weight =
            |&(column, row): &Place| self.weights.map_or(1.0, |w| w[row as usize * self.scene.width + column as usize]);
        let weight = rational(among.iter().map(weight).fold(f64::INFINITY, f64::min));
        let counted = beyond * weight;
        let stray = self.strays.entry((to.1, from.0, kind)).or_insert_with(|| (counted.clone(), from, to));
        stray.0 = counted.max(stray.0.clone());
    }

    /// The surface of every face at the ends of its piece of a side.
    fn along(&mut self, kind: u8, from: Place, to: Place) {
        if self.height(from).is_nan() || self.height(to).is_nan() {
            return;
        }
        let scene = self.scene;
        let lattice = |(column, row): Place| (4 * column, 4 * row);
        let (p, q) = (lattice(from), lattice(to));
        for face in &scene.mesh.faces {
            let [a, b, c] = face.map(|v| scene.mesh.places[v as usize]);
            let area = orientation(a, b, c);
            if area == 0 {
                continue;
            }
            let weights =
                |p| [orientation(p, b, c), orientation(a, p, c), orientation(a, b, p)].map(|w| w * area.signum());
            let (at_p, at_q) = (weights(p), weights(q));
            let (mut first, mut last) = (whole(0), whole(1));
            for (f0, f1) in at_p.into_iter().zip(at_q) {
                // f0 + (f1 − f0)·t ≥ 0
                let root = || BigRational::new(BigInt::from(f0), BigInt::from(f0 - f1));
                match (f0, f1) {
                    _ if f0 < 0 && f1 < 0 => last = whole(-1),
                    _ if f0 < f1 => first = first.max(root()),
                    _ if f0 > f1 => last = last.min(root()),
                    _ => {}
                }
            }
            if first > last {
                continue;
            }
            let inside = [first, last].into_iter().filter(|t| *t > whole(0) && *t < whole(1));
            for t in inside.collect::<Vec<_>>() {
                let weight = |i: usize| whole(at_p[i] as i64) + &t * whole((at_q[i] - at_p[i]) as i64);
                let terms = (0..3).map(|i| weight(i) * rational(scene.mesh.heights[face[i] as usize]));
                let surface = terms.sum::<BigRational>() / whole(area.abs() as i64);
                self.add(kind, (from, to), &[from, to], &surface);
            }
        }
    }

    /// Vertices of faces inside a cell.
    fn within(&mut self, bridged: &[bool], column: i64, row: i64) {
        let scene = self.scene;
        let corners = [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)];
        let at = |&(column, row): &Place| row as usize * scene.width + column as usize;
        let among: Vec<Place> = corners.into_iter().filter(|p| !scene.samples[at(p)].is_nan()).collect();
        if among.len() < 3 || corners.iter().any(|p| bridged[at(p)]) {
            return;
        }
        for (index, (x, y)) in (0u64..).zip(&scene.mesh.places) {
            let is_used = scene.mesh.faces.iter().any(|face| {
                let [a, b, c] = face.map(|v| scene.mesh.places[v as usize]);
                face.contains(&index) && orientation(a, b, c) != 0
            });
            if is_used && 4 * column < *x && *x < 4 * column + 4 && 4 * row < *y && *y < 4 * row + 4 {
                let surface = rational(scene.mesh.heights[index as usize]);
                self.add(1, (corners[0], corners[3]), &among, &surface);
            }
        }
    }
}

/// Whether a sample may be bare: one without a height is at most `trim` columns and rows away.
fn is_near(scene: &Scene, (column, row): Place, trim: i64) -> bool {
    let (w, h) = (scene.width as i64, scene.height as i64);
    let around = (row - trim..=row + trim).flat_map(|r| (column - trim..=column + trim).map(move |c| (c, r)));
    let mut within = around.filter(|&(c, r)| trim > 0 && 0 <= c && c < w && 0 <= r && r < h);
    within.any(|(c, r)| scene.samples[(r * w + c) as usize].is_nan())
}

/// What counts of straying on all sides and in all cells, in order; with `trim` no hole is filled.
fn strays(scene: &Scene, weights: Option<&[f64]>, fill_holes: u64, trim: i64) -> Vec<(BigRational, Place, Place)> {
    let bridged = bridged(scene, fill_holes);
    let mut oracle = Oracle { scene, weights, strays: BTreeMap::new() };
    let (w, h) = (scene.width as i64, scene.height as i64);
    for (row, column) in (0..h).flat_map(|row| (0..w).map(move |column| (row, column))) {
        let counts = |far: Place| {
            let places = [(column, row), (far.0, row), (column, far.1), far];
            !places.into_iter().any(|p| is_near(scene, p, trim))
        };
        if row + 1 < h && counts((column, row + 1)) {
            oracle.along(0, (column, row), (column, row + 1));
        }
        if column + 1 < w && counts((column + 1, row)) {
            oracle.along(2, (column, row), (column + 1, row));
        }
        if row + 1 < h && column + 1 < w && counts((column + 1, row + 1)) {
            oracle.within(&bridged, column, row);
        }
    }
    oracle.strays.into_values().collect()
}

/// Holds what was found against the oracle.
fn check(scene: &Scene, stray: &StrayVerdict, strays: &[(BigRational, Place, Place)]) {
    let limit = rational(stray.limit);
    let beyond: Vec<_> = strays.iter().filter(|s| s.0 > limit).collect();
    assert_eq!(stray.beyond.count, beyond.len() as u64, "{stray:?}");
    let ends = |side: &crate::verify::SidePlace| {
        ((side.from.column as i64, side.from.row as i64), (side.to.column as i64, side.to.row as i64))
    };
    assert_eq!(stray.beyond.first.as_ref().map(ends), beyond.first().map(|s| (s.1, s.2)));
    let largest = strays.iter().map(|s| &s.0).max().filter(|s| **s > whole(0));
    let Some(largest) = largest else { return assert_eq!(stray.worst, None) };
    let worst = stray.worst.unwrap();
    let counted = worst.stray * worst.weight.unwrap_or(1.0);
    let off = rational(counted) - largest;
    let (off, slack) = (if off < whole(0) { -off } else { off }, largest * rational(1e-15));
    assert!(off <= slack, "{worst:?} {largest}");
    if worst.weight.is_none() {
        assert_eq!(counted > stray.limit, !beyond.is_empty(), "{stray:?}");
    }
    // It is where the largest of them is, or one as large.
    let (from, to) = ends(&worst.side);
    let there = strays.iter().find(|s| (s.1, s.2) == (from, to)).unwrap();
    assert!(largest - &there.0 <= slack, "{worst:?}");
    assert!(
        (from.0 as f64..=to.0 as f64).contains(&worst.column) && (from.1 as f64..=to.1 as f64).contains(&worst.row)
    );
    let transform = crate::base::GeoTransform::new(scene.transform, scene.width, scene.height).unwrap();
    assert_eq!((worst.x, worst.y), transform.place(worst.column, worst.row));
    let [low, high] = worst.raster_heights;
    let beyond = (worst.surface_height - high).max(low - worst.surface_height);
    assert!(low <= high && (beyond - worst.stray).abs() <= 1e-13 * (1.0 + high.abs() + low.abs()), "{worst:?}");
}

prop_compose! {
    /// Any mesh on quarter cells over any raster, some of whose samples have no height.
    fn scene()(width in prop_oneof![4 => 2usize..9, 1 => 9usize..20], height in 2usize..8)(
        size in Just((width, height)),
        transform in prop_oneof![Just(NORTH_UP), Just(SOUTH_UP), Just(TURNED)],
        samples in proptest::collection::vec(a_height(), width * height),
        missing in proptest::collection::vec(0u32..100, width * height),
        share in prop_oneof![Just(0), Just(4), Just(20)],
        rim in proptest::collection::vec(a_height(), 4),
        points in proptest::collection::vec(((0..4 * width as i64 - 3, 0..4 * height as i64 - 3), a_height()), 0..16),
    ) -> Scene {
        let mut mesh = Mesh::rectangle(size.0, size.1);
        mesh.heights = rim;
        points.into_iter().for_each(|(place, z)| mesh.insert(place, z));
        let samples = samples.into_iter().zip(missing).map(|(z, roll)| if roll < share { f64::NAN } else { z }).collect();
        Scene { width: size.0, height: size.1, transform, samples, mesh }
    }
}

fn a_weight() -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(1.0), 1 => Just(0.0), 1 => Just(0.5), 2 => 0f64..2.0]
}

/// Factors and tolerances whose products are exact, and others.
fn a_limit() -> impl Strategy<Value = (f64, f64)> {
    let tolerance = prop_oneof![Just(0.0), Just(0.25), Just(0.5), Just(1.0), Just(0.1), 0f64..2.0];
    (tolerance, prop_oneof![Just(1.0), Just(1.5), Just(2.0), 1f64..3.0])
}

proptest! {
    #![proptest_config(crate::testing::cases(200, 4000))]

    #[test]
    fn straying_is_what_every_side_against_every_face_says(
        scene in scene(), limit in a_limit(), weights in proptest::collection::vec(a_weight(), 160), weighted in any::<bool>(),
        fill_holes in prop_oneof![Just(0u64), 1u64..5],
    ) {
        let weights = weighted.then(|| &weights[..scene.samples.len()]);
        let ground = GroundOptions { fill_holes, trim: 0 };
        let verdict = scene.judge_stray(limit, ground, weights);
        let stray = verdict.stray.unwrap();
        check(&scene, &stray, &strays(&scene, weights, fill_holes, 0));
        prop_assert_eq!(verdict.failures().iter().any(|f| f.contains("between samples, in")), stray.beyond.count > 0);
    }

    /// Where the mesh may end within the ground, edges of one face count, too.
    #[test]
    fn straying_is_that_of_what_is_covered(
        scene in scene(), limit in a_limit(), dropped in proptest::collection::vec(any::<prop::sample::Index>(), 0..6),
    ) {
        let mut scene = scene;
        for index in dropped {
            if scene.mesh.faces.len() > 1 {
                scene.mesh.faces.swap_remove(index.index(scene.mesh.faces.len()));
            }
        }
        let stray = scene.judge_stray(limit, GroundOptions { fill_holes: 0, trim: 1 }, None).stray.unwrap();
        check(&scene, &stray, &strays(&scene, None, 0, 1));
    }
}

#[test]
fn a_mesh_of_all_samples_strays_nowhere() {
    for (name, rows, _) in PATTERNS {
        let heights = samples(rows);
        for falls in [false, true] {
            let mesh = Mesh::of_cells(rows[0].len(), &heights, || falls);
            let scene =
                Scene { width: rows[0].len(), height: rows.len(), transform: NORTH_UP, samples: heights.clone(), mesh };
            let verdict = scene.judge_stray((0.0, 1.0), GroundOptions::default(), None);
            assert!(verdict.passes(), "{name}: {verdict}");
            assert_eq!(verdict.stray.unwrap().worst, None, "{name}");
        }
    }
}

/// 3 × 3 samples at 0 but for one of 3 to the right, and an edge from the first one to it: it crosses the middle column's side
/// between the first two rows at 1.5.
fn knight() -> Scene {
    let mut mesh = Mesh::rectangle(3, 3);
    mesh.places.push((8, 4));
    mesh.heights.push(3.0);
    mesh.faces = vec![[0, 4, 1], [0, 2, 4], [0, 3, 2]];
    let mut samples = vec![0.0; 9];
    samples[5] = 3.0;
    Scene { width: 3, height: 3, transform: NORTH_UP, samples, mesh }
}

#[test]
fn an_exact_tie_passes_and_one_ulp_more_fails() {
    fn judge(scene: &Scene, limit: (f64, f64), weights: Option<&[f64]>) -> StrayVerdict {
        scene.judge_stray(limit, GroundOptions::default(), weights).stray.unwrap()
    }
    let mut scene = knight();
    let tie = judge(&scene, (1.0, 1.5), None);
    assert_eq!((tie.limit, tie.beyond.count), (1.5, 0), "{tie:?}");
    let worst = tie.worst.unwrap();
    assert_eq!((worst.stray, worst.tolerances, worst.column, worst.row), (1.5, Some(1.5), 1.0, 0.5));
    assert_eq!((worst.surface_height, worst.raster_heights, worst.weight), (1.5, [0.0, 0.0], None));
    let place = (worst.side.from.column, worst.side.from.row, worst.side.to.column, worst.side.to.row);
    assert_eq!(place, (1, 0, 1, 1));
    assert_eq!(judge(&scene, (1.5, 1.0), None).beyond.count, 0);
    assert_eq!(judge(&scene, (1.5f64.next_down(), 1.0), None).beyond.count, 1);
    assert_eq!(judge(&scene, (1.0, 1.5f64.next_down()), None).beyond.count, 1);
    // The higher of the two samples counts, and each of its bits.
    scene.samples[1] = -1.0;
    assert_eq!(judge(&scene, (1.0, 1.5), None).beyond.count, 0);
    scene.samples[4] = -f64::from_bits(1);
    let beyond = judge(&scene, (1.0, 1.5), None);
    assert_eq!(beyond.beyond.count, 1);
    assert!(beyond.worst.unwrap().stray > 1.5, "{beyond:?}");
    // The smaller weight of the two counts.
    let scene = knight();
    let mut weights = [4.0; 9];
    weights[4] = 0.5;
    assert_eq!(judge(&scene, (0.75, 1.0), Some(&weights)).beyond.count, 0);
    let beyond = judge(&scene, (0.75f64.next_down(), 1.0), Some(&weights));
    assert_eq!((beyond.beyond.count, beyond.worst.unwrap().stray, beyond.worst.unwrap().weight), (1, 1.5, Some(0.5)));
    weights[4] = 0.0;
    assert_eq!(judge(&scene, (0.0, 1.0), Some(&weights)).worst, None);
}

#[test]
fn a_product_is_rounded_up() {
    // 3 × the double 0.1 is between two doubles.
    let scene = knight();
    let stray = scene.judge_stray((0.1, 3.0), GroundOptions::default(), None).stray.unwrap();
    assert!(
        rational(stray.limit) >= rational(0.1) * whole(3)
            && rational(stray.limit.next_down()) < rational(0.1) * whole(3)
    );
}

#[test]
fn a_spike_between_samples_is_found_wherever_it_stands() {
    for (place, is_stray) in [((6, 4), true), ((4, 6), true), ((5, 6), true), ((4, 4), false)] {
        let mut scene =
            Scene { width: 4, height: 4, samples: vec![0.0; 16], mesh: Mesh::rectangle(4, 4), ..Scene::flat() };
        for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (4 * x, 4 * y))) {
            scene.mesh.insert((x, y), 0.0);
        }
        scene.mesh.insert(place, 0.0);
        let spike = scene.mesh.places.iter().position(|p| *p == place).unwrap();
        scene.mesh.heights[spike] = 5.0;
        let verdict = scene.judge_stray((1.0, 1.5), GroundOptions::default(), None);
        let worst = verdict.stray.unwrap().worst;
        assert!(!verdict.passes(), "{verdict}");
        assert_eq!(worst.map_or(0.0, |w| w.stray) == 5.0, is_stray, "{verdict}");
        if is_stray {
            let worst = worst.unwrap();
            assert_eq!((worst.column, worst.row), (place.0 as f64 / 4.0, place.1 as f64 / 4.0));
        }
    }
}

#[test]
fn limits_below_the_tolerance_are_refused() {
    let scene = Scene::flat();
    for factor in [0.0, 0.999, -1.0, f64::NAN, f64::INFINITY] {
        let judged = scene.compare(&scene.mesh_ply(), |raster, mesh, temp_dir| {
            let options = crate::verify::VerifyOptions {
                lines: None,
                max_error: 1.0,
                max_stray: Some(factor),
                importance: None,
                temp_dir: Some(temp_dir),
            };
            crate::verify::verify(raster, mesh, &options, &crate::base::control::Control::default())
        });
        assert!(matches!(judged, Err(VerifyError::Stray { .. })), "{factor}");
    }
}

#[test]
fn heights_that_are_no_numbers_do_not_stray() {
    for height in [f64::NAN, f64::INFINITY, f64::MAX, -f64::MAX] {
        let mut scene = Scene::flat();
        scene.mesh.heights[4] = height;
        let stray = scene.judge_stray((1.0, 1.0), GroundOptions::default(), None).stray.unwrap();
        assert_eq!(stray.beyond.count > 0, height.is_finite());
    }
    // Nor is anything beyond a limit that no double holds.
    let scene = knight();
    let stray = scene.judge_stray((f64::MAX, 2.0), GroundOptions::default(), None).stray.unwrap();
    assert_eq!((stray.limit, stray.beyond.count), (f64::INFINITY, 0));
}
