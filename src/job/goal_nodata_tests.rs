//! Goals over rasters with missing samples: budgets and root mean squares, and whether tiles tell what they do.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use proptest::prelude::*;

use super::goal::{Cost, Floor, Told};
use super::nodata_tests::{Place, Scene, scene};
use super::passes::End;
use super::passes::{Job, Links, TileMaker};
use super::tests::{geotiff, told};
use super::*;
use crate::base::control::Control;
use crate::base::lattice::{Point, orient};
use crate::base::staged::StagedFile;
use crate::field::{Field, FieldOptions};
use crate::formats::{Header, PlySink};
use crate::kernel::measure::{Bare, Bound, measure};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::insertion::{DataDependent, GreedyInsertion, InsertionOptions, Swap};
use crate::kernel::triangulate::progressive::Key;
use crate::raster::Raster;
use crate::testing::{self, cases};
use crate::verify::{VerifyOptions, verify};

/// What the errors of heights such as 0.1 are off by, as they are measured in doubles.
const ROUNDING: f64 = 1e-12;

fn params(goal: Goal, max_error: f64, tile: usize) -> Params {
    let engine = EngineChoice::GreedyInsertion(GreedyInsertion::default());
    Params { engine, goal, tile, quality: Quality::None, ..Params::new(max_error) }
}

impl Scene {
    /// Makes the mesh, writes it and has it judged: the ground and nothing else, as close as was measured.
    fn certified(&self, params: &Params) -> Result<(Mesh, Summary), Error> {
        let folder = testing::folder();
        let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
        geotiff(&dem, self.width, self.height, &self.heights);
        let raster = Raster::open(&dem, 1).expect("opens");
        let field = Field::open(&raster.to_band().expect("a band"), &FieldOptions::default(), &Control::default())
            .expect("a field");
        let mesh = triangulate(&field, &testing::in_memory(params), &Control::default())?;
        let sink = PlySink::new(StagedFile::create(&tin, false, &[&dem]).expect("staged"), Header::default());
        let summary = mesh.write(Box::new(sink), &Control::default()).expect("written");
        let max_error = allowed(&mesh, &summary, params);
        let options = VerifyOptions {
            lines: None,
            max_error,
            max_stray: None,
            importance: None,
            temp_dir: Some(folder.path().to_path_buf()),
        };
        let verdict = verify(&raster.to_band().expect("a band"), &tin, &options, &Control::default()).expect("judged");
        assert!(verdict.passes(), "{:?} for {params:?}", verdict.failures());
        let (cells, written) = (self.cells(), told(&mesh));
        let ground: BTreeSet<Place> = cells.iter().flatten().copied().collect();
        assert_eq!(summary.errors.samples, ground.len() as u64);
        self.check_mesh(
            &written,
            &cells,
            &ground,
            &Params { tolerance: crate::base::Tolerance::new(max_error), ..params.clone() },
        );
        for threads in [1, 3] {
            let again = self.mesh(params, threads)?;
            assert!(again.outcome() == mesh.outcome() && told(&again) == written, "{threads} threads");
        }
        Ok((mesh, summary))
    }

    /// The root of the mean square error, sample by sample and triangle by triangle.
    fn naive_rms(&self, mesh: &Mesh) -> f64 {
        let written = told(mesh);
        let mut squares: BTreeMap<Place, f64> = BTreeMap::new();
        for corners in &written.triangles {
            let corners = corners.map(|v| written.vertices[v as usize]);
            let at = corners.map(|[x, y, _]| Point { x: ((x - 0.5) * 4.0) as i32, y: ((-y - 0.5) * 4.0) as i32 });
            let [a, b, c] = at;
            for (column, row) in self.places() {
                let p = Point::of_sample(column, row);
                let weights = [orient(b, c, p), orient(c, a, p), orient(a, b, p)];
                // Rows run down, so the lattice's sense of turning is not the map's.
                if weights.iter().all(|w| *w <= 0) {
                    let surface: f64 = weights.iter().zip(corners).map(|(w, [.., z])| *w as f64 * z).sum();
                    let error = surface / orient(a, b, c) as f64 - self.at((column, row)).expect("a height");
                    squares.insert((column, row), error * error);
                }
            }
        }
        (squares.values().sum::<f64>() / squares.len() as f64).sqrt()
    }
}

/// What the errors of a mesh are within. What was measured is rounded.
fn allowed(mesh: &Mesh, summary: &Summary, params: &Params) -> f64 {
    let reached = mesh.outcome().is_some_and(|o| o.ended_by.is_none()) && !params.tolerance.is_open();
    if reached { params.tolerance.kept() } else { summary.errors.max * (1.0 + ROUNDING) + ROUNDING }
}

fn sizes() -> impl Strategy<Value = (usize, usize)> {
    (2usize..=16, 2usize..=16)
}

fn tiles() -> impl Strategy<Value = usize> {
    prop_oneof![Just(0usize), 1usize..=7]
}

proptest! {
    #![proptest_config(cases(100, 400))]

    #[test]
    fn budgets_are_spent_and_never_exceeded(
        (width, height) in sizes(), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5, tile in tiles(),
        budget in 0u64..250, by_triangles in any::<bool>(), swap in any::<bool>(), strong in any::<bool>(),
        max_error in prop_oneof![Just(f64::INFINITY), Just(0.0), Just(1.0)],
        points in prop::collection::vec(0usize..256, 0..4),
    ) {
        let scene = scene(width, height, seed, kind, holes);
        let mut goal = Goal::default();
        *(if by_triangles { &mut goal.max_triangles } else { &mut goal.max_points }) = Some(budget);
        let mut params = params(goal, max_error, tile);
        if swap {
            let swap = Swap::DataDependent(DataDependent::default());
            params.engine = EngineChoice::GreedyInsertion(GreedyInsertion { options: InsertionOptions { swap, ..InsertionOptions::default() } });
        }
        params.feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        params.points = Some(Arc::new(scene.points_of(points)));
        let (mesh, summary) = match scene.certified(&params) {
            Ok(made) => made,
            Err(Error::Goal(small)) => {
                prop_assert!(small.smallest > budget && small.found == budget);
                // The smallest is no less than what is needed, and enough.
                let goal = if by_triangles { Goal { max_triangles: Some(small.smallest), ..goal } }
                    else { Goal { max_points: Some(small.smallest), ..goal } };
                let (_, summary) = scene.certified(&Params { goal, ..params }).expect("a mesh");
                prop_assert_eq!(if by_triangles { summary.triangles } else { summary.vertices }, small.smallest);
                return Ok(());
            }
            Err(error) => {
                prop_assert!(matches!(error, Error::NoGround { .. }) && scene.cells().is_empty(), "{}", error);
                return Ok(());
            }
        };
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
                prop_assert!(summary.errors.max <= allowed + ROUNDING || strong, "{}", summary.errors.max);
            }
        }
    }

    #[test]
    fn a_root_mean_square_is_reached(
        (width, height) in sizes(), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5, tile in tiles(),
        rms in prop_oneof![Just(0.0), 0.01f64..3.0], max_error in prop_oneof![Just(f64::INFINITY), Just(1.5)],
    ) {
        let scene = scene(width, height, seed, kind, holes);
        if scene.cells().is_empty() {
            return Ok(());
        }
        let goal = Goal { max_rms: Some(rms), ..Goal::default() };
        let (mesh, summary) = scene.certified(&params(goal, max_error, tile)).expect("a mesh");
        prop_assert_eq!(mesh.outcome().expect("a goal").ended_by, None);
        prop_assert!(summary.errors.rms() <= rms + ROUNDING, "{}", summary.errors.rms());
        prop_assert!(summary.errors.max <= max_error);
        let naive = scene.naive_rms(&mesh);
        prop_assert!((naive - summary.errors.rms()).abs() <= 1e-9 * naive + ROUNDING, "{} {}", naive, summary.errors.rms());
    }

    /// Wherever all tiles end, vertices, triangles and squared errors are what they told.
    #[test]
    fn tiles_do_what_they_told(
        (width, height) in sizes(), seed in any::<u64>(), kind in 0u8..4, holes in 0u8..5, tile in tiles(),
        share in 0.0f64..1.2, swap in any::<bool>(), weighted in any::<bool>(),
        lowest in prop_oneof![Just(0.0), Just(0.7)],
    ) {
        let mut scene = scene(width, height, seed, kind, holes);
        if weighted {
            scene.weigh();
        }
        let swap = if swap { Swap::DataDependent(DataDependent::default()) } else { Swap::Delaunay };
        let options = InsertionOptions { swap, ..InsertionOptions::default() };
        let goal = Goal { max_rms: Some(0.0), ..Goal::default() };
        let params = Params { engine: EngineChoice::GreedyInsertion(GreedyInsertion { options }), ..params(goal, f64::INFINITY, tile) };
        let (field, control) = (scene.field(), Control::default());
        let grid = grid(width, height, &params).expect("a grid");
        let mut job = Job { field: &field, params: &params, max_stray: f64::INFINITY, links: Links::Fewest, grid, polishes_seams: false, control: &control, end: None, chains: None };
        let mut workspace = TileMaker::default();
        let (mut all, mut samples) = (Vec::<Told>::new(), 0);
        for index in 0..grid.len() {
            samples += workspace.tell(&job, params.engine.progressive().expect("one at a time"), &grid.place(index), lowest, &Floor::new(&goal, lowest)).expect("told");
            prop_assert!(workspace.told.is_sorted_by_key(|t| t.key), "{:?}", workspace.told);
            all.extend(workspace.told.iter().copied());
        }
        let mut keys: Vec<Key> = all.iter().map(|t| t.key).collect();
        keys.sort_unstable();
        let cut = keys[((keys.len() as f64 * share) as usize).min(keys.len() - 1)];
        let expected = all.iter().filter(|t| t.key <= cut);
        let (mut cost, mut squares) = (Cost::default(), 0.0);
        for t in expected {
            cost = Cost { points: cost.points + t.cost.points, triangles: cost.triangles + t.cost.triangles };
            squares += t.squares;
        }
        let end = End { cut, lowest, outcome: Outcome { ended_by: None, threshold: 0.0, search: None }, survey_bytes: 0 };
        job.end = Some(end);
        let (mut found, mut errors) = (Cost::default(), crate::kernel::measure::ErrorStats::default());
        for index in 0..grid.len() {
            let (rim, _) = workspace.run_to(&job, &grid.place(index), &end).expect("a mesh");
            let mesh = &workspace.mesh;
            let owned = mesh.vertices.len() + rim.idle.len() - rim.foreign.len();
            found = Cost { points: found.points + owned as u64, triangles: found.triangles + mesh.triangles.len() as u64 };
            errors.add(&measure(&workspace.shared.tile, mesh, Bound::Scale(1.0), &grid.place(index), Bare::Nothing));
        }
        prop_assert_eq!((cost, samples), (found, errors.samples));
        let most = scene.heights.iter().filter(|z| !z.is_nan()).fold(1.0f64, |most, z| most.max(z.abs()));
        let rounding = 1e-9 * most * most * samples as f64;
        prop_assert!((squares - errors.squares).abs() <= rounding, "told {}, found {}", squares, errors.squares);
    }
}

/// Every pattern of 3 × 3 samples, cut into tiles of one cell and in one piece.
#[test]
fn every_small_ground() {
    let mut cases = 0usize..;
    for pattern in 0u32..512 {
        let height = |i: usize| if pattern >> i & 1 == 1 { (i * i % 5) as f64 } else { f64::NAN };
        let heights = (0..9).map(height).collect();
        let scene = Scene::new(3, 3, heights);
        for tile in [0, 1] {
            for (goal, max_error) in [
                (Goal { max_points: Some(7), ..Goal::default() }, f64::INFINITY),
                (Goal { max_triangles: Some(5), ..Goal::default() }, 0.5),
                (Goal { max_rms: Some(0.5), ..Goal::default() }, f64::INFINITY),
            ] {
                // One in five of the 3072; patterns, tiles and goals take turns.
                if cases.next().is_some_and(|case| case % 5 > 0) && !testing::is_long() {
                    continue;
                }
                match scene.certified(&params(goal, max_error, tile)) {
                    Err(Error::NoGround { .. }) => assert!(scene.cells().is_empty()),
                    Err(Error::Goal(_)) => {}
                    made => drop(made.expect("a mesh")),
                }
            }
        }
    }
}

#[test]
fn larger_grounds_with_many_holes() {
    for holes in 0..5 {
        let scene = scene(70, 60, 5, 1, holes);
        let smallest = match scene.mesh(&params(Goal { max_points: Some(0), ..Goal::default() }, f64::INFINITY, 24), 2)
        {
            Err(Error::Goal(small)) => small.smallest,
            other => panic!("{other:?}"),
        };
        let mut last = f64::INFINITY;
        for more in [0, 20, 100, 300] {
            let goal = Goal { max_points: Some(smallest + more), ..Goal::default() };
            let (mesh, summary) = scene.certified(&params(goal, f64::INFINITY, 24)).expect("a mesh");
            let outcome = mesh.outcome().expect("a goal");
            assert!(summary.vertices == smallest + more || outcome.ended_by.is_none());
            assert!(outcome.threshold <= last);
            last = outcome.threshold;
        }
        for rms in [8.0, 2.0, 0.3] {
            let goal = Goal { max_rms: Some(rms), ..Goal::default() };
            let (_, summary) = scene.certified(&params(goal, f64::INFINITY, 24)).expect("a mesh");
            assert!(summary.errors.rms() <= rms);
        }
    }
}
