//! Breaklines all the way from lines to a written mesh, judged by the verifier, which reckons the lines again.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use proptest::prelude::*;

use super::lines::tests::scratch;
use super::tests::{geotiff, terrain};
use super::*;
use crate::base::control::{CancelToken, Control};
use crate::base::staged::StagedFile;
use crate::base::{LineKind, LineSet, PointSet, Polylines, Window};
use crate::field::Field;
use crate::formats::{Header, MeshReader, PlySink, ReadError, ReadOptions, open};
use crate::job::spool::Chunk;
use crate::kernel::breaklines::Breaklines;
use crate::kernel::measure::ErrorStats;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::GreedyInsertion;
use crate::testing::{self, cases};
use crate::verify::{LinesVerdict, RequiredLines, Verdict, VerifyError, VerifyOptions, verify, verify_lines};

pub(super) type Line = Vec<(f64, f64)>;

/// A raster, lines over it and how it is meshed.
#[derive(Debug, Clone)]
pub(super) struct Scene {
    pub(super) size: (usize, usize),
    pub(super) heights: Vec<f64>,
    pub(super) lines: Vec<Line>,
    /// The lines' own height at a place, if they have one.
    pub(super) own: Option<fn(f64, f64) -> f64>,
    /// Outlines of lakes, each with the height of its lake.
    pub(super) lakes: Vec<(f64, Vec<Line>)>,
    /// Polygons at whose outlines the mesh is to end, if there are any.
    pub(super) cutline: Vec<Vec<Line>>,
    pub(super) shift: f64,
}

impl Scene {
    pub(super) fn new(size: (usize, usize), seed: u64, lines: Vec<Line>) -> Scene {
        Scene {
            size,
            heights: terrain(seed, size.0, size.1),
            lines,
            own: None,
            lakes: Vec::new(),
            cutline: Vec::new(),
            shift: 0.5,
        }
    }

    /// Takes away every sample for which a cheap hash is below a share of 256, in blobs of up to two each way.
    pub(super) fn with_gaps(mut self, seed: u64, share: u64) -> Scene {
        let width = self.size.0;
        for (i, height) in self.heights.iter_mut().enumerate() {
            let (column, row) = (i % width / 2, i / width / 2);
            let hash = (column as u64 * 7919 + row as u64 * 104_729 + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 56;
            *height = if hash < share { f64::NAN } else { *height };
        }
        self
    }

    pub(super) fn sets(&self) -> Vec<LineSet> {
        let lines = Polylines::new(self.lines.clone());
        let heights = |own: fn(f64, f64) -> f64| {
            self.lines.iter().map(|line| line.iter().map(|&(x, y)| own(x, y)).collect()).collect()
        };
        let lines = self.own.map_or(lines.clone(), |own| lines.with_heights(heights(own)));
        let breaklines = LineSet { kind: LineKind::Breaklines, lines, shift: self.shift };
        let outlines = || self.lakes.iter().flat_map(|(level, rings)| rings.iter().map(move |ring| (*level, ring)));
        let features = (0..).zip(&self.lakes).flat_map(|(feature, (_, rings))| rings.iter().map(move |_| feature));
        let lakes = Polylines::new(outlines().map(|(_, ring)| ring.clone()).collect()).of_features(features.collect());
        let lakes = lakes.with_heights(outlines().map(|(level, ring)| vec![level; ring.len()]).collect());
        let lakes = LineSet { kind: LineKind::Lakes, lines: lakes, shift: 0.0 };
        let outlines = Polylines::new(self.cutline.concat());
        let features = (0..).zip(&self.cutline).flat_map(|(feature, rings)| rings.iter().map(move |_| feature));
        let outlines = outlines.of_features(features.collect());
        let cutline = LineSet { kind: LineKind::Cutline, lines: outlines, shift: 0.0 };
        let sets = [(breaklines, true), (lakes, !self.lakes.is_empty()), (cutline, !self.cutline.is_empty())];
        sets.into_iter().filter(|(_, is_there)| *is_there).map(|(set, _)| set).collect()
    }

    pub(super) fn params(&self, tolerance: f64) -> Params {
        // In memory or beside it, which is the same.
        let in_memory = [0, Lines::IN_MEMORY][self.heights.len() % 2];
        let lines = Lines::new(&self.sets(), self.size, scratch(), in_memory).expect("near lines");
        Params { breaklines: Some(Arc::new(lines)), ..Params::new(tolerance) }
    }

    /// The mesh, if there is ground, and what the verifier says of it. With nothing wrong, whatever is said of lines.
    pub(super) fn made(&self, params: &Params) -> Option<(Mesh, LinesVerdict)> {
        self.judged(params).map(|(verdict, mesh, lines)| {
            let max_error = params.tolerance.kept();
            assert!(verdict.passes(), "{verdict}");
            let measured = measured(&mesh);
            assert!(measured.max <= max_error && measured.beside <= verdict.beside_lines);
            let agrees = verdict.worst.is_none_or(|worst| (worst.error - measured.max).abs() <= 1e-9);
            assert!(mesh.chains().is_empty() || agrees, "{verdict} {measured:?}");
            (mesh, lines)
        })
    }

    /// The mesh and all that the verifier says of it.
    pub(super) fn judged(&self, params: &Params) -> Option<(Verdict, Mesh, LinesVerdict)> {
        let folder = testing::folder();
        let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
        geotiff(&dem, self.size.0, self.size.1, &self.heights);
        let (band, control) = (testing::band(&dem, 1), Control::default());
        let field = Field::open(&band, &Default::default(), &control).expect("a field");
        let mesh = match triangulate(&field, params, &control) {
            Err(Error::NoGround { .. }) => return None,
            mesh => mesh.expect("a mesh"),
        };
        let staged = StagedFile::create(&tin, true, &[] as &[&Path]).expect("staged");
        mesh.write(Box::new(PlySink::new(staged, Header::default())), &control).expect("written");
        let max_stray = params.limit_on_straying(params.features());
        let max_error = params.tolerance.kept();
        let lines = RequiredLines::new(&self.sets(), self.size, max_error, None, &Default::default())
            .expect("one height at each place");
        let options = VerifyOptions { lines: Some(&lines), max_error, max_stray, importance: None, temp_dir: None };
        let verdict = verify(&band, &tin, &options, &control).expect("judged");
        let mut reader = open(&tin, None, &ReadOptions::default()).expect("a mesh");
        // An edge may be of several sets.
        let edges: Vec<u64> = mesh.chains().iter().map(|chains| chains.edges).collect();
        let marked = marked(reader.as_mut());
        assert!(
            (edges.iter().max().map_or(0, |&most| most)..=edges.iter().sum()).contains(&marked),
            "{marked} of {edges:?}"
        );
        let found = verify_lines(&band, reader.as_mut(), max_error, &lines, &CancelToken::default());
        Some((verdict, mesh, found.expect("judged")))
    }

    /// The same, and edges follow all lines: as many as the mesh was given.
    pub(super) fn certify(&self, params: &Params) {
        let Some((mesh, verdict)) = self.made(params) else { return };
        assert_eq!((verdict.broken.count, verdict.not_level.count), (0, 0), "{verdict:?}");
        let chains = mesh.chains()[0];
        let segments = segments(params.breaklines.as_ref().expect("breaklines"), self.size);
        assert_eq!(verdict.segments, segments);
        if !self.lakes.is_empty() {
            return;
        }
        assert_eq!(verdict.off_ground, chains.off_ground);
        // The verifier may find shorter ways over edges that are there by chance.
        assert!(verdict.edges <= chains.edges, "{verdict:?} of {chains:?}");
    }
}

/// How many segments lines have.
pub(super) fn segments(lines: &Lines, (width, height): (usize, usize)) -> u64 {
    lines.near(Window { column: 0, row: 0, width, height }).expect("lines").segments().len() as u64
}

/// How many edges are marked: each once, and each a side of a triangle.
fn marked(mesh: &mut dyn MeshReader) -> u64 {
    let (mut sides, mut edges) = (HashSet::new(), HashSet::new());
    let either = |a: u64, b: u64| [a.min(b), a.max(b)];
    mesh.for_each_face(|_, [a, b, c]| {
        sides.extend([either(a, b), either(b, c), either(c, a)]);
        Ok::<(), ReadError>(())
    })
    .expect("faces");
    mesh.for_each_edge(|index, edge| {
        let [a, b] = edge.ends;
        assert!(sides.contains(&either(a, b)) && edges.insert(either(a, b)), "edge {index}");
        Ok::<(), ReadError>(())
    })
    .expect("edges");
    edges.len() as u64
}

fn measured(mesh: &Mesh) -> ErrorStats {
    mesh.chunks().fold(ErrorStats::default(), |mut all, chunk| {
        all.add(&chunk.expect("a chunk").errors);
        all
    })
}

fn chunks(mesh: &Mesh) -> Vec<Chunk> {
    mesh.chunks().map(|chunk| chunk.expect("a chunk")).collect()
}

/// A column or a row of a raster with so many, on and between samples, on the rim and beyond.
pub(super) fn number(samples: usize) -> impl Strategy<Value = f64> {
    let last = samples as f64 - 1.0;
    prop_oneof![
        4 => -2.0..last + 2.0,
        1 => (0.0..last).prop_map(|v| (v * 4.0).round() / 4.0),
        1 => (0.0..last).prop_map(f64::round),
        1 => prop_oneof![Just(0.0), Just(last)],
    ]
}

fn line(size: (usize, usize)) -> impl Strategy<Value = Line> {
    let place = (number(size.0), number(size.1));
    // Along a row or a column now and then, and back to where it began.
    (prop::collection::vec(place, 1..7), 0..4u8).prop_map(|(mut line, way)| {
        for i in 1..line.len() {
            match way {
                0 if i % 2 == 1 => line[i].1 = line[i - 1].1.round(),
                1 if i % 2 == 1 => line[i].0 = line[i - 1].0.round(),
                _ => {}
            }
        }
        if way == 2 {
            line.push(line[0]);
        }
        line
    })
}

pub(super) fn scene() -> impl Strategy<Value = Scene> {
    let size = (2usize..34, 2usize..28);
    let lines = size.prop_flat_map(|size| (Just(size), prop::collection::vec(line(size), 1..6)));
    let gaps = prop_oneof![Just(0u64), Just(0), 5u64..60];
    (lines, any::<u16>(), gaps, prop_oneof![Just(0.5), Just(0.0), Just(2.0)]).prop_map(
        |((size, lines), seed, gaps, shift)| {
            Scene { shift, ..Scene::new(size, seed.into(), lines) }.with_gaps(seed.into(), gaps)
        },
    )
}

/// Heights far above and across a terrain, as bridges and banks have them.
fn heights() -> impl Strategy<Value = fn(f64, f64) -> f64> {
    prop_oneof![
        Just((|x, y| 25.0 + x / 8.0 - y / 16.0) as fn(f64, f64) -> f64),
        Just((|_, _| 3.0) as fn(f64, f64) -> f64),
        Just((|x, y| -4.0 * x + 3.0 * y) as fn(f64, f64) -> f64),
    ]
}

pub(super) fn qualities() -> impl Strategy<Value = (Quality, VertexHeights)> {
    prop_oneof![
        Just((Quality::None, VertexHeights::Sampled)),
        Just((Quality::Fast, VertexHeights::Sampled)),
        Just((Quality::Balanced, VertexHeights::Sampled)),
        Just((Quality::Balanced, VertexHeights::Fitted)),
        Just((Quality::Best, VertexHeights::Sampled)),
    ]
}

/// Engines that take lines.
pub(super) fn engines() -> impl Strategy<Value = EngineChoice> {
    prop_oneof![
        3 => Just(GreedyInsertion::default().into()),
        1 => Just(GreedyCuts::PLAIN.into()),
        1 => Just(GreedyCuts::IMPROVED.into()),
    ]
}

/// The limit of the quality, none, and limits that are asked for.
pub(super) fn limits() -> impl Strategy<Value = Option<f64>> {
    prop::sample::select(vec![None, None, Some(f64::INFINITY), Some(1.0), Some(1.5)])
}

proptest! {
    #![proptest_config(cases(60, 2000))]

    #[test]
    fn edges_follow_random_lines_over_random_rasters(
        scene in scene(), (quality, heights) in qualities(), engine in engines(), tile in 2usize..20,
        tolerance in prop_oneof![Just(0.5), Just(3.0), Just(20.0)], points in prop::collection::vec(0usize..500, 0..4),
        max_stray in limits(),
    ) {
        let points = points.into_iter().map(|i| (i % scene.size.0, i / scene.size.0 % scene.size.1));
        let points = PointSet::new(points.filter(|_| scene.heights.iter().all(|z| !z.is_nan())));
        let points = Some(Arc::new(points));
        scene.certify(&Params { quality, heights, engine, tile, points, max_stray, ..scene.params(tolerance) });
    }
}

proptest! {
    #![proptest_config(cases(60, 2000))]

    #[test]
    fn edges_keep_the_heights_of_lines_over_random_rasters(
        scene in scene(), own in heights(), (quality, heights) in qualities(), engine in engines(), tile in 2usize..20,
        tolerance in prop_oneof![Just(0.5), Just(3.0), Just(20.0)], points in prop::collection::vec(0usize..500, 0..4),
        max_stray in limits(),
    ) {
        let scene = Scene { own: Some(own), ..scene };
        let points = points.into_iter().map(|i| (i % scene.size.0, i / scene.size.0 % scene.size.1));
        let points = PointSet::new(points.filter(|_| scene.heights.iter().all(|z| !z.is_nan())));
        let points = Some(Arc::new(points));
        let params = Params { quality, heights, engine, tile, points, max_stray, ..scene.params(tolerance) };
        match RequiredLines::new(&scene.sets(), scene.size, tolerance, None, &Default::default()) {
            Ok(_) => scene.certify(&params),
            // Where lines are steep, one that bends and meets another is not at its height to a cell.
            Err((_, VerifyError::TwoHeights { .. })) => {
                let lines = params.breaklines.as_ref().expect("lines");
                prop_assert!(lines.check_heights(tolerance).is_err());
            }
            Err(other) => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_dam_stands_above_the_ground_and_two_heights_at_a_place_are_refused() {
    let dam = |x: f64, _: f64| 60.0 + x / 8.0;
    let scene = Scene { own: Some(dam), ..Scene::new((40, 30), 4, vec![vec![(3.2, 4.4), (20.0, 12.0), (36.7, 25.1)]]) };
    let params = Params { tile: 16, ..scene.params(1.0) };
    scene.certify(&params);
    let (mesh, verdict) = scene.made(&params).expect("ground");
    // All of it is followed, far from the samples, whose number is told.
    let beside = measured(&mesh).beside;
    assert!(beside > 60 && verdict.edges >= 2, "{beside} {verdict}");
    // A mesh of the raster's heights does not keep them.
    let raster = Scene { own: None, ..scene.clone() };
    let (_, _, verdict) =
        scene.judged(&Params { breaklines: raster.params(1.0).breaklines, ..params.clone() }).expect("ground");
    assert_eq!(verdict.broken.count, 1);

    let lines = |lift: f64| {
        let crossing = Polylines::new(vec![vec![(2.0, 2.0), (12.0, 12.0)], vec![(2.0, 12.0), (12.0, 2.0)]]);
        let lines = crossing.with_heights(vec![vec![5.0, 5.0], vec![5.0 + lift, 5.0 + lift]]);
        vec![LineSet { kind: LineKind::Breaklines, lines, shift: 0.5 }]
    };
    for (lift, is_one) in [(1.0, true), (1.0f64.next_up(), true), (1.001, false)] {
        let found = Breaklines::new(&lines(lift), (20, 20)).expect("near lines");
        let is_ok = found.check_heights(1.0).is_ok();
        assert_eq!(is_ok, is_one || 5.0 + lift <= 6.0, "{lift}");
        assert_eq!(RequiredLines::new(&lines(lift), (20, 20), 1.0, None, &Default::default()).is_ok(), is_ok);
        if !is_ok {
            let told = found.check_heights(1.0).unwrap_err().to_string();
            assert!(told.contains("column 7, row 7") && told.contains("found 5 in feature 0"), "{told}");
            let field = Field::from_heights(20, 20, crate::base::Heights::F64(vec![0.0; 400])).expect("a field");
            let params = Params { breaklines: Some(Arc::new(found.into())), ..Params::new(1.0) };
            let refused = triangulate(&field, &params, &Control::default());
            assert!(matches!(refused, Err(Error::TwoHeights(_))), "{refused:?}");
        }
    }
}

#[test]
fn meshes_do_not_depend_on_threads() {
    let line = (0..40).map(|i| (f64::from(i) * 2.3, 30.0 + 25.0 * (f64::from(i) * 0.4).sin())).collect();
    let scene = Scene::new((90, 61), 3, vec![line, vec![(45.0, -3.0), (45.0, 70.0)], vec![(10.0, 16.0), (60.0, 16.0)]]);
    let scene = scene.with_gaps(11, 9);
    let params = Params { tile: 16, ..scene.params(2.0) };
    scene.certify(&params);
    let dam = Scene { own: Some(|x, y| 30.0 + x / 9.0 + y / 7.0), ..scene.clone() };
    let params_of_dam = Params { tile: 16, ..dam.params(2.0) };
    dam.certify(&params_of_dam);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let both = [(&scene, &params), (&dam, &params_of_dam)];
        pool.install(|| both.map(|(scene, params)| chunks(&scene.made(params).expect("ground").0)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_mesh_without_the_lines_is_found_out() {
    let scene = Scene::new((30, 20), 2, vec![vec![(1.3, 2.2), (27.6, 17.1)]]);
    let with = Params { tile: 8, ..scene.params(1.0) };
    assert_eq!(scene.made(&with).expect("ground").1.broken.count, 0);
    let (_, verdict) = scene.made(&Params { breaklines: None, ..with.clone() }).expect("ground");
    assert_eq!(verdict.broken.count, 1);
    // As is one that follows a line from farther away, or less closely.
    let near = Scene { shift: 0.0, ..scene.clone() };
    assert_eq!(near.made(&with).expect("ground").1.broken.count, 1);
    let (_, verdict) = scene.made(&Params { tolerance: crate::base::Tolerance::new(1.0), ..with }).expect("ground");
    assert!(verdict.edges > 0 && verdict.stretches == 1);
}

#[test]
fn degenerate_lines() {
    let dot = vec![(5.0, 5.0), (5.0, 5.0)];
    let ends = vec![(9.0, 9.0), (9.02, 9.01), (9.0, 9.0)];
    let star = |i: u32| {
        vec![
            (10.3 + f64::from(i).cos(), 8.4 + f64::from(i).sin()),
            (10.4 - f64::from(i).cos(), 8.4 - f64::from(i).sin()),
        ]
    };
    let all: Vec<(&str, Vec<Line>)> = vec![
        ("nothing", vec![vec![], dot, ends]),
        ("twice", vec![vec![(1.2, 3.4), (18.2, 9.9)], vec![(18.2, 9.9), (1.2, 3.4)], vec![(1.2, 3.4), (18.2, 9.9)]]),
        ("crosses itself", vec![vec![(2.0, 2.0), (15.0, 12.0), (15.0, 2.0), (2.0, 12.0), (2.0, 2.0)]]),
        ("overlaps", vec![vec![(1.0, 4.0), (12.0, 4.0)], vec![(7.0, 4.0), (19.0, 4.0), (19.0, 9.0)]]),
        ("outside", vec![vec![(-9.0, 3.0), (-2.0, 30.0)], vec![(-5.0, 5.0), (40.0, 6.0)]]),
        (
            "through one sample",
            (0..10).map(|i| vec![(10.0 - f64::from(i - 5), 2.0), (10.0 + f64::from(i - 5), 14.0)]).collect(),
        ),
        ("through one cell", (0..10).map(star).collect()),
        (
            "on the rim",
            vec![vec![(0.0, 0.0), (20.0, 0.0), (20.0, 15.0), (0.0, 15.0), (0.0, 0.0)], vec![(3.3, 0.0), (9.9, 0.0)]],
        ),
        ("side by side", vec![vec![(0.0, 5.0), (20.0, 7.0)], vec![(0.0, 5.25), (20.0, 7.25)]]),
        ("a small ring", vec![vec![(4.1, 4.1), (4.6, 4.2), (4.3, 4.7), (4.1, 4.1)]]),
        ("along a seam", vec![vec![(8.0, 1.3), (8.0, 11.8)], vec![(3.2, 8.0), (17.7, 8.0)]]),
    ];
    for (name, lines) in all {
        for (gaps, quality) in [(0, Quality::None), (0, Quality::Balanced), (30, Quality::Balanced)] {
            let scene = Scene::new((21, 16), 5, lines.clone()).with_gaps(4, gaps);
            let params = Params { tile: 8, quality, ..scene.params(1.5) };
            println!("{name}, {gaps} gaps, {quality:?}");
            scene.certify(&params);
            let level = Scene { own: Some(|_, _| 11.0), ..scene };
            level.certify(&Params { breaklines: level.params(1.5).breaklines, ..params });
        }
    }
}

#[test]
fn at_no_tolerance_edges_are_on_the_surface_or_it_is_said_where_not() {
    let mut scene = Scene::new((12, 9), 1, vec![vec![(1.1, 1.2), (9.7, 6.3)]]);
    scene.heights.iter_mut().for_each(|z| *z = z.round());
    scene.certify(&Params { tile: 5, ..scene.params(0.0) });
    scene.heights.iter_mut().enumerate().for_each(|(i, z)| *z = 1.0 / (3.0 + i as f64));
    let field = Field::from_heights(12, 9, crate::base::Heights::F64(scene.heights.clone())).expect("a field");
    let refused = triangulate(&field, &scene.params(0.0), &Control::default());
    assert!(matches!(refused, Err(Error::LineHeight { .. })), "{refused:?}");
}
