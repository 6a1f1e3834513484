//! Meshes that end at a cutline's own line, judged by the verifier, which reckons what is inside again.

use proptest::prelude::*;

use super::breakline_tests::{Line, Scene, engines, limits, number, qualities, scene, segments};
use super::*;
use crate::testing::cases;

fn ring(size: (usize, usize)) -> impl Strategy<Value = Line> {
    (prop::collection::vec((number(size.0), number(size.1)), 3..8), any::<bool>()).prop_map(|(mut ring, is_right)| {
        // Along rows and columns, every other time.
        for i in (1..ring.len()).filter(|_| is_right) {
            if i % 2 == 1 { ring[i].1 = ring[i - 1].1.round() } else { ring[i].0 = ring[i - 1].0.round() }
        }
        ring.push(ring[0]);
        ring
    })
}

fn cutlines() -> impl Strategy<Value = Scene> {
    scene().prop_flat_map(|scene| {
        let polygons = prop::collection::vec(prop::collection::vec(ring(scene.size), 1..3), 1..4);
        (Just(scene), polygons).prop_map(|(scene, cutline)| Scene { cutline, ..scene })
    })
}

impl Scene {
    /// The mesh ends where it should, and edges follow all lines inside.
    fn certify_cut(&self, params: &Params) {
        let Some((mesh, verdict)) = self.made(params) else { return };
        assert_eq!(verdict.broken.count, 0, "{verdict:?}");
        let segments = segments(params.breaklines.as_ref().expect("lines"), self.size);
        assert_eq!(verdict.segments, segments);
        let off_ground = mesh.chains().iter().map(|chains| chains.off_ground);
        assert!(verdict.off_ground <= off_ground.sum(), "{verdict:?}");
    }
}

proptest! {
    #![proptest_config(cases(60, 4000))]

    /// Outlines may cross themselves, each other and all lines, the raster's rim, seams and voids.
    #[test]
    fn meshes_end_at_outlines_over_random_rasters(
        scene in cutlines(), (quality, heights) in qualities(), engine in engines(), tile in 2usize..20,
        tolerance in prop_oneof![Just(0.5), Just(3.0), Just(20.0)], has_lines in any::<bool>(), max_stray in limits(),
    ) {
        let scene = Scene { lines: if has_lines { scene.lines.clone() } else { Vec::new() }, ..scene };
        scene.certify_cut(&Params { quality, heights, engine, tile, max_stray, ..scene.params(tolerance) });
    }
}

fn square(c: f64, r: f64, side: f64) -> Line {
    vec![(c, r), (c + side, r), (c + side, r + side), (c, r + side), (c, r)]
}

/// Twice the area in squared quarter cells, where the mesh passes.
fn area(scene: &Scene, tile: usize) -> i128 {
    let params = Params { tile, ..scene.params(1.0) };
    scene.certify_cut(&params);
    let (verdict, _, _) = scene.judged(&params).expect("ground");
    assert_eq!(verdict.double_area, verdict.expected_double_area);
    verdict.double_area
}

#[test]
fn the_mesh_has_the_area_of_its_polygons() {
    let whole = Scene::new((40, 30), 4, vec![]);
    let of = |cutline: &[Vec<Line>], tile: usize| area(&Scene { cutline: cutline.to_vec(), ..whole.clone() }, tile);
    let (a, b, hole) = (square(3.25, 2.5, 20.0), square(13.25, 7.5, 20.0), square(15.0, 10.0, 5.25));
    for tile in [0, 7, 16] {
        let one = of(&[vec![a.clone()]], tile);
        assert_eq!(one, 2 * 80 * 80);
        assert_eq!(of(&[vec![a.clone(), hole.clone()]], tile), one - 2 * 21 * 21);
        // Two polygons are one where they overlap, two rings of one are a hole there.
        let both = 2 * one - 2 * 40 * 60;
        assert_eq!(of(&[vec![a.clone()], vec![b.clone()]], tile), both);
        assert_eq!(of(&[vec![a.clone(), b.clone()]], tile), both - 2 * 40 * 60);
        assert_eq!(of(&[vec![a.clone()], vec![a.clone()], vec![hole.clone()]], tile), one);
        // As far as the raster goes.
        assert_eq!(of(&[vec![square(-7.5, -9.0, 20.0)]], tile), 2 * 50 * 44);
        assert_eq!(of(&[vec![square(-5.0, -5.0, 90.0)]], tile), 2 * 39 * 29 * 16);
    }
}

/// A half cell is no ground where the border comes into it, and ends where it does elsewhere.
#[test]
fn half_cells_are_inside_or_no_ground() {
    let mut scene = Scene { cutline: vec![vec![square(2.5, 2.5, 5.0)]], ..Scene::new((12, 12), 4, vec![]) };
    let whole = area(&scene, 0);
    // In the midst four halves are left around it, of four cells.
    scene.heights[5 * 12 + 5] = f64::NAN;
    assert_eq!(area(&scene, 0), whole - 4 * 16);
    // Of the cells around one at the border's corner, one is inside, one outside, and the border is in two.
    (scene.heights[5 * 12 + 5], scene.heights[3 * 12 + 3]) = (0.0, f64::NAN);
    assert_eq!(area(&scene, 0), whole - (2 * 2 * 2 + 2 * 2 * 2 * 4 + 16));
}

#[test]
fn meshes_that_end_elsewhere_are_found_out() {
    let scene = Scene { cutline: vec![vec![square(4.25, 3.75, 9.5)]], ..Scene::new((21, 16), 2, vec![]) };
    let params = Params { tile: 8, ..scene.params(1.0) };
    scene.certify_cut(&params);
    let judged = |made: &Scene| {
        let params = Params { breaklines: made.params(1.0).breaklines, ..params.clone() };
        let (verdict, _, lines) = scene.judged(&params).expect("ground");
        let cutline = verdict.cutline.expect("a cutline");
        assert!(!verdict.passes(), "{verdict}");
        (cutline.bare.count, cutline.beyond.count, lines.broken.count)
    };
    let (bare, beyond, broken) = judged(&Scene { cutline: vec![], ..scene.clone() });
    assert!(bare == 0 && beyond > 0 && broken > 0);
    // One step more, and one step less.
    let (bare, beyond, broken) = judged(&Scene { cutline: vec![vec![square(4.25, 3.75, 9.75)]], ..scene.clone() });
    assert!(bare == 0 && beyond > 0 && broken > 0);
    let (bare, beyond, broken) = judged(&Scene { cutline: vec![vec![square(4.5, 4.0, 9.25)]], ..scene.clone() });
    assert!(bare > 0 && beyond == 0 && broken > 0);
    let hole = vec![(8.25, 8.25), (8.5, 8.25), (8.25, 8.5), (8.25, 8.25)];
    let with_hole = Scene { cutline: vec![vec![square(4.25, 3.75, 9.5), hole]], ..scene.clone() };
    assert_eq!(judged(&with_hole), (1, 0, 0));
}

#[test]
fn degenerate_outlines() {
    let all: Vec<(&str, Vec<Line>)> = vec![
        ("in a cell", vec![vec![(4.1, 4.1), (4.9, 4.2), (4.3, 4.8), (4.1, 4.1)]]),
        ("in a step", vec![vec![(4.25, 4.25), (4.5, 4.25), (4.5, 4.5), (4.25, 4.25)]]),
        ("on a cell", vec![square(5.0, 4.0, 1.0)]),
        (
            "narrower than the lattice",
            vec![square(1.0, 1.0, 2.0), vec![(2.0, 2.0), (18.0, 9.05), (2.0, 2.05), (2.0, 2.0)]],
        ),
        ("three times", vec![vec![(2.0, 2.0), (12.0, 3.0), (9.0, 12.0), (2.0, 2.0)]; 3]),
        ("crosses itself", vec![vec![(2.0, 2.0), (15.0, 12.0), (15.0, 2.0), (2.0, 12.0), (2.0, 2.0)]]),
        ("all of the raster", vec![square(-3.0, -3.0, 40.0)]),
        ("on the rim", vec![vec![(0.0, 0.0), (20.0, 0.0), (20.0, 15.0), (0.0, 15.0), (0.0, 0.0)]]),
        ("all but a cell", vec![square(-3.0, -3.0, 40.0), square(9.0, 7.0, 1.0)]),
        ("half outside", vec![vec![(-3.0, 3.3), (9.6, 4.1), (8.2, 40.0), (-3.0, 3.3)]]),
        ("along seams", vec![square(8.0, 0.0, 8.0)]),
        ("a tile", vec![square(8.0, 8.0, 8.0)]),
        ("all but a tile", vec![square(-3.0, -3.0, 40.0), square(8.0, 0.0, 8.0)]),
        ("a corner of four tiles", vec![square(7.75, 7.75, 0.5)]),
        ("rings that touch", vec![square(3.0, 3.0, 5.0), square(8.0, 8.0, 4.0), square(8.0, 4.0, 2.0)]),
        ("ring in ring in ring", vec![square(1.0, 1.0, 13.0), square(3.0, 3.0, 9.0), square(5.0, 5.0, 4.5)]),
        ("not closed", vec![vec![(2.0, 2.0), (12.0, 3.0), (9.0, 12.0)]]),
        ("on samples' diagonals", vec![vec![(8.0, 1.0), (15.0, 8.0), (8.0, 15.0), (1.0, 8.0), (8.0, 1.0)]]),
    ];
    for (name, rings) in all {
        for (gaps, quality) in [(0, Quality::None), (40, Quality::Balanced)] {
            let scene = Scene { cutline: vec![rings.clone()], ..Scene::new((21, 16), 5, vec![]) }.with_gaps(4, gaps);
            println!("{name}, {gaps} gaps, {quality:?}");
            scene.certify_cut(&Params { tile: 8, quality, ..scene.params(1.5) });
        }
    }
}

#[test]
fn nothing_is_left_where_nothing_is_inside() {
    let outside = vec![square(-9.0, 3.0, 5.0), vec![], vec![(4.0, 4.0)], vec![(5.0, 5.0), (9.0, 9.0), (5.0, 5.0)]];
    let scene = Scene { cutline: vec![outside], ..Scene::new((21, 16), 5, vec![]) };
    let params = scene.params(1.0);
    assert!(params.breaklines.as_ref().expect("lines").leave_nothing());
    assert!(scene.judged(&params).is_none());
}

#[test]
fn meshes_do_not_depend_on_threads() {
    let lake = (0..40).map(|i| (45.0 + 40.0 * (f64::from(i) * 0.16).cos(), 30.0 + 25.0 * (f64::from(i) * 0.16).sin()));
    let road = vec![(2.0, 30.0), (88.0, 33.0)];
    let scene = Scene { cutline: vec![vec![lake.collect()]], ..Scene::new((90, 61), 3, vec![road]) }.with_gaps(11, 9);
    let params = Params { tile: 16, ..scene.params(2.0) };
    scene.certify_cut(&params);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            scene.made(&params).expect("ground").0.chunks().map(|c| c.expect("a chunk")).collect::<Vec<_>>()
        })
    };
    assert_eq!(with(1), with(3));
}
