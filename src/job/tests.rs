//! Whole runs in memory and through files: certified by `verify`, the same for any number of threads, and their golden counts.

use std::path::Path;
use std::sync::{Arc, Mutex};

use gdal::DriverManager;
use gdal::raster::Buffer;
use proptest::prelude::*;

use super::*;
use crate::base::Heights;
use crate::base::Window;
use crate::base::control::Control;
use crate::base::staged::StagedFile;
use crate::field::{Field, FieldOptions};
use crate::formats::{Contents, Header, PlySink, Sink, SinkError};
use crate::job::spool::{Chunk, Spool};
use crate::kernel::polish::{Effort, Schedule, Tuning};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::hitting_set::{HittingSet, HittingSetOptions, Squares};
use crate::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Selection, Shape, Swap,
};
use crate::synth::{Terrain, TerrainOptions};
use crate::testing;
use crate::verify::{VerifyOptions, verify};

/// Our own ground: hills, flat lakes, cliffs.
pub(super) fn terrain(seed: u64, width: usize, height: usize) -> Vec<f64> {
    let options = TerrainOptions { seed, lakes: 0.1, cliffs: seed % 2 == 1, ..TerrainOptions::default() };
    let mut heights = vec![0.0; width * height];
    let window = Window { column: 1000, row: 2000, width, height };
    Terrain::new(&options).expect("options").fill(window, &mut heights);
    heights
}

pub(super) fn geotiff(path: &Path, width: usize, height: usize, heights: &[f64]) {
    let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type::<f64, _>(path, width, height, 1).expect("a raster");
    let mut samples = Buffer::new((width, height), heights.to_vec());
    dataset.rasterband(1).expect("a band").write((0, 0), (width, height), &mut samples).expect("written");
    dataset.close().expect("closed");
}

pub(super) fn mesh(width: usize, height: usize, heights: Vec<f64>, params: &Params) -> Mesh {
    let field = Field::from_heights(width, height, Heights::F64(heights)).expect("a field");
    triangulate(&field, params, &Control::default()).expect("a mesh")
}

/// Simplifies a raster and has the written file judged by code that shares nothing with the engines.
fn certify(width: usize, height: usize, heights: &[f64], params: &Params) {
    certify_weighted(width, height, heights, None, params);
}

/// The same with the weights of errors, where there are some.
pub(super) fn certify_weighted(width: usize, height: usize, heights: &[f64], weights: Option<&[f64]>, params: &Params) {
    let folder = testing::folder();
    let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
    geotiff(&dem, width, height, heights);
    let raster = testing::band(&dem, 1);
    let importance = weights.map(|weights| {
        let path = folder.path().join("weights.tif");
        geotiff(&path, width, height, weights);
        testing::band(&path, 1)
    });
    let (importance, options) = (importance.as_ref(), FieldOptions::default());
    let field = Field::open_with_importance(&raster, importance, &options, &Control::default()).expect("a field");
    let mesh = triangulate(&field, &testing::in_memory(params), &Control::default()).expect("a mesh");
    let sink = PlySink::new(StagedFile::create(&tin, false, &[&dem]).expect("staged"), Header::default());
    let summary = mesh.write(Box::new(sink), &Control::default()).expect("written");
    let max_stray = params.limit_on_straying(params.features());
    let options =
        VerifyOptions { lines: None, max_error: params.tolerance.kept(), max_stray, importance, temp_dir: None };
    let verdict = verify(&raster, &tin, &options, &Control::default()).expect("judged");
    assert!(verdict.passes(), "{:?} for {params:?}", verdict.failures());
    assert_eq!((verdict.vertices, verdict.triangles), (summary.vertices, summary.triangles));
}

/// Every engine, and every variant of it.
pub(super) fn engines() -> Vec<EngineChoice> {
    let default = InsertionOptions::default();
    let swaps = [
        Swap::Delaunay,
        Swap::DataDependent(DataDependent::default()),
        Swap::DataDependent(DataDependent { fit: Fit::L2, shape: Shape::SmallestAngle, quality_threshold: 0.0 }),
        Swap::DataDependent(DataDependent { fit: Fit::LInfinity, ..DataDependent::default() }),
    ];
    let selections = [Selection::Fractional(0.6), Selection::Constant];
    let measures = [Measure::Curvature(1.0), Measure::GlobalError, Measure::Product(2.0)];
    let swaps = swaps.map(|swap| InsertionOptions { swap, ..default });
    let selections = selections.map(|selection| InsertionOptions { selection, ..default });
    let measures = measures.map(|measure| InsertionOptions { measure, ..default });
    let insertion = swaps
        .into_iter()
        .chain(selections)
        .chain(measures)
        .map(|options| EngineChoice::GreedyInsertion(GreedyInsertion { options }));
    let cuts = [GreedyCuts::PLAIN, GreedyCuts::IMPROVED].map(EngineChoice::GreedyCuts);
    let sliding = HittingSetOptions { squares: Squares::Sliding, ..HittingSetOptions::default() };
    let hitting_sets = [HittingSet::default(), HittingSet { options: sliding }].map(EngineChoice::HittingSet);
    cuts.into_iter().chain(hitting_sets).chain(insertion).collect()
}

#[test]
fn what_is_tuned_is_part_of_what_a_work_dir_is_for() {
    let usual = Params::new(1.0);
    let tuned = |tuning| Params { tuning, ..usual.clone() }.named();
    let schedule = Schedule::preset(Effort::Balanced, VertexHeights::Sampled);
    let more = Schedule { rounds: 4, ..schedule };
    assert_eq!(tuned(Tuning { schedule: Some(schedule), ..Tuning::default() }), usual.named());
    let others = [
        Tuning { schedule: Some(more), ..Tuning::default() },
        Tuning { min_angle: Some(10.0), ..Tuning::default() },
        Tuning { min_angle: Some(20.0), ..Tuning::default() },
        Tuning { strong_edges: true, ..Tuning::default() },
    ];
    let mut named: Vec<_> = others.map(tuned).into_iter().chain([usual.named()]).collect();
    named.sort();
    named.dedup();
    assert_eq!(named.len(), 5);
    let field = Field::from_heights(2, 2, Heights::F64(vec![0.0; 4])).expect("a field");
    let refused = |tuning| Params { tuning, ..usual.clone() }.check(&field).is_err();
    assert!(refused(Tuning { min_angle: Some(61.0), ..Tuning::default() }));
    assert!(refused(Tuning { schedule: Some(Schedule { places: 7, ..schedule }), ..Tuning::default() }));
}

/// Every quality, with heights of both kinds.
pub(super) fn qualities() -> Vec<(Quality, VertexHeights)> {
    let polished = [Quality::Fast, Quality::Balanced, Quality::Best];
    let all = polished.into_iter().flat_map(|q| [VertexHeights::Sampled, VertexHeights::Fitted].map(|h| (q, h)));
    std::iter::once((Quality::None, VertexHeights::Sampled)).chain(all).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn what_is_written_passes_the_verifier(
        width in 2usize..40, height in 2usize..40, seed in any::<u64>(), kind in 0u8..4,
        max_error in prop_oneof![Just(0.0), Just(1.0), Just(2.5), 0.0f64..6.0, Just(1e6)],
        tile in prop_oneof![Just(0usize), 1usize..12, Just(16), Just(512)], strong in any::<bool>(),
        engine in prop::sample::select(engines()),
        (quality, vertices) in prop::sample::select(qualities()),
    ) {
        let noise = |i: usize| (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 48;
        let heights = match kind {
            0 => (0..width * height).map(|i| (noise(i) % 9) as f64).collect(),
            1 => (0..width * height).map(|i| noise(i) as f64 * 1e-4).collect(),
            2 => terrain(seed % 64, width, height),
            _ => vec![-11.5; width * height],
        };
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let params = Params { feasibility, tile, engine, quality, heights: vertices, ..Params::new(max_error) };
        certify(width, height, &heights, &params);
    }
}

/// Keeps all it is told.
#[derive(Default, Clone, PartialEq, Debug)]
pub(super) struct Told {
    counts: (u64, u64),
    pub(super) vertices: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u64; 3]>,
    finished: bool,
}

struct Listener(Arc<Mutex<Told>>);

impl Sink for Listener {
    fn begin(&mut self, contents: &Contents<'_>) -> Result<(), SinkError> {
        self.0.lock().expect("whole").counts = (contents.vertices, contents.triangles);
        Ok(())
    }
    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        self.0.lock().expect("whole").vertices.extend_from_slice(vertices);
        Ok(())
    }
    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        self.0.lock().expect("whole").triangles.extend_from_slice(triangles);
        Ok(())
    }
    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        self.0.lock().expect("whole").finished = true;
        Ok(())
    }
}

pub(super) fn told(mesh: &Mesh) -> Told {
    let told = Arc::new(Mutex::new(Told::default()));
    mesh.write(Box::new(Listener(told.clone())), &Control::default()).expect("written");
    let told = told.lock().expect("whole");
    assert!(told.finished && told.counts == (told.vertices.len() as u64, told.triangles.len() as u64));
    told.clone()
}

#[test]
fn neither_the_order_of_tiles_nor_threads_change_what_is_written() {
    let heights = terrain(3, 200, 150);
    for engine in engines() {
        let params = Params { tile: 32, engine, quality: Quality::None, ..Params::new(4.0) };
        the_same_on_any_number_of_threads(&heights, &params);
    }
    for quality in [Quality::Fast, Quality::Balanced, Quality::Best] {
        for vertices in [VertexHeights::Sampled, VertexHeights::Fitted] {
            let params = Params { tile: 32, quality, heights: vertices, ..Params::new(4.0) };
            the_same_on_any_number_of_threads(&heights, &params);
        }
    }
}

fn the_same_on_any_number_of_threads(heights: &[f64], params: &Params) {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| mesh(200, 150, heights.to_vec(), params))
    };
    let (one, three) = (on(1), on(3));
    let expected = told(&one);
    assert!(told(&three) == expected);
    // The same chunks in a spool that got them last tile first.
    let backwards = Spool::new(&params.temp_dir, one.chunks.len()).expect("a spool");
    let chunks: Vec<Chunk> = one.chunks().collect::<Result<_, _>>().expect("chunks");
    let mut buffer = Vec::new();
    chunks.iter().rev().for_each(|c| backwards.append(c, &mut buffer).expect("kept"));
    assert!(told(&Mesh { spool: backwards, ..three }) == expected);
}

#[test]
fn a_cancelled_run_says_so() {
    let control = Control::default();
    control.cancel.cancel();
    let field = Field::from_heights(50, 50, Heights::F64(terrain(1, 50, 50))).expect("a field");
    let run = triangulate(&field, &Params::new(1.0), &control);
    assert!(matches!(run, Err(Error::Cancelled(_))), "{run:?}");
}

#[test]
fn tolerances_that_are_none_and_tiles_too_long_are_refused() {
    let field = Field::from_heights(2, 2, Heights::F64(vec![0.0; 4])).expect("a field");
    for wrong in [-1.0, f64::NAN, f64::INFINITY] {
        let run = triangulate(&field, &Params::new(wrong), &Control::default());
        assert!(matches!(run, Err(Error::Tolerance(_))));
    }
    let params = Params { tile: 0, ..Params::new(1.0) };
    assert!(matches!(grid(300_000, 2, &params), Err(Error::Tile { .. })));
    assert!(grid(300_000, 2, &Params::new(1.0)).is_ok());
}

/// One line of `fixtures/golden.json`.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
struct Golden {
    seed: u64,
    size: (usize, usize),
    max_error: f64,
    feasibility: String,
    cuts: String,
    quality: String,
    tile: usize,
    triangles: u64,
}

/// Counts of triangles may only go down. Where they do, `TERRABITE_GOLDEN=write cargo test golden` notes the new ones.
#[test]
fn golden_counts_do_not_go_up() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/golden.json");
    let text = std::fs::read_to_string(&path).expect("fixtures/golden.json");
    let mut golden: Vec<Golden> = serde_json::from_str(&text).expect("golden counts");
    assert!(golden.len() >= 12, "{} golden counts", golden.len());
    let write = std::env::var_os("TERRABITE_GOLDEN").is_some_and(|v| v == "write");
    let mut risen = Vec::new();
    for line in &mut golden {
        let feasibility = if line.feasibility == "strong" { Feasibility::Strong } else { Feasibility::Weak };
        let engine =
            EngineChoice::GreedyCuts(if line.cuts == "plain" { GreedyCuts::PLAIN } else { GreedyCuts::IMPROVED });
        let all = [Quality::None, Quality::Fast, Quality::Balanced, Quality::Best];
        let quality = all.into_iter().find(|q| q.name() == line.quality).expect("a quality");
        let params = Params { feasibility, engine, quality, tile: line.tile, ..Params::new(line.max_error) };
        let (width, height) = line.size;
        let found: u64 = mesh(width, height, terrain(line.seed, width, height), &params)
            .chunks()
            .map(|c| c.expect("a chunk").triangles.len() as u64)
            .sum();
        if found > line.triangles {
            risen.push(format!("{found} triangles, expected {line:?}"));
        }
        line.triangles = found;
    }
    assert!(write || risen.is_empty(), "{}", risen.join("\n"));
    if write {
        let lines: Vec<String> = golden.iter().map(|l| serde_json::to_string(l).expect("plain data")).collect();
        std::fs::write(path, format!("[\n{}\n]\n", lines.join(",\n"))).expect("written");
    }
}

/// Found by a property: among the smallest numbers there are, rounding loses absolutely, which no share of a number covers.
#[test]
fn the_smallest_numbers_are_heights_too() {
    let (width, height) = (24, 20);
    let heights: Vec<f64> =
        (0..width * height).map(|i| f64::from_bits((i as u64 * i as u64 * 7 + i as u64 * 13) % 11)).collect();
    for engine in EngineChoice::all() {
        for (quality, tolerance) in [(Quality::None, 0), (Quality::None, 1), (Quality::None, 3), (Quality::Fast, 1)] {
            let params = Params { engine, quality, tile: 16, ..Params::new(f64::from_bits(tolerance)) };
            // `measure` asserts that no error is larger.
            mesh(width, height, heights.clone(), &params);
        }
    }
}
