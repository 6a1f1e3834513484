//! Polishing keeps its contract, and saves what it is known to save.

use proptest::prelude::*;

use super::fitting::near_surface;
use super::*;
use crate::base::control::CancelToken;
use crate::base::mesh::Domain;
use crate::base::tiling::TilePlace;
use crate::base::{Heights, Tile};
use crate::kernel::seam::{MinLink, Rim};
use crate::kernel::triangulate::conformance::{check, domain, hole, holes_that_touch, ring, tile, tolerances};
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::GreedyInsertion;
use crate::kernel::triangulate::{Engine, Feasibility};
use crate::testing::cases;

const EFFORTS: [Effort; 3] = [Effort::Fast, Effort::Balanced, Effort::Best];
const HEIGHTS: [super::Heights; 2] = [super::Heights::Sampled, super::Heights::Fitted];
const FEASIBILITIES: [Feasibility; 2] = [Feasibility::Weak, Feasibility::Strong];

fn cut(task: &Task<'_>) -> TileMesh {
    let mut mesh = TileMesh::default();
    GreedyCuts::PLAIN.triangulate(task, &mut Default::default(), &mut mesh).expect("nobody cancels");
    mesh
}

fn polished(task: &Task<'_>, options: &Options, start: &TileMesh, scratch: &mut Scratch) -> TileMesh {
    let mut mesh = start.clone();
    polish(task, options, scratch, &mut mesh).expect("nobody cancels");
    mesh
}

fn options(effort: Effort, heights: super::Heights) -> Options {
    Options { effort, heights, ..Options::default() }
}

fn all_options() -> impl Iterator<Item = Options> {
    HEIGHTS.into_iter().flat_map(|heights| EFFORTS.map(|effort| options(effort, heights)))
}

fn task<'a>(
    tile: &'a Tile,
    domain: &'a Domain,
    tolerance: f64,
    feasibility: Feasibility,
    cancel: &'a CancelToken,
) -> Task<'a> {
    Task { tile, domain, tolerance, feasibility, max_stray: f64::INFINITY, cancel }
}

/// Polishes greedy cuts with all options and both feasibilities, and checks everything that is promised.
fn check_all(tile: &Tile, domain: &Domain, tolerance: f64) {
    let (mut scratch, cancel) = (Scratch::default(), CancelToken::default());
    for feasibility in FEASIBILITIES {
        let task = task(tile, domain, tolerance, feasibility, &cancel);
        let start = cut(&task);
        for options in all_options() {
            let mesh = polished(&task, &options, &start, &mut scratch);
            check(tile, domain, &mesh, tolerance);
            assert_eq!(mesh.vertices[..domain.vertices.len()], domain.vertices, "the rim stays");
            assert!(mesh.triangles.len() <= start.triangles.len(), "{options:?}");
            check_heights(tile, &mesh, tolerance, options.heights);
            check_relaxed(&task, &start, &mesh);
            assert_eq!(mesh, polished(&task, &options, &start, &mut Scratch::default()), "memory carries nothing over");
        }
    }
}

fn check_heights(tile: &Tile, mesh: &TileMesh, tolerance: f64, heights: super::Heights) {
    for &v in &mesh.vertices {
        match (v.at.sample(), heights) {
            (Some((column, row)), super::Heights::Sampled) => assert_eq!(v.height, tile.at(column, row)),
            (None, super::Heights::Sampled) => panic!("{v:?} is on no sample"),
            // At samples the triangles speak for the vertices.
            (_, super::Heights::Fitted) => assert!(near_surface(tile, v, tolerance), "{v:?}"),
        }
    }
}

fn check_relaxed(task: &Task<'_>, start: &TileMesh, mesh: &TileMesh) {
    assert!(mesh.relaxed <= start.relaxed);
    let fails = || count_relaxed(task.tile, mesh, task.tolerance, |_| true);
    assert!(mesh.relaxed <= fails());
    if task.feasibility == Feasibility::Strong && start.relaxed == 0 {
        assert_eq!(fails(), 0, "new edges pass the strong test");
    }
}

proptest! {
    #![proptest_config(cases(40, 120))]

    #[test]
    fn every_promise_holds_on_random_tiles(
        width in 2usize..26, height in 2usize..26, seed in any::<u64>(), kind in 0u8..4,
        tolerance in tolerances(), weighted in any::<bool>(),
    ) {
        let mut tile = tile(width, height, seed, kind);
        if weighted {
            let weight = |i: usize| [0.0, 0.5, 1.0, 3.0][(seed.rotate_left(i as u32) % 4) as usize];
            tile = tile.with_weights((0..width * height).map(weight).collect());
        }
        let cancel = CancelToken::default();
        let rim = Rim::new(&tile, tolerance, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel).expect("nobody cancels");
        check_all(&tile, &rim.domain, tolerance);
    }
}

/// The smallest of all angles, as the square of its sine.
fn sharpest(mesh: &TileMesh) -> f64 {
    mesh.triangles.iter().map(|&t| super::angles::sharpness(mesh.corners(t))).fold(1.0, f64::min)
}

proptest! {
    #![proptest_config(cases(20, 60))]

    #[test]
    fn no_angle_falls_below_the_floor_unless_it_was_there(
        width in 3usize..26, height in 3usize..26, seed in any::<u64>(), kind in 0u8..4,
        tolerance in tolerances(), min_angle in prop::sample::select(vec![1.0, 10.0, 20.0, 35.0, 60.0]),
    ) {
        let (tile, cancel) = (tile(width, height, seed, kind), CancelToken::default());
        let rim = Rim::new(&tile, tolerance, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel).expect("nobody cancels");
        let task = task(&tile, &rim.domain, tolerance, Feasibility::Weak, &cancel);
        let start = cut(&task);
        let sine = f64::to_radians(min_angle).sin();
        for options in all_options() {
            let tuning = Tuning { min_angle: Some(min_angle), ..Tuning::default() };
            let mesh = polished(&task, &Options { tuning, ..options }, &start, &mut Scratch::default());
            check(&tile, &rim.domain, &mesh, tolerance);
            let least = sharpest(&start).min(sine * sine * (1.0 - 1e-12));
            prop_assert!(sharpest(&mesh) >= least, "{} {} {least}", sharpest(&mesh), sharpest(&start));
        }
    }
}

#[test]
fn strong_edges_are_those_of_a_strong_task() {
    let tile = tile(40, 40, 11, 0);
    let cancel = CancelToken::default();
    let rim =
        Rim::new(&tile, 2.0, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
            .expect("nobody cancels");
    let [weak, strong] = FEASIBILITIES.map(|f| task(&tile, &rim.domain, 2.0, f, &cancel));
    let start = cut(&weak);
    for options in all_options() {
        let tuning = Tuning { strong_edges: true, ..Tuning::default() };
        let mesh = polished(&weak, &Options { tuning, ..options }, &start, &mut Scratch::default());
        assert_eq!(mesh, polished(&strong, &options, &start, &mut Scratch::default()));
        let fail = |mesh: &TileMesh| count_relaxed(&tile, mesh, strong.tolerance, |_| true);
        assert!(fail(&mesh) <= fail(&start), "{options:?}: {} of {}", fail(&mesh), fail(&start));
    }
}

#[test]
fn presets_keep_to_their_ranges_and_others_are_named() {
    for options in all_options() {
        let usual = Schedule::preset(options.effort, options.heights);
        assert_eq!(usual.check(), Ok(()));
        let strange = Schedule { places: 5, ..usual };
        assert_eq!(strange.check().expect_err("five places").to_string(), "places: expected 4 or 8");
        let others = [
            Schedule { rounds: usual.rounds + 1, ..usual },
            Schedule { caps: Caps::new(&[0.7]).expect("a cap"), ..usual },
            Schedule { turns: !usual.turns, ..usual },
            Schedule { longest_repaired: 9, ..usual },
        ];
        assert!(others.iter().all(|other| other.named() != usual.named()));
    }
    assert!(Caps::new(&[]).is_none() && Caps::new(&[1.0, -1.0]).is_none() && Caps::new(&[f32::NAN]).is_none());
}

/// Where the corners of a mesh's triangles are, whatever their numbers.
fn places(mesh: &TileMesh) -> Vec<[Point; 3]> {
    let mut places: Vec<_> = mesh.triangles.iter().map(|&t| mesh.corners(t).map(|v| v.at)).collect();
    places.sort_unstable();
    places
}

/// Every number at once, the other way than usual.
#[test]
fn promises_hold_with_any_schedule() {
    let tile = tile(40, 30, 21, 0);
    let cancel = CancelToken::default();
    let rim =
        Rim::new(&tile, 1.0, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
            .expect("nobody cancels");
    let task = task(&tile, &rim.domain, 1.0, Feasibility::Weak, &cancel);
    let start = cut(&task);
    let nothing = Schedule { sweeps: 0, passes: 0, ..Schedule::preset(Effort::Balanced, super::Heights::Sampled) };
    let strange = Schedule {
        sweeps: 1,
        moves: 2,
        last_sweeps: 2,
        passes: 4,
        caps: Caps::new(&[0.0, 9.0]).expect("caps"),
        retry: true,
        yield_of: 3,
        rounds: 1,
        shrink: 1.0,
        reach: 0.5,
        steps: 5,
        finer: true,
        thorough: false,
        steps_between: 4,
        places: 4,
        rows: 8,
        turns: false,
        longest_ring: 3,
        longest_repaired: 5,
    };
    for heights in HEIGHTS {
        let with = |schedule| {
            let tuning = Tuning { schedule: Some(schedule), ..Tuning::default() };
            polished(&task, &Options { heights, tuning, ..Options::default() }, &start, &mut Scratch::default())
        };
        assert_eq!(places(&with(nothing)), places(&start), "other numbers at most");
        let mesh = with(strange);
        check(&tile, &rim.domain, &mesh, 1.0);
        assert!(mesh.triangles.len() < start.triangles.len());
    }
}

#[test]
fn a_pinch_stays_a_pinch() {
    let tile = tile(19, 19, 5, 1);
    let domain = domain(&tile, &[ring((0, 0), 9), ring((9, 9), 9)]);
    for tolerance in [0.0, 0.3, 1.0, 9.0] {
        check_all(&tile, &domain, tolerance);
    }
}

#[test]
fn holes_stay_holes() {
    let (rough, flat) = (tile(14, 12, 77, 1), Tile::from_heights(14, 12, Heights::F32(vec![0.0; 14 * 12])));
    let one = vec![ring((0, 0), 11), hole((4, 4), 3)];
    for loops in holes_that_touch().iter().chain([&one]) {
        for tolerance in [0.0, 0.3, 1.0, 9.0] {
            check_all(&rough, &domain(&rough, loops), tolerance);
        }
        check_all(&flat, &domain(&flat, loops), 0.0);
    }
}

/// Every sample a vertex: two triangles to a cell.
fn every_sample(tile: &Tile, domain: &Domain) -> TileMesh {
    let (w, h) = (tile.width(), tile.height());
    let mut mesh = TileMesh { vertices: domain.fixed().collect(), ..TileMesh::default() };
    let mut number = vec![u32::MAX; w * h];
    let index = |column: usize, row: usize| row * w + column;
    for (i, v) in (0..).zip(domain.fixed()) {
        let (column, row) = v.at.sample().expect("on a sample");
        number[index(column, row)] = i;
    }
    for row in 0..h {
        for column in 0..w {
            if number[index(column, row)] == u32::MAX {
                number[index(column, row)] = mesh.vertices.len() as u32;
                let at = crate::base::lattice::Point::of_sample(column as i32, row as i32);
                mesh.vertices.push(crate::base::mesh::Vertex { at, height: tile.at(column, row) });
            }
        }
    }
    for row in 1..h {
        for column in 1..w {
            let [a, b] = [(column - 1, row - 1), (column, row - 1)].map(|(c, r)| number[index(c, r)]);
            let [d, c] = [(column - 1, row), (column, row)].map(|(c, r)| number[index(c, r)]);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

#[test]
fn flat_ground_at_tolerance_0_keeps_points_and_no_other_interior_vertex() {
    let tile = Tile::from_heights(40, 30, Heights::F64(vec![0.1; 1200]));
    let mut walk = Vec::new();
    walk.extend((0..39).map(|c| (c, 0)));
    walk.extend((0..29).map(|r| (39, r)));
    walk.extend((0..39).map(|c| (39 - c, 29)));
    walk.extend((0..29).map(|r| (0, 29 - r)));
    let mut domain = domain(&tile, &[walk]);
    let point = |c, r| crate::base::mesh::Vertex { at: crate::base::lattice::Point::of_sample(c, r), height: 0.1 };
    domain.points = vec![point(7, 3), point(20, 15)];
    let start = every_sample(&tile, &domain);
    check(&tile, &domain, &start, 0.0);
    let cancel = CancelToken::default();
    let task = task(&tile, &domain, 0.0, Feasibility::Strong, &cancel);
    for options in all_options() {
        // Between points and a rim like this triangles are sharp.
        let options = Options { tuning: Tuning { min_angle: Some(0.0), ..options.tuning }, ..options };
        let mesh = polished(&task, &options, &start, &mut Scratch::default());
        check(&tile, &domain, &mesh, 0.0);
        assert!(mesh.vertices.iter().copied().eq(domain.fixed()), "{options:?}");
    }
}

#[test]
fn a_cancelled_polish_says_so() {
    let tile = tile(20, 20, 3, 0);
    let cancel = CancelToken::default();
    let rim =
        Rim::new(&tile, 2.0, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
            .expect("not yet");
    let task = task(&tile, &rim.domain, 2.0, Feasibility::Weak, &cancel);
    let mesh = cut(&task);
    cancel.cancel();
    for effort in EFFORTS {
        assert_eq!(
            polish(&task, &Options { effort, ..Options::default() }, &mut Scratch::default(), &mut mesh.clone()),
            Err(Cancelled)
        );
    }
}

/// Weighs nothing: every triangulation will do.
struct Anything;

impl super::filling::Weigher for Anything {
    type Known = ();

    fn known(&self) {}

    fn triangle(&mut self, _: [crate::base::mesh::Vertex; 3], _: f64) -> f64 {
        0.0
    }

    fn chord(&mut self, _: crate::base::mesh::Vertex, _: crate::base::mesh::Vertex) -> bool {
        true
    }
}

/// All that a net is.
type State = (Vec<crate::base::mesh::Vertex>, Vec<u32>, Vec<super::net::Triangle>);

fn state(net: &Net) -> State {
    (net.vertices.clone(), net.outgoing.clone(), net.triangles.clone())
}

#[test]
fn a_journal_takes_back_removals_flips_and_moves_bit_for_bit() {
    take_back(None);
    take_back(Some(Fitting::new(2.0)));
}

fn take_back(fitting: Option<Fitting>) {
    let tile = tile(25, 25, 9, 0);
    let cancel = CancelToken::default();
    let rim =
        Rim::new(&tile, 2.0, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
            .expect("nobody cancels");
    let task = task(&tile, &rim.domain, 2.0, Feasibility::Weak, &cancel);
    let (mut judge, mut net) = (Judge::new(&task), Net::default());
    judge.fitting = fitting;
    net.load(&rim.domain, &mut cut(&task));
    Repair::measure(&mut net, &judge);
    let (mut hole, mut filler) = (super::hole::Hole::default(), super::filling::Filler::default());
    let mut improver = super::improve::Improver::default();
    let before = state(&net);
    let free: Vec<u32> = (0..net.vertices.len() as u32).filter(|&v| net.is_free(v)).collect();
    assert!(free.len() > 20);
    let (mut flips, mut moves) = (0, 0);
    for v in free {
        net.begin();
        assert!(hole.around(&net, v, 50));
        let ring = hole.ring.iter().map(|&r| net.vertex(r));
        assert_eq!(filler.fill(ring, 1.0, &mut Anything), Some(0.0));
        net.refill(&hole, &filler.triangles, v, &mut Vec::new());
        net.drop_vertex(v);
        for side in hole.triangles[1..].iter().flat_map(|&t| 3 * t..3 * t + 3) {
            let alive = net.triangles[side as usize / 3].alive();
            flips += usize::from(alive && improver.flip(&mut net, side, super::improve::Demand::Better, &judge));
        }
        hole.ring.retain(|&r| !net.is_locked(r));
        let how = super::improve::Search { rounds: 2, places: 8, halvings: 0, rows: Schedule::ALL, thorough: false };
        for &r in &hole.ring {
            let moved = improver.relocate(&mut net, r, how, super::improve::Demand::Better, &judge);
            moves += usize::from(moved);
        }
        assert_ne!(state(&net), before);
        net.roll_back();
        assert_eq!(state(&net), before, "vertex {v}");
    }
    assert!(flips > 10 && moves > 10, "{flips} {moves}");
}

#[test]
fn fitted_heights_leave_points_and_rim_alone() {
    let wave = |i: usize| ((i % 40) as f64 * 0.4).sin() * 5.0 + ((i / 40) as f64 * 0.3).cos() * 4.0;
    let tile = Tile::from_heights(40, 40, Heights::F64((0..1600).map(wave).collect()));
    let (cancel, points) = (CancelToken::default(), [(7, 3), (20, 15), (21, 15), (0, 9)]);
    let rim =
        Rim::new(&tile, 0.7, &points, &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
            .expect("nobody cancels");
    assert_eq!(rim.domain.points.len(), 3);
    let task = task(&tile, &rim.domain, 0.7, Feasibility::Weak, &cancel);
    let mut start = TileMesh::default();
    GreedyInsertion::default().triangulate(&task, &mut Default::default(), &mut start).expect("nobody cancels");
    for effort in [Effort::Balanced, Effort::Best] {
        let options = options(effort, super::Heights::Fitted);
        let mesh = polished(&task, &options, &start, &mut Scratch::default());
        check(&tile, &rim.domain, &mesh, 0.7);
        let others = &mesh.vertices[rim.domain.fixed().count()..];
        let is_sample = |v: &&crate::base::mesh::Vertex| v.at.sample().is_some_and(|(c, r)| tile.at(c, r) == v.height);
        println!("{effort:?}: {} triangles, {} free vertices", mesh.triangles.len(), others.len());
        assert!(others.iter().filter(is_sample).count() * 2 < others.len(), "most are fitted");
    }
}

/// Energies are infinite or no numbers there; nothing may hang on them.
#[test]
fn heights_and_tolerances_beyond_single_precision() {
    let heights = |scale: f64| (0..400).map(|i| f64::from(i * 7919 % 101 - 50) * scale).collect();
    for scale in [1e-300, 1e-30, 1.0, 1e28] {
        let tile = Tile::from_heights(20, 20, Heights::F64(heights(scale)));
        for tolerance in [5e-324, 1e-31, 1e-29, 1.0, 20.0, 1e29] {
            let cancel = CancelToken::default();
            let rim = Rim::new(
                &tile,
                tolerance,
                &[],
                &TilePlace::alone(tile.width(), tile.height()),
                &mut MinLink::default(),
                &cancel,
            );
            check_all(&tile, &rim.expect("nobody cancels").domain, tolerance);
        }
    }
}

/// A wavy bowl of 100 × 100 samples.
fn bowl() -> Tile {
    let bowl = |i: usize| {
        let (x, y) = ((i % 100) as f64 - 40.0, (i / 100) as f64 - 55.0);
        (x * x + y * y) / 50.0 + (x * 0.3).sin() + (y * 0.2).cos()
    };
    Tile::from_heights(100, 100, Heights::F64((0..10_000).map(bowl).collect()))
}

#[test]
fn few_rows_choose_about_as_well_as_all() {
    let (tile, cancel) = (bowl(), CancelToken::default());
    let place = TilePlace::alone(tile.width(), tile.height());
    let rim = Rim::new(&tile, 3.0, &[], &place, &mut MinLink::default(), &cancel).expect("nobody cancels");
    let task = task(&tile, &rim.domain, 3.0, Feasibility::Weak, &cancel);
    let start = cut(&task);
    let with = |rows| {
        let schedule = Schedule { rows, ..Schedule::preset(Effort::Balanced, super::Heights::Sampled) };
        let tuning = Tuning { schedule: Some(schedule), ..Tuning::default() };
        polished(&task, &Options { tuning, ..Options::default() }, &start, &mut Scratch::default())
    };
    let (few, all) = (with(8), with(Schedule::ALL));
    check(&tile, &rim.domain, &few, 3.0);
    assert_ne!(few, all, "triangles are large enough for rows to be chosen");
    let counts = [few, all].map(|mesh| mesh.triangles.len());
    assert!(counts[0] * 10 < counts[1] * 11, "{counts:?}");
}

#[test]
fn more_effort_leaves_fewer_triangles() {
    let tile = bowl();
    let cancel = CancelToken::default();
    let rim =
        Rim::new(&tile, 0.5, &[], &TilePlace::alone(tile.width(), tile.height()), &mut MinLink::default(), &cancel)
            .expect("nobody cancels");
    let task = task(&tile, &rim.domain, 0.5, Feasibility::Weak, &cancel);
    let start = cut(&task);
    let count =
        |effort, heights| polished(&task, &options(effort, heights), &start, &mut Scratch::default()).triangles.len();
    let [sampled, fitted] = HEIGHTS.map(|heights| EFFORTS.map(|effort| count(effort, heights)));
    println!("{} {sampled:?} {fitted:?}", start.triangles.len());
    assert!(fitted[1] * 10 < sampled[1] * 9 && fitted[2] < fitted[1], "{sampled:?} {fitted:?}");
    let (counts, [fast, balanced, best]) = (sampled, sampled);
    assert!(fast * 10 < start.triangles.len() * 7 && balanced * 10 < fast * 8 && best < balanced, "{counts:?}");
}

/// What the docs of [`Scratch`] reckon with.
#[test]
fn sizes_are_what_the_docs_say() {
    assert_eq!(std::mem::size_of::<super::net::Triangle>(), 36);
    assert_eq!(std::mem::size_of::<crate::base::mesh::Vertex>(), 16);
}
