//! Lakes all the way from polygons to a written mesh, judged by the verifier, which reckons them again.

use proptest::prelude::*;

use super::breakline_tests::{Line, Scene, engines, limits, qualities, scene};
use super::*;
use crate::base::LineKind;
use crate::kernel::breaklines::{Breaklines, LinesError};
use crate::testing::cases;
use crate::verify::{RequiredLines, VerifyError};

fn ring(size: (usize, usize)) -> impl Strategy<Value = Line> {
    let number = |last: usize| {
        let last = last as f64 - 1.0;
        prop_oneof![3 => -2.0..last + 2.0, 1 => (0.0..last).prop_map(f64::round), 1 => prop_oneof![Just(0.0), Just(last)]]
    };
    prop::collection::vec((number(size.0), number(size.1)), 3..7).prop_map(|mut ring| {
        ring.push(ring[0]);
        ring
    })
}

fn lakes() -> impl Strategy<Value = Scene> {
    scene().prop_flat_map(|scene| {
        // Mostly one: those of random rings overlap.
        let lake = (prop_oneof![-5.0..40.0f64, Just(0.0)], prop::collection::vec(ring(scene.size), 1..3));
        let count = prop_oneof![4 => Just(1usize), 1 => Just(2)];
        let lakes = (count, prop::collection::vec(lake, 2)).prop_map(|(count, all)| all[..count].to_vec());
        (Just(scene), lakes).prop_map(|(scene, lakes)| Scene { lakes, ..scene })
    })
}

proptest! {
    #![proptest_config(cases(80, 2000))]

    /// Outlines may cross themselves, each other and all lines, the raster's rim, seams and voids.
    #[test]
    fn lakes_are_level_over_random_rasters(
        scene in lakes(), (quality, heights) in qualities(), engine in engines(), tile in 2usize..20,
        tolerance in prop_oneof![Just(0.5), Just(3.0), Just(20.0)], has_lines in any::<bool>(), max_stray in limits(),
    ) {
        let scene = Scene { lines: if has_lines { scene.lines.clone() } else { Vec::new() }, ..scene };
        let made = Breaklines::new(&scene.sets(), scene.size);
        match (RequiredLines::new(&scene.sets(), scene.size, tolerance, None, &Default::default()), made) {
            (Ok(_), Ok(lines)) => {
                prop_assert!(lines.check_heights(tolerance).is_ok());
                scene.certify(&Params { quality, heights, engine, tile, max_stray, ..scene.params(tolerance) });
            }
            (Err((_, VerifyError::LakesOverlap { .. })), Err((LineKind::Lakes, LinesError::Overlap { .. }))) => {}
            (Err((_, VerifyError::TwoHeights { .. })), Ok(lines)) => {
                prop_assert!(lines.check_heights(tolerance).is_err());
            }
            (theirs, ours) => panic!("{theirs:?} and {ours:?}"),
        }
    }
}

#[test]
fn lakes_are_level_with_islands_over_seams_and_under_lines() {
    let square = |c: f64, r: f64, side: f64| vec![(c, r), (c + side, r), (c + side, r + side), (c, r + side), (c, r)];
    let road = vec![(2.0, 3.0), (38.0, 26.0)];
    let lakes =
        vec![(12.5, vec![square(5.3, 4.2, 17.6), square(10.1, 9.9, 6.3)]), (-4.0, vec![square(30.0, 3.0, 5.0)])];
    let scene = Scene { lakes, ..Scene::new((41, 30), 4, vec![road]) };
    let params = Params { tile: 16, ..scene.params(1.0) };
    scene.certify(&params);
    let (mesh, verdict) = scene.made(&params).expect("ground");
    assert_eq!(verdict.lakes, 2);
    let lines = params.breaklines.as_ref().expect("lines");
    // 17 × 18 samples less 6 × 7 within the island, and 6 × 6 on the outline and inside.
    assert!((270..=310).contains(&lines.in_lakes()), "{}", lines.in_lakes());
    let levels = mesh.chunks().flat_map(|chunk| chunk.expect("a chunk").vertices);
    assert!(levels.filter(|v| v.height == 12.5).count() >= 8);
    // Fitted heights keep to the level, too, and another level is found out, as is none.
    scene.certify(&Params { heights: VertexHeights::Fitted, ..params.clone() });
    let without = Scene { lakes: Vec::new(), ..scene.clone() };
    let (verdict, _, lines) =
        scene.judged(&Params { breaklines: without.params(1.0).breaklines, ..params.clone() }).expect("ground");
    assert!(!verdict.passes() && lines.broken.count > 0 && lines.not_level.count > 0, "{verdict} {lines}");
    let mut higher = scene.clone();
    higher.lakes[1].0 = -3.9;
    let (verdict, _, lines) = higher.judged(&params).expect("ground");
    assert!(verdict.passes() && lines.not_level.count == 0, "{verdict} {lines}");
    higher.lakes[1].0 = -2.9;
    let (verdict, _, lines) = higher.judged(&params).expect("ground");
    assert!(!verdict.passes() && lines.not_level.count > 0, "{verdict} {lines}");

    let cross = Scene { lakes: vec![scene.lakes[0].clone(), (3.0, vec![square(20.0, 20.0, 6.0)])], ..scene.clone() };
    let refused = Breaklines::new(&cross.sets(), cross.size);
    assert_eq!(refused.unwrap_err(), (LineKind::Lakes, LinesError::Overlap { features: [0, 1] }));
    // Nor may lakes touch that have two levels.
    let touch = Scene { lakes: vec![(3.0, vec![square(4.0, 4.0, 4.0)]), (3.5, vec![square(8.0, 4.0, 4.0)])], ..scene };
    let lines = Breaklines::new(&touch.sets(), touch.size).expect("lakes");
    assert!(
        lines.check_heights(9.0).is_err()
            && RequiredLines::new(&touch.sets(), touch.size, 9.0, None, &Default::default()).is_err()
    );
}

#[test]
fn degenerate_lakes() {
    let all: Vec<(&str, Vec<Line>)> = vec![
        ("nothing", vec![vec![], vec![(5.0, 5.0)], vec![(9.0, 9.0), (9.02, 9.01), (9.0, 9.0)]]),
        ("in a cell", vec![vec![(4.1, 4.1), (4.9, 4.2), (4.3, 4.8), (4.1, 4.1)]]),
        ("narrower than the lattice", vec![vec![(2.0, 2.0), (18.0, 9.05), (2.0, 2.05), (2.0, 2.0)]]),
        ("twice", vec![vec![(2.0, 2.0), (12.0, 3.0), (9.0, 12.0), (2.0, 2.0)]; 2]),
        ("crosses itself", vec![vec![(2.0, 2.0), (15.0, 12.0), (15.0, 2.0), (2.0, 12.0), (2.0, 2.0)]]),
        ("all of the raster", vec![vec![(-3.0, -3.0), (30.0, -3.0), (30.0, 30.0), (-3.0, 30.0), (-3.0, -3.0)]]),
        ("on the rim", vec![vec![(0.0, 0.0), (20.0, 0.0), (20.0, 15.0), (0.0, 15.0), (0.0, 0.0)]]),
        ("half outside", vec![vec![(-3.0, 3.3), (9.6, 4.1), (8.2, 40.0), (-3.0, 3.3)]]),
        ("along seams", vec![vec![(8.0, 0.0), (16.0, 0.0), (16.0, 8.0), (8.0, 8.0), (8.0, 0.0)]]),
        ("not closed", vec![vec![(2.0, 2.0), (12.0, 3.0), (9.0, 12.0)]]),
    ];
    for (name, rings) in all {
        for (gaps, quality) in [(0, Quality::None), (0, Quality::Balanced), (30, Quality::Balanced)] {
            let scene =
                Scene { lakes: vec![(7.0, rings.clone())], ..Scene::new((21, 16), 5, vec![]) }.with_gaps(4, gaps);
            println!("{name}, {gaps} gaps, {quality:?}");
            scene.certify(&Params { tile: 8, quality, ..scene.params(1.5) });
        }
    }
}
