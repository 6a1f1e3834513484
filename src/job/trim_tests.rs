//! Trimmed rims: what is written is held against the definition by brute force.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use proptest::prelude::*;

use super::nodata_tests::{Place, Scene, scene};
use super::tests::{Told, engines, qualities, told};
use super::*;
use crate::base::exact;
use crate::base::lattice::{Point, orient};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::testing::{self, cases};

/// Everything a trimmed mesh must be. Returns how many triangles it has, and how many samples it leaves bare.
fn check(scene: &Scene, params: &Params) -> (usize, u64) {
    if scene.cells().is_empty() {
        return (0, 0);
    }
    let made = scene.mesh(params, 1).expect("a mesh");
    let told = told(&made);
    assert!(told == super::tests::told(&scene.mesh(params, 2).expect("a mesh")), "another mesh by two threads");
    let mut errors = crate::kernel::measure::ErrorStats::default();
    made.chunks().for_each(|c| errors.add(&c.expect("a chunk").errors));
    assert_eq!(errors.all_samples(), (scene.width * scene.height) as u64);
    let triangles = Triangles::new(&told);
    triangles.check_topology();
    let bare = triangles.check_samples(scene, params);
    triangles.check_cells(scene, params.trim);
    assert_eq!(errors.trimmed, bare, "samples left bare");
    if params.trim == 0 {
        assert_eq!(bare, 0);
    }
    for (column, row) in params.points.iter().flat_map(|points| points.iter()) {
        let place = Point::of_sample(column as i32, row as i32);
        assert!(triangles.places.contains(&place), "point {column}, {row}");
    }
    (told.triangles.len(), bare)
}

/// How far the next missing sample is, in columns or rows.
fn distance(scene: &Scene, (column, row): Place) -> u32 {
    let away = |(c, r): Place| (c - column).abs().max((r - row).abs()) as u32;
    scene.places().filter(|&p| !scene.is_ground(p)).map(away).min().unwrap_or(u32::MAX)
}

struct Triangles {
    vertices: Vec<(Point, f64)>,
    triangles: Vec<[usize; 3]>,
    places: BTreeSet<Point>,
}

impl Triangles {
    /// With positive orientation on the lattice.
    fn new(told: &Told) -> Triangles {
        let steps = |d: f64| (d * 4.0) as i32;
        let vertices: Vec<_> =
            told.vertices.iter().map(|&[x, y, z]| (Point { x: steps(x - 0.5), y: steps(-y - 0.5) }, z)).collect();
        // Rows run down, so the map's sense of turning is not the lattice's.
        let triangles = told.triangles.iter().map(|&[a, c, b]| [a, b, c].map(|v| v as usize)).collect();
        let places = vertices.iter().map(|v| v.0).collect();
        Triangles { vertices, triangles, places }
    }

    fn corners(&self) -> impl Iterator<Item = [(Point, f64); 3]> {
        self.triangles.iter().map(|t| t.map(|v| self.vertices[v]))
    }

    fn check_topology(&self) {
        assert_eq!(self.places.len(), self.vertices.len(), "two vertices at one place");
        let mut edges = BTreeSet::new();
        for &[a, b, c] in &self.triangles {
            assert!(orient(self.vertices[a].0, self.vertices[b].0, self.vertices[c].0) > 0);
            for edge in [(a, b), (b, c), (c, a)] {
                assert!(edges.insert(edge), "edge {edge:?} twice");
            }
        }
        let used: BTreeSet<usize> = self.triangles.iter().flatten().copied().collect();
        assert_eq!(used.len(), self.vertices.len(), "vertices in use");
        // No vertex stands on another's edge, so edges with one side are a rim, and no crack.
        for (a, b) in edges {
            let [p, q] = [a, b].map(|v| self.vertices[v].0);
            let between = |v: &&Point| orient(p, q, **v) == 0 && crate::base::lattice::dot(**v, p, q) < 0;
            assert!(self.places.iter().find(between).is_none(), "a vertex on the edge {p:?} {q:?}");
        }
    }

    /// Returns how many samples of the ground that have heights are bare.
    fn check_samples(&self, scene: &Scene, params: &Params) -> u64 {
        let ground: BTreeSet<Place> = scene.cells().into_iter().flatten().collect();
        let mut covered: BTreeMap<Place, u32> = BTreeMap::new();
        for [a, b, c] in self.corners() {
            let o = orient(a.0, b.0, c.0);
            for (column, row) in scene.places() {
                let p = Point::of_sample(column, row);
                let w = [orient(b.0, c.0, p), orient(c.0, a.0, p), orient(a.0, b.0, p)];
                if w.iter().any(|&w| w < 0) {
                    continue;
                }
                assert!(scene.is_ground((column, row)), "sample {column}, {row} is covered");
                // Those of bridged holes have none.
                if let Some(height) = scene.at((column, row)) {
                    let terms = [(w[0], a.1), (w[1], b.1), (w[2], c.1), (-o, height)];
                    let limit = scene.limit((column, row), params.tolerance.kept());
                    assert!(exact::within(&terms, o, limit), "sample {column}, {row}");
                }
                *covered.entry((column, row)).or_default() += u32::from(w.iter().all(|&w| w > 0));
            }
        }
        assert!(covered.values().all(|&inside| inside <= 1), "{covered:?}");
        assert!(covered.keys().all(|place| ground.contains(place)));
        let bare: Vec<&Place> = ground.iter().filter(|place| !covered.contains_key(place)).collect();
        for &&place in &bare {
            assert!(distance(scene, place) <= params.trim, "{place:?} is bare");
        }
        bare.into_iter().filter(|&&place| scene.at(place).is_some()).count() as u64
    }

    /// Looks at places that hardly any edge passes.
    fn check_cells(&self, scene: &Scene, trim: u32) {
        const SCALE: i32 = 1009;
        let scaled = |p: Point| Point { x: p.x * SCALE, y: p.y * SCALE };
        for (column, row) in scene.places().filter(|p| p.0 + 1 < scene.width as i32 && p.1 + 1 < scene.height as i32) {
            let around = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(dx, dy)| (column + dx, row + dy));
            let valid: Vec<Place> = around.into_iter().filter(|&p| scene.is_ground(p)).collect();
            let is_core = around.iter().all(|&p| distance(scene, p) > trim);
            for (dx, dy) in [(311, 1427), (2011, 2503), (3109, 3701), (1201, 607), (3301, 1009), (907, 3407)] {
                let p = Point { x: column * 4 * SCALE + dx, y: row * 4 * SCALE + dy };
                let side = |a: Place, b: Place| {
                    let [a, b] = [a, b].map(|(c, r)| scaled(Point::of_sample(c, r)));
                    orient(a, b, p)
                };
                let is_ground =
                    valid.len() >= 3 && (0..valid.len()).all(|i| side(valid[i], valid[(i + 1) % valid.len()]) > 0);
                // How far a place is inside of a triangle: 0 on an edge of it.
                let inside = self.corners().map(|t| {
                    let t = t.map(|v| scaled(v.0));
                    (0..3).map(|i| orient(t[i], t[(i + 1) % 3], p)).min().unwrap_or(-1)
                });
                let inside: Vec<i64> = inside.filter(|&o| o >= 0).collect();
                let times = inside.iter().filter(|&&o| o > 0).count();
                assert!(times <= usize::from(is_ground), "{dx}, {dy} of cell {column}, {row}: {times} times");
                assert!(
                    !inside.is_empty() || !is_core || !is_ground,
                    "{dx}, {dy} of core cell {column}, {row} is bare"
                );
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(100, 400))]

    #[test]
    fn the_mesh_is_the_ground_less_a_strip(
        (width, height) in (2usize..=14, 2usize..=14), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=7], strong in any::<bool>(), trim in 0u32..6,
        max_error in prop_oneof![Just(0.0), Just(1.0), Just(2.5), 0.0f64..6.0, Just(1e6)],
        engine in prop::sample::select(engines()),
        (quality, heights) in prop::sample::select(qualities()),
    ) {
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let params = Params { feasibility, tile, engine, quality, heights, trim, ..Params::new(max_error) };
        check(&scene(width, height, seed, kind, holes), &params);
    }
}

proptest! {
    #![proptest_config(cases(40, 100))]

    /// Samples of bridged holes may be bare, too, but are not lost: they have no heights.
    #[test]
    fn with_bridged_holes(
        (width, height) in (3usize..=14, 3usize..=14), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=7], trim in 1u32..6, most in 1usize..9, single in 0usize..196,
        max_error in prop_oneof![Just(0.0), Just(2.5), 0.0f64..6.0, Just(1e6)],
        (quality, heights) in prop::sample::select(qualities()),
    ) {
        let mut scene = scene(width, height, seed, kind, holes);
        scene.heights[single % (width * height)] = f64::NAN;
        check(&scene.bridging(most), &Params { tile, quality, heights, trim, ..Params::new(max_error) });
    }

    #[test]
    fn with_weights_and_points(
        (width, height) in (3usize..=14, 3usize..=14), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=7], max_error in prop_oneof![Just(1.0), 0.0f64..6.0],
        weighted in any::<bool>(), points in prop::collection::vec(0usize..196, 0..12), trim in 1u32..6,
        (quality, heights) in prop::sample::select(qualities()),
    ) {
        let mut scene = scene(width, height, seed, kind, holes);
        if weighted {
            scene.weigh();
        }
        let points = scene.points_of(points);
        let params = Params { tile, quality, heights, trim, points: Some(Arc::new(points)), ..Params::new(max_error) };
        check(&scene, &params);
    }

    #[test]
    fn with_a_channel(
        (width, height) in (3usize..=14, 3usize..=14), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5,
        tile in prop_oneof![Just(0usize), 2usize..=7], max_error in prop_oneof![Just(1.0), 0.0f64..6.0], trim in 1u32..6,
    ) {
        let mut scene = scene(width, height, seed, kind, holes);
        let red = |(i, z): (usize, &f64)| if z.is_nan() { f64::NAN } else { (i * 31 % 10) as f64 };
        scene.channel = scene.heights.iter().enumerate().map(red).collect();
        check(&scene, &Params { tile, quality: Quality::None, trim, ..Params::new(max_error) });
    }
}

/// Ground where the text has no dot; all of one height.
fn flat(rows: &[&str]) -> Scene {
    let heights = rows.concat().bytes().map(|b| if b == b'.' { f64::NAN } else { 7.0 }).collect();
    Scene::new(rows[0].len(), rows.len(), heights)
}

/// Triangles and samples lost, for each number of cells, in one piece and flat.
fn trimmed(scene: &Scene, cells: [u32; 3]) -> [(usize, u64); 3] {
    cells.map(|trim| check(scene, &Params { trim, tile: 0, quality: Quality::None, ..Params::new(0.0) }))
}

#[test]
fn a_staircase_becomes_a_line() {
    let stairs =
        flat(&["xxxxxxxxxxxx", "xxxxxxxxxxxx", "xxxxxxxxxxxx", "xxxxxxxxx...", "xxxxxx......", "xxx........."]);
    let found = trimmed(&stairs, [0, 1, 4]);
    assert_eq!(found, [(8, 0), (5, 4), (5, 4)]);
}

/// The corner of a square is cut off, 15 samples beyond the diagonal; one is bridged, and had no height to lose.
#[test]
fn bridged_samples_are_no_loss() {
    let mut rows = ["xxxxxx...."; 10];
    rows[4] = "xxxx.x....";
    rows[6..].fill("..........");
    let params = Params { trim: 3, tile: 0, quality: Quality::None, ..Params::new(0.0) };
    assert_eq!(check(&flat(&rows).bridging(1), &params), (1, 14));
    rows[4] = rows[3];
    assert_eq!(check(&flat(&rows), &params), (1, 15));
}

/// Loops that touch, necks of one sample, islands, and a line of half cells.
#[test]
fn grounds_that_hang_together_by_a_sample() {
    let grounds: [&[&str]; 5] = [
        &["xxx....", "xxx....", "xxxxx..", "..xxxxx", "....xxx", "....xxx"],
        &["xx.xx", "xxxxx", "xx.xx", "xxxxx", "xx.xx"],
        &["xxx...", "xxx...", "xxx...", "..xxxx", "..xxxx", "..xxxx"],
        &["xx.....", "xxx....", ".xxx...", "..xxx..", "...xxx.", "....xxx", ".....xx"],
        &[".......", ".xxxxx.", ".x...x.", ".xxxxx.", "..x.xx.", ".xxxx..", "......."],
    ];
    for rows in grounds {
        let scene = flat(rows);
        for tile in [0, 1, 2, 3] {
            for engine in [EngineChoice::default(), EngineChoice::GreedyCuts(GreedyCuts::IMPROVED)] {
                for trim in 0..4 {
                    let params = Params { trim, tile, engine, ..Params::new(0.0) };
                    check(&scene, &params);
                }
            }
        }
    }
}

/// Every pattern of 3 × 3 samples, cut into tiles of one cell and in one piece.
#[test]
fn every_small_ground() {
    for pattern in 0u32..512 {
        let height = |i: usize| if pattern >> i & 1 == 1 { (i * i % 5) as f64 } else { f64::NAN };
        let heights = (0..9).map(height).collect();
        let scene = Scene::new(3, 3, heights);
        for (tile, trim) in [(0, 1), (1, 1), (0, 2)] {
            check(&scene, &Params { tile, trim, quality: Quality::None, ..Params::new(5.0) });
        }
    }
}

#[test]
fn larger_grounds_with_a_second_pass() {
    for holes in 0..5 {
        for (row, (quality, heights)) in [
            (Quality::None, VertexHeights::Sampled),
            (Quality::Balanced, VertexHeights::Sampled),
            (Quality::Balanced, VertexHeights::Fitted),
        ]
        .into_iter()
        .enumerate()
        {
            for (column, trim) in [1, 3, 9].into_iter().enumerate() {
                // A Latin square: any two of the three meet once.
                if (usize::from(holes) + row + column) % 3 > 0 && !testing::is_long() {
                    continue;
                }
                check(&scene(70, 60, 5, 1, holes), &Params { quality, heights, trim, tile: 24, ..Params::new(3.0) });
            }
        }
    }
}

/// The rim has the tolerance that is found.
#[test]
fn a_budget_is_kept_with_a_trimmed_rim() {
    let scene = scene(70, 60, 5, 1, 2);
    let goal = Goal { max_points: Some(400), ..Goal::default() };
    for quality in [Quality::None, Quality::Balanced] {
        let params = Params { trim: 2, tile: 24, quality, ..Params::new(f64::INFINITY) };
        let mesh = scene.mesh(&Params { goal, ..params.clone() }, 1).expect("a mesh");
        let figures = mesh.figures().expect("figures");
        assert!((300..=400).contains(&figures.vertices), "{figures:?}");
        check(&scene, &Params { tolerance: mesh.tolerance(), ..params });
    }
}

#[test]
fn nothing_changes_where_nothing_is_missing() {
    let terrain = super::tests::terrain(4, 60, 50);
    let scene = Scene::new(60, 50, terrain);
    let made = |trim| told(&scene.mesh(&Params { trim, tile: 20, ..Params::new(1.0) }, 1).expect("a mesh"));
    assert!(made(0) == made(5));
    let refused = scene.mesh(&Params { trim: 1001, ..Params::new(1.0) }, 1);
    assert!(matches!(refused, Err(Error::Trim(1001))), "{refused:?}");
}
