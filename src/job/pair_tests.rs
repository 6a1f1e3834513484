//! All pairs of features: each runs and passes the verifier, or stands in the book; and then its way out does.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use gdal::DriverManager;
use gdal::raster::Buffer;

use super::*;
use crate::base::channels::ChannelBands;
use crate::base::control::Control;
use crate::base::features::{Feature, FeatureSet};
use crate::base::staged::StagedFile;
use crate::base::{Band, LineKind, LineSet, PointSet, Polylines};
use crate::field::{Field, FieldOptions, HoleOptions, find_ranges};
use crate::formats::{Header, PlySink, ReadOptions, open};
use crate::kernel::breaklines::Breaklines;
use crate::kernel::polish::{Schedule, Tuning};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::hitting_set::{Corners, HittingSet, HittingSetOptions, Squares, Stitching};
use crate::kernel::triangulate::insertion::{
    DataDependent, GreedyInsertion, InsertionOptions, Measure, Selection, Swap,
};
use crate::testing;
use crate::verify::{GroundOptions, RequiredLines, VerifyOptions, verify_ground, verify_lines};

/// What parameters and fields can have. The others are matters of options, of samples or of the output; the command line
/// walks all.
pub(crate) const OF_A_RUN: [Feature; 32] = [
    Feature::VertexBudget,
    Feature::TriangleBudget,
    Feature::RmsGoal,
    Feature::Attributes,
    Feature::Image,
    Feature::Importance,
    Feature::Points,
    Feature::Breaklines,
    Feature::Lakes,
    Feature::Footprints,
    Feature::ExactCutline,
    Feature::LineHeights,
    Feature::Trim,
    Feature::FilledVoids,
    Feature::Polishing,
    Feature::FittedHeights,
    Feature::MinAngle,
    Feature::MaxStray,
    Feature::PolishingNumbers,
    Feature::StrongPolishEdges,
    Feature::StrongFeasibility,
    Feature::GreedyCuts,
    Feature::CutOrder,
    Feature::HittingSet,
    Feature::Squares,
    Feature::FreeCorners,
    Feature::Stitching,
    Feature::DataDependentSwap,
    Feature::FractionalSelection,
    Feature::ConstantSelection,
    Feature::GlobalErrorMeasure,
    Feature::SmoothedMeasure,
];

const SIZE: (usize, usize) = (22, 18);
const TOLERANCE: f64 = 1.5;
const TRIM: u32 = 2;
const FILL_HOLES: u64 = 9;

/// A raster with a void in its middle and one at its rim, two bands of colours and one of weights.
struct Scene {
    folder: tempfile::TempDir,
    raster: Band,
    bands: Vec<Band>,
    importance: Band,
}

impl Scene {
    fn new() -> Scene {
        let folder = testing::folder();
        let path = folder.path().join("dem.tif");
        let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
        let dataset = driver.create_with_band_type::<f64, _>(&path, SIZE.0, SIZE.1, 4).expect("a raster");
        let terrain = super::tests::terrain(3, SIZE.0, SIZE.1);
        let is_void = |(c, r): (usize, usize)| ((8..10).contains(&c) && (7..9).contains(&r)) || (c > 18 && r < 3);
        let place = |i: usize| (i % SIZE.0, i / SIZE.0);
        let heights = terrain.iter().enumerate().map(|(i, &z)| if is_void(place(i)) { f64::NAN } else { z });
        let bands: [Vec<f64>; 4] = [
            heights.collect(),
            (0..terrain.len()).map(|i| (place(i).0 * 9 % 256) as f64).collect(),
            (0..terrain.len()).map(|i| if place(i).1 < 9 { 20.0 } else { 230.0 }).collect(),
            (0..terrain.len()).map(|i| 0.25 * (i % 5) as f64).collect(),
        ];
        for (number, samples) in bands.into_iter().enumerate() {
            let mut band = dataset.rasterband(number + 1).expect("a band");
            band.write((0, 0), SIZE, &mut Buffer::new(SIZE, samples)).expect("written");
        }
        dataset.close().expect("closed");
        let [raster, importance] = [1, 4].map(|band| testing::band(&path, band));
        let bands = [2, 3].map(|band| testing::band(&path, band)).to_vec();
        Scene { folder, raster, bands, importance }
    }

    fn field(&self, set: FeatureSet) -> Field {
        let control = Control::default();
        let options = FieldOptions { temp_dir: self.temp_dir(), ..FieldOptions::default() };
        if let Some(channels) = self.attributes(set) {
            let ranges = find_ranges(&self.raster, &channels, &control).expect("ranges");
            return Field::open_extended(&self.raster, &options, &channels, &ranges, &control).expect("a field");
        }
        let importance = set.has(Feature::Importance).then_some(&self.importance);
        let field = Field::open_with_importance(&self.raster, importance, &options, &control).expect("a field");
        let most = if set.has(Feature::FilledVoids) { FILL_HOLES } else { 0 };
        let holes = HoleOptions { most, memory_bytes: 1 << 20, temp_dir: self.temp_dir() };
        field.with_holes_bridged(&holes, &control).expect("a field")
    }

    fn attributes(&self, set: FeatureSet) -> Option<ChannelBands> {
        let of = |emphasis, planar| ChannelBands { bands: self.bands.clone(), emphasis, planar };
        match (set.has(Feature::Image), set.has(Feature::Attributes)) {
            (true, _) => Some(of(1.0, true)),
            (false, true) => Some(of(0.5, false)),
            (false, false) => None,
        }
    }

    fn temp_dir(&self) -> PathBuf {
        self.folder.path().to_path_buf()
    }

    /// The verifier must be content with the mesh.
    fn judge(&self, mesh: &Mesh, set: FeatureSet) {
        let (tin, control) = (self.folder.path().join("tin.ply"), Control::default());
        let staged = StagedFile::create(&tin, true, &[] as &[&Path]).expect("staged");
        mesh.write(Box::new(PlySink::new(staged, Header::default())), &control).expect("written");
        let importance = set.has(Feature::Importance).then_some(&self.importance);
        let quality = if set.has(Feature::Polishing) { Quality::Balanced } else { Quality::None };
        let usual = rules::default_max_stray(set, quality);
        let max_stray = Some(if set.has(Feature::MaxStray) { 1.0 } else { usual }).filter(|limit| limit.is_finite());
        // Budgets are large enough, but a root mean square may be reached with larger errors.
        let max_error = mesh.tolerance().asked().min(TOLERANCE);
        let sets = lines(set);
        let lines = (!sets.is_empty()).then(|| {
            RequiredLines::new(&sets, SIZE, max_error, None, &Default::default()).expect("lines that can be judged")
        });
        let (lines_asked, temp_dir) = (lines.as_ref(), Some(self.temp_dir()));
        let options = VerifyOptions { max_error, max_stray, importance, lines: lines_asked, temp_dir };
        let ground = GroundOptions {
            fill_holes: if set.has(Feature::FilledVoids) { FILL_HOLES } else { 0 },
            trim: if set.has(Feature::Trim) { TRIM } else { 0 },
        };
        let weighted = self.attributes(set);
        let verdict = verify_ground(&self.raster, &tin, &options, ground, weighted.as_ref(), &control);
        let verdict = verdict.unwrap_or_else(|e| panic!("{e} for {set:?}"));
        assert!(verdict.passes(), "{verdict} for {set:?}");
        if let Some(lines) = &lines {
            let mut reader = open(&tin, None, &ReadOptions::default()).expect("a mesh");
            let found = verify_lines(&self.raster, reader.as_mut(), TOLERANCE, lines, &control.cancel).expect("judged");
            assert!(found.edges > 0 && found.broken.count == 0, "{found} for {set:?}");
        }
    }
}

/// A line over voids and seams, and one along a seam, with heights of their own that agree where they meet; a lake, and an outline across.
fn lines(set: FeatureSet) -> Vec<LineSet> {
    let lines = vec![vec![(0.2, 1.1), (12.0, 9.25), (20.8, 15.3)], vec![(12.0, 3.5), (12.0, 16.2)]];
    let heights = lines.iter().map(|line| line.iter().map(|(x, _)| 40.0 + x / 4.0).collect()).collect();
    let lines = Polylines::new(lines);
    let lines = if set.has(Feature::LineHeights) { lines.with_heights(heights) } else { lines };
    let breaklines = LineSet { kind: LineKind::Breaklines, lines, shift: 0.5 };
    let outline = vec![vec![(4.3, 9.2), (15.6, 8.1), (14.4, 16.3), (4.3, 9.2)]];
    let footprints = LineSet { kind: LineKind::Footprints, lines: Polylines::new(outline), shift: 0.5 };
    let shore = vec![(15.2, 1.3), (17.7, 3.9), (14.6, 6.2), (15.2, 1.3)];
    let level = vec![vec![50.0; shore.len()]];
    let lakes = LineSet { kind: LineKind::Lakes, lines: Polylines::new(vec![shore]).with_heights(level), shift: 0.0 };
    let area = vec![(0.7, 0.6), (19.3, 1.4), (20.1, 16.2), (1.2, 15.4), (0.7, 0.6)];
    let cutline = LineSet { kind: LineKind::Cutline, lines: Polylines::new(vec![area]), shift: 0.0 };
    [breaklines, lakes, footprints, cutline].into_iter().filter(|lines| set.has(lines.kind.feature())).collect()
}

/// Parameters that ask for what is in the set, as far as they can at the same time.
fn params(set: FeatureSet, temp_dir: PathBuf) -> Params {
    let insertion = InsertionOptions {
        swap: match set.has(Feature::DataDependentSwap) {
            true => Swap::DataDependent(DataDependent::default()),
            false => Swap::Delaunay,
        },
        selection: match (set.has(Feature::FractionalSelection), set.has(Feature::ConstantSelection)) {
            (true, _) => Selection::Fractional(0.8),
            (false, true) => Selection::Constant,
            (false, false) => Selection::Sequential,
        },
        measure: match (set.has(Feature::GlobalErrorMeasure), set.has(Feature::SmoothedMeasure)) {
            (true, _) => Measure::GlobalError,
            (false, true) => Measure::Product(1.0),
            (false, false) => Measure::LocalError,
        },
    };
    let hitting_set = HittingSetOptions {
        squares: if set.has(Feature::Squares) { Squares::Sliding } else { Squares::Nested },
        corners: if set.has(Feature::FreeCorners) { Corners::Free } else { Corners::Samples },
        stitching: if set.has(Feature::Stitching) { Stitching::Shared } else { Stitching::Merged },
    };
    let engine = match (set.has(Feature::GreedyCuts), set.has(Feature::CutOrder)) {
        (true, true) => GreedyCuts::IMPROVED.into(),
        (true, false) => GreedyCuts::PLAIN.into(),
        _ if set.has(Feature::HittingSet) => HittingSet { options: hitting_set }.into(),
        (false, _) => GreedyInsertion { options: insertion }.into(),
    };
    let heights = if set.has(Feature::FittedHeights) { VertexHeights::Fitted } else { VertexHeights::Sampled };
    let schedule = Schedule { rounds: 2, ..Schedule::preset(Default::default(), heights) };
    Params {
        engine,
        feasibility: if set.has(Feature::StrongFeasibility) { Feasibility::Strong } else { Feasibility::Weak },
        max_stray: set.has(Feature::MaxStray).then_some(1.0),
        quality: if set.has(Feature::Polishing) { Quality::Balanced } else { Quality::None },
        heights,
        tuning: Tuning {
            schedule: set.has(Feature::PolishingNumbers).then_some(schedule),
            min_angle: set.has(Feature::MinAngle).then_some(10.0),
            strong_edges: set.has(Feature::StrongPolishEdges),
        },
        // Large enough for the tolerance to be kept.
        goal: Goal {
            max_points: set.has(Feature::VertexBudget).then_some(2000),
            max_triangles: set.has(Feature::TriangleBudget).then_some(4000),
            max_rms: set.has(Feature::RmsGoal).then_some(TOLERANCE),
        },
        tile: 12,
        trim: if set.has(Feature::Trim) { TRIM } else { 0 },
        breaklines: Some(lines(set))
            .filter(|sets| !sets.is_empty())
            .map(|sets| Arc::new(Breaklines::new(&sets, SIZE).expect("near lines").into())),
        points: set.has(Feature::Points).then(|| Arc::new(PointSet::new([(3, 3), (12, 5)]))),
        temp_dir,
        ..Params::new(TOLERANCE)
    }
}

/// Whether a field has what it is asked to have: it says so itself where not.
fn has_a_field(set: FeatureSet) -> bool {
    let besides = [Feature::Importance, Feature::FilledVoids].into_iter().any(|f| set.has(f));
    !besides || !set.has(Feature::Attributes) && !set.has(Feature::Image)
}

#[test]
fn pairs_of_features_run_or_stand_in_the_book() {
    let (scene, control) = (Scene::new(), Control::default());
    let (mut run, mut refused) = (0, 0);
    for (i, &a) in OF_A_RUN.iter().enumerate() {
        for &b in &OF_A_RUN[i..] {
            let mut set: FeatureSet = [a, b].into_iter().collect();
            if let Err(incompatible) = rules::check(set) {
                refused += 1;
                let params = params(set, scene.temp_dir());
                // What cannot even be said need not be refused again.
                if has_a_field(set) && params.features().and(FeatureSet::of_field(&scene.field(set))) == set {
                    let field = scene.field(set);
                    for error in
                        [triangulate(&field, &params, &control).err(), probe_field(&field, &params, &control).err()]
                    {
                        let Some(Error::Incompatible(found)) = error else { panic!("{error:?} for {set:?}") };
                        assert_eq!(found, incompatible);
                    }
                }
                set = incompatible.conflicts.iter().fold(set, |set, conflict| conflict.resolve(set));
            } else {
                run += 1;
            }
            let (field, params) = (scene.field(set), params(set, scene.temp_dir()));
            assert_eq!(params.features().and(FeatureSet::of_field(&field)), set);
            let mesh = triangulate(&field, &params, &control).unwrap_or_else(|e| panic!("{e} for {set:?}"));
            let expected = probe_field(&field, &params, &control).unwrap_or_else(|e| panic!("{e} for {set:?}"));
            assert!(expected.samples_per_triangle > 0.0);
            scene.judge(&mesh, set);
        }
    }
    assert!(run > 100 && refused > 100, "{run} pairs run, {refused} are refused");
}
