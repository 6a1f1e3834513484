//! The verifier's lines against those that meshes are made with, and strips of them against the whole.

use proptest::prelude::*;

use super::*;
use crate::base::{LineKind, LineSet, Polylines};
use crate::formats::{ArrayReader, Arrays, Header};
use crate::kernel::breaklines::{Breaklines, Place};
use crate::testing::cases;
use words::{spot, word};

/// Columns and rows.
const SIZE: (usize, usize) = (8, 17);

/// All rows.
const ALL: std::ops::Range<i64> = 0..SIZE.1 as i64;

type Lines = Vec<Vec<(f64, f64)>>;

fn places() -> impl Strategy<Value = Lines> {
    let number = |count: i32| {
        prop_oneof![
            -2.0..f64::from(count) + 2.0,
            (-8..4 * count + 8).prop_map(|v| f64::from(v) / 4.0),
            (-8..4 * count + 8).prop_map(|v| f64::from(v) / 8.0),
            (0..count).prop_map(f64::from),
        ]
    };
    let rings = (any::<bool>(), prop::collection::vec((number(SIZE.0 as i32), number(SIZE.1 as i32)), 0..6));
    let closed = |(is_ring, mut line): (bool, Vec<(f64, f64)>)| {
        line.extend(line.first().copied().filter(|_| is_ring));
        line
    };
    prop::collection::vec(rings.prop_map(closed), 1..6)
}

fn set(lines: Polylines) -> LineSet {
    LineSet { kind: LineKind::Breaklines, lines, shift: 0.5 }
}

fn required(sets: &[LineSet], tolerance: f64) -> Result<RequiredLines, (LineKind, VerifyError)> {
    RequiredLines::new(sets, SIZE, tolerance, None, &CancelToken::default())
}

fn segments(lines: &RequiredLines) -> Vec<required::Segment> {
    lines.segments(ALL).expect("segments").collect()
}

proptest! {
    #[test]
    fn both_find_the_same_segments(lines in places()) {
        let set = set(Polylines::new(lines));
        let theirs = Breaklines::new(std::slice::from_ref(&set), SIZE).expect("near lines");
        let theirs: Vec<[Spot; 2]> = theirs.segments().iter().map(|s| s.map(|p| (p.x, p.y))).collect();
        let lines = required(std::slice::from_ref(&set), 1.0).expect("near lines");
        let mut ours: Vec<[Spot; 2]> = segments(&lines).into_iter().map(|(ends, _)| ends).collect();
        ours.sort_unstable_by_key(|s| s.map(|(x, y)| (y, x)));
        prop_assert_eq!(ours, theirs);
    }

    /// Bit for bit, whichever way a line is drawn and whatever it crosses.
    #[test]
    fn both_find_the_same_heights(lines in places(), slopes in prop::array::uniform3(-3.0..3.0f64)) {
        let plane = |&(x, y): &(f64, f64)| slopes[0] + slopes[1] * x + slopes[2] * (y * x).sin();
        let heights = lines.iter().map(|line| line.iter().map(plane).collect()).collect();
        let sets = [set(Polylines::new(lines.clone()).with_heights(heights)), set(Polylines::new(lines))];
        let theirs = Breaklines::new(&sets, SIZE).expect("near lines");
        let ours = required(&sets, 1e9).expect("near lines");
        prop_assert_eq!(ours.segment_count(), theirs.segments().len() as u64);
        for (place, height) in ours.levels(ALL).expect("levels") {
            let (x, y) = spot(place);
            let level = theirs.height_at(Place { y, x });
            prop_assert_eq!(level.map(f64::to_bits), Some(height.to_bits()), "at {}, {}", x, y);
        }
        prop_assert_eq!(theirs.height_range().is_some(), ours.have_heights());
        prop_assert!(theirs.check_heights(0.0).is_ok() == required(&sets, 0.0).is_ok());
    }

    /// Rounds that follow each other row by row make what rounds over all rows make.
    #[test]
    fn rows_are_noded_as_all_pieces_are(lines in places(), more in places(), slope in -3.0..3.0f64) {
        let heights = lines.iter().map(|line| line.iter().map(|&(x, y)| slope * x - y).collect()).collect();
        let sets = [set(Polylines::new(lines).with_heights(heights)), set(Polylines::new(more))];
        let mut all = Vec::new();
        for numbered in sets.iter().enumerate() {
            let size = (SIZE.0 as i64, SIZE.1 as i64);
            places::cut(numbered, size, &mut |piece| { all.push(piece); Ok(()) }).expect("near lines");
        }
        let scratch = crate::base::external::Scratch::new(None, Default::default());
        let mut sorter = crate::base::external::Sorter::new(&scratch, 1 << 10);
        all.iter().for_each(|piece| sorter.push(piece.record(1)).expect("a file"));
        let noded = noding::noded(sorter.finish().expect("a file"), SIZE.1 as i64, &scratch).expect("a file");
        let pieces = noded.into_records().map(|record| pieces::Piece::of_record(record.expect("a file")));
        prop_assert_eq!(noding::counted(pieces.collect()), oracle::noded(all));
    }
}

/// How a mesh is spoilt.
#[derive(Debug, Clone, Copy)]
enum Damage {
    None,
    /// One in so many vertices is elsewhere.
    Moved(usize),
    /// One in so many faces is missing.
    Missing(usize),
    /// All vertices are a quarter of a cell farther.
    Shifted,
    /// One in so many vertices is at another height.
    Lifted(usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    prop_oneof![
        2 => Just(Damage::None),
        1 => (2usize..9).prop_map(Damage::Moved),
        1 => (2usize..9).prop_map(Damage::Missing),
        1 => Just(Damage::Shifted),
        1 => (2usize..9).prop_map(Damage::Lifted),
    ]
}

/// Faces with a side along every stretch of lines, from every so many places to the next, and others between them.
fn mesh_along(lines: &RequiredLines, grid: &Grid, step: usize, damage: Damage) -> Arrays {
    let levels: std::collections::HashMap<u64, f64> = lines.levels(ALL).expect("levels").into_iter().collect();
    let mut mesh = Arrays::default();
    let mut numbers = std::collections::HashMap::new();
    let mut number = |place: u64| {
        let next = numbers.len();
        *numbers.entry(place).or_insert_with(|| {
            let is_one_of = |many: usize| next % many == 1;
            let (mut x, y) = spot(place);
            let mut height = levels.get(&place).copied().unwrap_or(0.0);
            match damage {
                Damage::Moved(many) if is_one_of(many) => x += 1,
                Damage::Shifted => x += 1,
                Damage::Lifted(many) if is_one_of(many) => height += 3.0,
                _ => {}
            }
            let at = grid.map((x, y));
            mesh.vertices.extend([at.x, at.y, height]);
            next as u32
        })
    };
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for stretch in oracle::stretches(&segments(lines)) {
        // A ring may begin at any of its places.
        let mut places = stretch.places;
        if stretch.is_ring {
            places.pop();
            places.rotate_left(step / 2);
            places.push(places[0]);
        }
        let last = places.len() - 1;
        let ends: Vec<u32> = (0..last).step_by(step).chain([last]).map(|at| number(places[at])).collect();
        faces.extend(ends.windows(2).map(|pair| [pair[0], pair[1], ends[0]]));
    }
    let count = faces.len();
    for i in 0..count {
        faces.push([faces[i][0], faces[(i * 7 + 3) % count][1], faces[(i * 5 + 1) % count][0]]);
    }
    let is_there = |i: usize| !matches!(damage, Damage::Missing(many) if i % many == 1);
    let faces = faces.into_iter().enumerate().filter(|(i, _)| is_there(*i)).flat_map(|(_, face)| face);
    mesh.triangles = faces.collect();
    mesh
}

/// A raster, and how a mesh over it has places.
fn raster(heights: Vec<f32>) -> (Band, Grid) {
    let raster = Band::of_singles("dem", SIZE, heights).expect("a band");
    let (transform, frame) = (raster.geo_transform(), Header::default().frame);
    let grid = Grid { width: SIZE.0 as i64, height: SIZE.1 as i64, transform, frame };
    (raster, grid)
}

fn reader(mesh: &Arrays) -> ArrayReader<'_> {
    let arrays = (&mesh.vertices[..], &mesh.triangles[..]);
    ArrayReader::new("mesh", Header::default(), arrays, Vec::new(), CancelToken::default()).expect("a mesh")
}

/// The verdict over a raster of these heights in strips, and what is found out over the whole at once.
fn judged(lines: &RequiredLines, heights: Vec<f32>, tolerance: f64, (step, damage): (usize, Damage)) -> [String; 2] {
    let (raster, grid) = raster(heights);
    let mesh = mesh_along(lines, &grid, step, damage);
    let verdict = verify_lines(&raster, &mut reader(&mesh), tolerance, lines, &CancelToken::default());
    let verdict = verdict.expect("judged");
    let found = oracle::found(&raster, &mut reader(&mesh), tolerance, (&grid, lines));
    let told = |off_ground: u64, stretches: u64, edges: u64, broken: &Finding<StretchPlace>| {
        format!("{off_ground} off the ground, {stretches} stretches, {edges} edges, {broken:?}")
    };
    [
        told(verdict.off_ground, verdict.stretches, verdict.edges, &verdict.broken),
        told(found.off_ground, found.stretches, found.edges, &found.broken),
    ]
}

proptest! {
    #![proptest_config(cases(96, 10_000))]

    /// Whatever the mesh is like, and whatever threads sort.
    #[test]
    fn strips_find_what_the_whole_has(
        lines in places(), more in places(), own: bool, step in 1usize..6, damage in damage(), threads in 1usize..4,
        gaps in prop::collection::vec(0..SIZE.0 * SIZE.1, 0..4), tolerance in prop_oneof![Just(1e-3), Just(20.0)],
    ) {
        let heights = lines.iter().map(|line| line.iter().map(|&(x, _)| 3.0 + x / 8.0).collect()).collect();
        let lines = Polylines::new(lines);
        let lines = if own { lines.with_heights(heights) } else { lines };
        let footprints = LineSet { kind: LineKind::Footprints, shift: 2.0, ..set(Polylines::new(more)) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let both = pool.install(|| {
            let lines = required(&[set(lines), footprints], 1e9).expect("near lines");
            let mut samples = vec![0.0; SIZE.0 * SIZE.1];
            gaps.into_iter().for_each(|gap| samples[gap] = f32::NAN);
            judged(&lines, samples, tolerance, (step, damage))
        });
        prop_assert_eq!(&both[0], &both[1]);
    }
}

/// A ring over all strips, a line across them, and one along the line between two: whole meshes are followed, others not.
#[test]
fn stretches_go_over_strips() {
    let ring = (0..=24)
        .map(|i| f64::from(i % 24) * std::f64::consts::TAU / 24.0)
        .map(|a| (3.4 + 3.0 * a.cos(), 8.3 + 7.9 * a.sin()));
    let lines = vec![ring.collect(), vec![(6.8, 0.2), (6.9, 15.7)], vec![(0.0, 4.0), (7.0, 4.0)]];
    let lines = required(&[set(Polylines::new(lines))], 1.0).expect("near lines");
    let flat = || vec![0.0; SIZE.0 * SIZE.1];
    let [strips, whole] = judged(&lines, flat(), 0.5, (2, Damage::None));
    assert_eq!(strips, whole);
    assert!(strips.ends_with("Finding { count: 0, first: None }"), "{strips}");
    for damage in [Damage::Moved(9), Damage::Missing(9), Damage::Shifted, Damage::Lifted(9)] {
        let [strips, whole] = judged(&lines, flat(), 0.5, (2, damage));
        assert_eq!(strips, whole);
        assert!(strips.contains("first: Some"), "{damage:?}: {strips}");
    }
}

#[test]
fn stretches_go_from_where_lines_end_or_meet_to_where_they_do_again() {
    let of = |segments: &[[Spot; 2]], set: u16| segments.iter().map(|&s| (s, 1 << set)).collect::<Vec<_>>();
    let ring = of(&[[(4, 0), (8, 4)], [(0, 4), (4, 8)], [(4, 0), (0, 4)], [(8, 4), (4, 8)]], 0);
    let all = |found: &[required::Segment]| {
        let mut parts = Vec::new();
        parts::Graph::new(found, &[], u64::MAX).parts(|part| parts.push(part));
        let ends = parts.iter().map(|part| (part.places[0], part.places[part.places.len() - 1], part.places.len()));
        ends.map(|(from, to, count)| (spot(from), spot(to), count)).collect::<Vec<_>>()
    };
    assert_eq!(all(&ring), [((4, 0), (4, 0), 5)]);
    let tail = [[(8, 4), (9, 4)], [(9, 4), (12, 5)]];
    assert_eq!(all(&[ring.clone(), of(&tail, 0)].concat()), [((8, 4), (8, 4), 5), ((8, 4), (12, 5), 3)]);
    // Where other lines begin to share a stretch, one ends.
    let shared = [of(&tail[..1], 0), of(&tail[1..], 1)].concat();
    assert_eq!(all(&shared), [((8, 4), (9, 4), 2), ((9, 4), (12, 5), 2)]);
    assert_eq!(spot(word((9, 4))), (9, 4));
}
