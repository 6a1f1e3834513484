//! Searches: over counts that are made up, and over meshes.

use std::collections::HashMap;

use proptest::prelude::*;

use super::figures::SHARE;
use super::hunt::{Aim, Bench, Found, Hunt, Preview};
use super::*;
use crate::base::Heights;
use crate::job::tests::{certify_weighted, terrain};
use crate::job::{Goal, Quality, triangulate as make};
use crate::testing::cases;

/// Counts that fall with the tolerance, at a rate that is not the previews', and jump down where it is a multiple of 1.
struct Made {
    triangles: f64,
    rate: f64,
    bend: f64,
    jump: f64,
    /// The share of all triangles that previews see.
    seen: f64,
    previews: Vec<Preview>,
    tries: usize,
    runs: Vec<f64>,
}

impl Made {
    fn count(&self, tolerance: f64, rate: f64, bias: f64) -> Figures {
        let smooth = self.triangles * bias / (1e-9 + tolerance).powf(rate) / (1.0 + self.bend * tolerance);
        let steps = if tolerance >= 1.0 { 1.0 / (1.0 + self.jump) } else { 1.0 };
        let triangles = (smooth * steps).min(1e12) as u64 + 2;
        Figures { vertices: triangles / 2 + 2, triangles, rms: 0.37 * tolerance, largest: tolerance }
    }
}

impl Bench for Made {
    fn previews(&self) -> &[Preview] {
        &self.previews
    }

    fn preview(&mut self, number: usize, tolerance: f64) -> Result<Figures, Error> {
        self.tries += 1;
        Ok(self.count(tolerance, self.rate + 0.1, self.seen * if number == 0 { 2.3 } else { 0.8 }))
    }

    fn run(&mut self, tolerance: f64) -> Result<Figures, Error> {
        assert!(!self.runs.contains(&tolerance), "{tolerance} again");
        self.runs.push(tolerance);
        Ok(self.count(tolerance, self.rate, 1.0))
    }

    fn keep(&mut self, _: Option<f64>) -> Result<(), Error> {
        Ok(())
    }

    fn start(&self) -> f64 {
        3.0
    }

    fn span(&self) -> f64 {
        1e6
    }

    fn step(&self) -> Option<f64> {
        (self.jump > 0.0).then_some(1.0)
    }
}

fn made(triangles: f64, rate: f64, jump: f64) -> Made {
    let previews = vec![Preview { near: 0.1, bias: 0.42 }, Preview { near: 0.04, bias: 1.0 }];
    Made { triangles, rate, bend: 0.0, jump, seen: 1.0, previews, tries: 0, runs: Vec::new() }
}

fn aim(goal: Goal, coarsest: f64) -> Aim {
    Aim { goal, coarsest, finest: 0.0 }
}

fn triangles(most: u64) -> Goal {
    Goal { max_triangles: Some(most), ..Goal::default() }
}

fn share(found: &Found, most: u64) -> f64 {
    found.figures.triangles as f64 / most as f64
}

proptest! {
    #![proptest_config(cases(300, 20_000))]

    #[test]
    fn a_budget_is_spent_and_never_exceeded(
        triangles_at_1 in 100.0..1e9f64, rate in 0.6..1.4f64, bend in 0.0..0.2f64, jump in prop_oneof![Just(0.0), 0.05..0.5f64],
        tolerance in 0.01..1000.0f64, levels in 1usize..3,
    ) {
        let mut bench = Made { bend, ..made(triangles_at_1, rate, jump) };
        bench.previews.truncate(levels);
        let most = bench.count(tolerance, rate, 1.0).triangles;
        prop_assume!(most >= 300);
        let found = Hunt::new(&mut bench, aim(triangles(most), f64::INFINITY)).finish().expect("found");
        prop_assert!(found.figures.triangles <= most);
        let is_between = found.beyond.is_some_and(|(low, figures)| {
            figures.triangles > most && found.tolerance - low <= 1e-3 * found.tolerance
        });
        prop_assert!(share(&found, most) >= SHARE || is_between, "{found:?}, {most}");
        let most_runs = if jump > 0.0 { 6 } else { 4 };
        prop_assert!(found.runs <= most_runs, "{:?}", bench.runs);
        prop_assert!(bench.tries <= 30, "{} tries", bench.tries);
    }

    #[test]
    fn a_root_mean_square_is_reached_and_not_by_far(rms in 0.001..1000.0f64, levels in 1usize..3) {
        let mut bench = made(1e6, 1.0, 0.0);
        bench.previews.truncate(levels);
        let goal = Goal { max_rms: Some(rms), ..Goal::default() };
        let found = Hunt::new(&mut bench, aim(goal, f64::INFINITY)).finish().expect("found");
        prop_assert!(found.figures.rms <= rms && found.figures.rms >= SHARE * rms);
        prop_assert_eq!(found.ended_by, None);
        prop_assert!(found.runs <= 2, "{:?}", bench.runs);
    }
}

/// Nothing is too small to be asked for, or too large.
#[test]
fn a_root_mean_square_may_be_any_number() {
    for rms in [0.0, f64::from_bits(1), 1e-320, 1e-300, 1e300, f64::MAX] {
        for levels in 0..3 {
            let mut bench = made(1e6, 1.0, 0.25);
            bench.previews.truncate(levels);
            let goal = Goal { max_rms: Some(rms), max_points: Some(1 << 50), ..Goal::default() };
            let coarsest = if rms == 0.0 { 0.0 } else { f64::INFINITY };
            let found = Hunt::new(&mut bench, aim(goal, coarsest)).finish().expect("found");
            assert!(found.figures.rms <= rms && found.ended_by.is_none(), "{found:?} for {rms}");
        }
    }
}

/// Previews that see nothing lead to tolerance 0, where a run tells next to nothing of others.
#[test]
fn a_search_leaves_zero_at_once() {
    for levels in 1..3 {
        let mut bench = Made { seen: 0.0, ..made(1e6, 1.0, 0.0) };
        bench.previews.truncate(levels);
        let found = Hunt::new(&mut bench, aim(triangles(10_000), f64::INFINITY)).finish().expect("found");
        assert_eq!(bench.runs[0], 0.0);
        assert!(share(&found, 10_000) >= SHARE && found.runs <= 8, "{:?}", bench.runs);
    }
}

#[test]
fn a_tolerance_beside_a_budget_is_not_undercut() {
    let mut bench = made(1e6, 1.0, 0.0);
    let found = Hunt::new(&mut bench, aim(triangles(1_000_000), 20.0)).finish().expect("found");
    assert_eq!((found.tolerance, found.runs, found.ended_by), (20.0, 1, None));
    // Here the budget ends it before that.
    let mut bench = made(1e6, 1.0, 0.0);
    let found = Hunt::new(&mut bench, aim(triangles(10_000), 20.0)).finish().expect("found");
    assert!(found.tolerance > 90.0 && share(&found, 10_000) >= SHARE, "{found:?}");
    assert_eq!(found.ended_by, Some(crate::job::Budget::MaxTriangles));
}

#[test]
fn a_jump_that_a_budget_lies_in_is_found_from_both_sides() {
    let mut bench = made(120_000.0, 1.0, 0.25);
    let most = 110_000;
    let found = Hunt::new(&mut bench, aim(triangles(most), f64::INFINITY)).finish().expect("found");
    assert_eq!(found.tolerance, 1.0);
    let (low, beyond) = found.beyond.expect("a tolerance that exceeds the budget");
    assert!((0.999..1.0).contains(&low) && beyond.triangles > most, "{found:?}");
    assert!(found.runs <= 3, "{:?}", bench.runs);
}

#[test]
fn a_budget_that_nothing_keeps_to_is_told() {
    struct Corners;
    impl Bench for Corners {
        fn previews(&self) -> &[Preview] {
            &[]
        }
        fn preview(&mut self, _: usize, _: f64) -> Result<Figures, Error> {
            unreachable!("no previews")
        }
        fn run(&mut self, _: f64) -> Result<Figures, Error> {
            Ok(Figures { vertices: 9, triangles: 8, rms: 1.0, largest: 2.0 })
        }
        fn keep(&mut self, _: Option<f64>) -> Result<(), Error> {
            Ok(())
        }
        fn start(&self) -> f64 {
            1.0
        }
        fn span(&self) -> f64 {
            5.0
        }
        fn step(&self) -> Option<f64> {
            None
        }
    }
    let refused = Hunt::new(&mut Corners, aim(triangles(7), f64::INFINITY)).finish();
    let Err(Error::Goal(small)) = refused else { panic!("{refused:?}") };
    assert_eq!((small.what, small.smallest, small.found), ("triangles", 8, 7));
}

fn field(width: usize, height: usize) -> (Vec<f64>, Field) {
    let heights = terrain(5, width, height);
    let field = Field::from_heights(width, height, Heights::F64(heights.clone())).expect("a field");
    (heights, field)
}

#[test]
fn the_mesh_is_that_of_a_run_with_the_tolerance() {
    let (width, height) = (161, 129);
    let (heights, field) = field(width, height);
    for (quality, goal) in [
        (Quality::Fast, triangles(900)),
        (Quality::Balanced, Goal { max_points: Some(350), ..Goal::default() }),
        (Quality::Balanced, Goal { max_rms: Some(0.4), ..Goal::default() }),
    ] {
        let params = Params { tile: 40, quality, goal, ..Params::new(f64::INFINITY) };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| make(&field, &params, &Control::default())).expect("a mesh")
        };
        let chunks = |mesh: &Mesh| mesh.chunks().map(|c| c.expect("a chunk")).collect::<Vec<_>>();
        let (one, three) = (on(1), on(3));
        assert!(chunks(&one) == chunks(&three), "{goal:?}");
        let search = one.outcome().and_then(|outcome| outcome.search).expect("a search");
        let alone =
            Params { goal: Goal::default(), tolerance: params.tolerance.at(search.tolerance), ..params.clone() };
        assert!(chunks(&make(&field, &alone, &Control::default()).expect("a mesh")) == chunks(&one), "{goal:?}");
        certify_weighted(width, height, &heights, None, &alone);
        let figures = one.figures().expect("figures");
        assert!(goal.max_points.is_none_or(|most| figures.vertices <= most && figures.vertices * 100 >= most * 97));
        assert!(
            goal.max_triangles.is_none_or(|most| figures.triangles <= most && figures.triangles * 100 >= most * 97)
        );
        assert!(goal.max_rms.is_none_or(|rms| figures.rms <= rms && figures.rms >= 0.97 * rms));
    }
}

/// What one process has found out the next one does not find out again.
#[test]
fn a_search_goes_on_where_it_was_interrupted() {
    #[derive(Default)]
    struct Memory {
        noted: std::sync::Mutex<HashMap<(String, u64), Figures>>,
        most: usize,
    }
    impl Store for Memory {
        fn spool(&self, _: Option<f64>, pass: &Pass) -> Result<Spool, SpoolError> {
            Spool::new(&std::env::temp_dir(), pass.grid().len())
        }
        fn recall(&self, way: &str, tolerance: f64) -> Result<Option<Figures>, Error> {
            Ok(self.noted.lock().expect("notes").get(&(way.to_string(), tolerance.to_bits())).copied())
        }
        fn note(&self, way: &str, tolerance: f64, figures: &Figures) -> Result<(), Error> {
            let mut noted = self.noted.lock().expect("notes");
            let before = noted.insert((way.to_string(), tolerance.to_bits()), *figures);
            assert_eq!(before, None, "{way} at {tolerance} a second time");
            if noted.len() >= self.most { Err(crate::base::control::Cancelled.into()) } else { Ok(()) }
        }
    }
    let (_, field) = field(161, 129);
    let params = Params { tile: 40, quality: Quality::Fast, goal: triangles(900), ..Params::new(f64::INFINITY) };
    let control = Control::default();
    let whole = make(&field, &params, &control).expect("a mesh");
    let mut memory = Memory { most: 1, ..Memory::default() };
    let mesh = loop {
        match triangulate(Makers::Here, &memory, &field, &params, &control) {
            Ok(mesh) => break mesh,
            Err(Error::Cancelled(_)) => memory.most += 1,
            Err(error) => panic!("{error}"),
        }
    };
    assert_eq!(mesh.outcome(), whole.outcome());
    let chunks = |mesh: &Mesh| mesh.chunks().map(|c| c.expect("a chunk")).collect::<Vec<_>>();
    assert!(chunks(&mesh) == chunks(&whole));
    assert!(memory.most > 4, "{} steps", memory.most);
}
