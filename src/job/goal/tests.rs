//! Goals over rasters without gaps: budgets and root mean squares are kept, and are the same whatever the tiles.

use std::sync::Arc;

use proptest::prelude::*;

use super::super::tests::{geotiff, terrain, told};
use super::super::{Budget, EngineChoice, Error, Goal, Mesh, Params, Quality, Summary, triangulate};
use crate::base::PointSet;
use crate::base::control::Control;
use crate::base::staged::StagedFile;
use crate::field::{Field, FieldOptions};
use crate::formats::{Header, PlySink};
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::{DataDependent, GreedyInsertion, InsertionOptions, Selection, Swap};
use crate::raster::Raster;
use crate::testing;
use crate::verify::{VerifyOptions, verify};

fn params(goal: Goal, max_error: f64, tile: usize) -> Params {
    let engine = EngineChoice::GreedyInsertion(GreedyInsertion::default());
    Params { engine, goal, tile, quality: Quality::None, ..Params::new(max_error) }
}

/// Makes the mesh, writes it and has it judged: one surface, as close as was measured.
fn made(width: usize, height: usize, heights: &[f64], params: &Params) -> (Mesh, Summary) {
    let folder = testing::folder();
    let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
    geotiff(&dem, width, height, heights);
    let raster = Raster::open(&dem, 1).expect("opens");
    let field = Field::open(&raster.to_band().expect("a band"), &FieldOptions::default(), &Control::default())
        .expect("a field");
    let mesh = triangulate(&field, &testing::in_memory(params), &Control::default()).expect("a mesh");
    let sink = PlySink::new(StagedFile::create(&tin, false, &[&dem]).expect("staged"), Header::default());
    let summary = mesh.write(Box::new(sink), &Control::default()).expect("written");
    // What was measured is rounded.
    let max_error = if mesh.outcome().is_some_and(|o| o.ended_by.is_none()) && !params.tolerance.is_open() {
        params.tolerance.kept()
    } else {
        summary.errors.max * (1.0 + 1e-12) + 1e-12
    };
    let options = VerifyOptions { lines: None, max_error, max_stray: None, importance: None, temp_dir: None };
    let verdict = verify(&raster.to_band().expect("a band"), &tin, &options, &Control::default()).expect("judged");
    assert!(verdict.passes(), "{:?} for {params:?}", verdict.failures());
    (mesh, summary)
}

fn ground(kind: u8, seed: u64, width: usize, height: usize) -> Vec<f64> {
    let noise = |i: usize| (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 48;
    match kind {
        // Many errors tie.
        0 => (0..width * height).map(|i| (noise(i) % 5) as f64).collect(),
        1 => terrain(seed % 64, width, height),
        _ => vec![3.5; width * height],
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn budgets_are_spent_and_never_exceeded(
        size in (2usize..40, 2usize..40), seed in any::<u64>(), kind in 0u8..3, tile in prop_oneof![Just(0usize), 3usize..20],
        budget in 0u64..600, by_triangles in any::<bool>(), max_error in prop_oneof![Just(f64::INFINITY), Just(0.0), Just(1.0)],
    ) {
        let (width, height) = size;
        let heights = ground(kind, seed, width, height);
        let mut goal = Goal::default();
        *(if by_triangles { &mut goal.max_triangles } else { &mut goal.max_points }) = Some(budget);
        let params = params(goal, max_error, tile);
        let field = Field::from_heights(width, height, crate::base::Heights::F64(heights.clone())).expect("a field");
        if let Err(error) = triangulate(&field, &params, &Control::default()) {
            let Error::Goal(small) = error else { panic!("{error}") };
            prop_assert!(small.smallest > budget && small.found == budget);
            return Ok(());
        }
        let (mesh, summary) = made(width, height, &heights, &params);
        let used = if by_triangles { summary.triangles } else { summary.vertices };
        prop_assert!(used <= budget);
        match mesh.outcome().expect("a goal").ended_by {
            // The next insertion would have cost 1 vertex, or up to 2 triangles.
            Some(by) => {
                prop_assert_eq!(by, if by_triangles { Budget::MaxTriangles } else { Budget::MaxPoints });
                prop_assert!(budget - used <= u64::from(by_triangles), "{} of {}", used, budget);
            }
            None => {
                let allowed = if max_error.is_finite() { max_error } else { 0.0 };
                prop_assert!(summary.errors.max <= allowed, "{}", summary.errors.max);
            }
        }
    }

    #[test]
    fn a_root_mean_square_is_reached(
        size in (2usize..40, 2usize..40), seed in any::<u64>(), kind in 0u8..3, tile in prop_oneof![Just(0usize), 3usize..20],
        rms in prop_oneof![Just(0.0), 0.01f64..2.0], max_error in prop_oneof![Just(f64::INFINITY), Just(1.5)],
    ) {
        let (width, height) = size;
        let heights = ground(kind, seed, width, height);
        let goal = Goal { max_rms: Some(rms), ..Goal::default() };
        let (mesh, summary) = made(width, height, &heights, &params(goal, max_error, tile));
        prop_assert_eq!(mesh.outcome().expect("a goal").ended_by, None);
        prop_assert!(summary.errors.rms() <= rms, "{}", summary.errors.rms());
        prop_assert!(summary.errors.max <= max_error);
    }
}

/// A larger budget is a smaller error, roughly; and threads change nothing.
#[test]
fn the_same_goal_gives_the_same_mesh_on_any_number_of_threads() {
    let heights = terrain(7, 150, 130);
    for swap in [Swap::Delaunay, Swap::DataDependent(DataDependent::default())] {
        let options = InsertionOptions { swap, ..InsertionOptions::default() };
        let mut last = f64::INFINITY;
        for points in [100, 400, 1600] {
            let goal = Goal { max_points: Some(points), ..Goal::default() };
            let engine = EngineChoice::GreedyInsertion(GreedyInsertion { options });
            let params = Params { engine, ..params(goal, f64::INFINITY, 32) };
            let on = |threads: usize| {
                let field = Field::from_heights(150, 130, crate::base::Heights::F64(heights.clone())).expect("a field");
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
                let mesh = pool.install(|| triangulate(&field, &params, &Control::default())).expect("a mesh");
                let chunks: Vec<_> = mesh.chunks().map(|c| c.expect("a chunk")).collect();
                (mesh.outcome(), chunks)
            };
            let (one, three) = (on(1), on(3));
            assert!(one == three, "{points} points");
            let threshold = one.0.expect("a goal").threshold;
            assert!(threshold < last, "{threshold} after {last}");
            last = threshold;
        }
    }
}

/// On a side of a tile as well as inside.
#[test]
fn points_are_vertices_under_any_goal() {
    let heights = terrain(3, 50, 40);
    let points = [(16, 5), (9, 16), (33, 32), (20, 20)];
    let loose = Goal { max_rms: Some(1e6), ..Goal::default() };
    let params = Params { points: Some(Arc::new(PointSet::new(points))), ..params(loose, f64::INFINITY, 16) };
    let (mesh, summary) = made(50, 40, &heights, &params);
    let corners = (mesh.grid().columns() as u64 + 1) * (mesh.grid().rows() as u64 + 1);
    assert_eq!(summary.vertices, corners + 4);
    let vertices = told(&mesh).vertices;
    for (column, row) in points {
        let place = [column as f64 + 0.5, -(row as f64) - 0.5, heights[row * 50 + column]];
        assert!(vertices.contains(&place), "{place:?}");
    }
    let field = Field::from_heights(50, 40, crate::base::Heights::F64(heights)).expect("a field");
    let goal = Goal { max_points: Some(corners + 3), ..Goal::default() };
    let refused = triangulate(&field, &Params { goal, ..params }, &Control::default());
    assert!(matches!(refused, Err(Error::Goal(small)) if small.smallest == corners + 4), "{refused:?}");
}

/// What does not stop at a goal by itself has a tolerance looked for.
#[test]
fn other_engines_and_orders_keep_to_a_budget_too() {
    let field = Field::from_heights(60, 50, crate::base::Heights::F64(terrain(3, 60, 50))).expect("a field");
    let goal = Goal { max_points: Some(250), ..Goal::default() };
    let engine = EngineChoice::GreedyCuts(GreedyCuts::PLAIN);
    let cuts = Params { engine, goal, quality: Quality::None, ..Params::new(f64::INFINITY) };
    let options = InsertionOptions { selection: Selection::Constant, ..InsertionOptions::default() };
    let passes = Params { engine: EngineChoice::GreedyInsertion(GreedyInsertion { options }), ..cuts.clone() };
    for params in [cuts, passes] {
        let mesh = triangulate(&field, &params, &Control::default()).expect("a mesh");
        let outcome = mesh.outcome().expect("a goal");
        let share = outcome.search.and_then(|search| search.share).expect("a search");
        assert!(outcome.ended_by == Some(Budget::MaxPoints) && (0.9..=1.0).contains(&share), "{outcome:?}");
    }
}
