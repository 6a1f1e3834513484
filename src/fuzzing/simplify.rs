//! Fuzzing whole runs: bytes choose a field and parameters, and naive code judges the mesh.

use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

use gdal::DriverManager;
use gdal::raster::Buffer;

use super::bytes::Bytes;
use super::naive::{self, Ground, Surface};
use super::temp_dir;
use crate::base::Heights;
use crate::base::PointSet;
use crate::base::control::Control;
use crate::base::exact::{MAX_HEIGHT, MAX_WEIGHT};
use crate::base::staged::StagedFile;
use crate::field::{Field, FieldOptions, HoleOptions};
use crate::formats::{Contents, Header, PlySink, Sink, SinkError};
use crate::job::{EngineChoice, Error, Mesh, Params, Quality, VertexHeights, triangulate};
use crate::kernel::polish::Tuning;
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::hitting_set::{HittingSet, HittingSetOptions, Squares, Stitching};
use crate::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Selection, Shape, Swap,
};
use crate::raster::{Raster, quiet_gdal};
use crate::verify::{GroundOptions, VerifyOptions, verify_ground};

/// The mark of missing samples in files.
const NODATA: f64 = -9999.0;

const TOLERANCES: [f64; 16] =
    [0.0, 1.0, 2.5, 0.5, -0.0, 5e-324, 1e-310, f64::MIN_POSITIVE, 1e-30, 1e-3, 1e6, 1e29, 1e30, 4e30, 1e300, f64::MAX];

const HEIGHTS: [f64; 32] = [
    0.0,
    1.0,
    2.0,
    -1.0,
    f64::NAN,
    7.0,
    -0.0,
    0.1,
    -0.3,
    5e-324,
    -5e-324,
    1e-310,
    2.5,
    f64::MIN_POSITIVE,
    1e-30,
    1e-16,
    1.0000000000000002,
    0.9999999999999999,
    255.0,
    -9999.0,
    -32768.0,
    65535.0,
    8848.86,
    1e6,
    1e15,
    9007199254740993.0,
    1e22,
    -1e22,
    1e29,
    1e30,
    -1e30,
    9.99e29,
];

/// No heights but NaN.
const BAD_HEIGHTS: [f64; 6] = [f64::INFINITY, f64::NEG_INFINITY, 1.1e30, -3.4028234663852886e38, f64::MAX, f64::NAN];

const WEIGHTS: [f64; 12] = [1.0, 0.0, 0.5, 3.0, -0.0, 5e-324, 1e-310, 1e-300, 1e-3, 1e6, 1e29, 1e30];

const BAD_WEIGHTS: [f64; 4] = [f64::NAN, -1.0, f64::INFINITY, 1.1e30];

/// A job as bytes say it.
#[derive(Debug)]
struct Scene {
    width: usize,
    height: usize,
    single: bool,
    /// Through files, and judged by the verifier.
    judged: bool,
    heights: Vec<f64>,
    weights: Vec<f64>,
    /// Holes of at most so many samples are bridged.
    fill_holes: u64,
    params: Params,
}

/// Heights, weights and parameters of all kinds: what can be triangulated is, within the tolerance; what cannot is refused.
pub fn simplify(bytes: &[u8]) {
    let scene = Scene::new(&mut Bytes::new(bytes));
    static POOL: OnceLock<rayon::ThreadPool> = OnceLock::new();
    // One thread: the same bytes take the same path.
    let pool = POOL.get_or_init(|| rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread"));
    pool.install(|| if scene.judged { scene.run_on_files() } else { scene.run() });
}

impl Scene {
    fn new(from: &mut Bytes<'_>) -> Scene {
        let (width, height) = (from.within(2, 12), from.within(2, 12));
        let tile = from.pick(&[0, 2, 3, 4, 5, 6, 7, 8, 1]);
        let max_error = match from.byte() {
            255 => from.double(),
            other => TOLERANCES[usize::from(other) % TOLERANCES.len()],
        };
        let engine = engine(from);
        let (quality, heights) = match from.byte() % 7 {
            0 => (Quality::None, VertexHeights::Sampled),
            1 => (Quality::Fast, VertexHeights::Sampled),
            2 => (Quality::Balanced, VertexHeights::Sampled),
            3 => (Quality::Best, VertexHeights::Sampled),
            4 => (Quality::Fast, VertexHeights::Fitted),
            5 => (Quality::Balanced, VertexHeights::Fitted),
            _ => (Quality::Best, VertexHeights::Fitted),
        };
        let mut tuning = Tuning::default();
        if quality != Quality::None {
            (tuning.min_angle, tuning.strong_edges) =
                (from.pick(&[None, Some(0.0), Some(10.0), Some(20.0), Some(60.0)]), from.bit());
        }
        let feasibility = if from.bit() { Feasibility::Strong } else { Feasibility::Weak };
        let flags = from.byte();
        let [single, weighted, judged, pointed, bad] = std::array::from_fn(|bit| flags >> bit & 1 == 1);
        // Where a raster is written all numbers are double.
        let single = single && !judged;
        let tame = from.within(1, HEIGHTS.len());
        let sample = |from: &mut Bytes<'_>, good: &[f64], wrong: &[f64], most: f64| {
            let value = match from.byte() {
                255 => from.double(),
                254 if bad => from.pick(wrong),
                other => good[usize::from(other) % good.len()],
            };
            // Bits at random are mostly numbers that are refused.
            if bad || value.is_nan() || value.abs() <= most { value } else { 0.0 }
        };
        let mut samples: Vec<f64> =
            (0..width * height).map(|_| sample(from, &HEIGHTS[..tame], &BAD_HEIGHTS, MAX_HEIGHT)).collect();
        if single {
            samples.iter_mut().for_each(|z| *z = f64::from(*z as f32));
            // Rounded, the limit itself is beyond it.
            samples.iter_mut().filter(|z| !bad && z.abs() > MAX_HEIGHT).for_each(|z| *z = 0.0);
        }
        let mut weights = Vec::new();
        if weighted {
            weights.extend((0..width * height).map(|_| sample(from, &WEIGHTS, &BAD_WEIGHTS, MAX_WEIGHT)));
            if !bad {
                weights.iter_mut().for_each(|w| *w = if w.is_nan() { 1.0 } else { w.abs() });
            }
        }
        if judged {
            samples.iter_mut().filter(|z| **z == NODATA).for_each(|z| *z = f64::NAN);
        }
        let mut params = Params {
            engine,
            quality,
            heights,
            tuning,
            feasibility,
            tile,
            temp_dir: temp_dir(),
            ..Params::new(max_error)
        };
        // Behind all samples, so that a file without them has neither.
        let fill_holes = from.pick(&[0, 0, 1, 2, 5, 1000]);
        params.trim = from.pick(&[0, 0, 1, 2, 4, 1000]);
        params.max_stray = from.pick(&[None, None, Some(1.0), Some(2.5), Some(f64::INFINITY)]);
        let heights = samples;
        let mut scene = Scene { width, height, single, judged, heights, weights, fill_holes, params: params.clone() };
        if pointed && engine.capabilities().points {
            let ground = scene.ground();
            let places = (0..4).map(|_| (from.within(0, width - 1), from.within(0, height - 1)));
            let points = places.filter(|&(c, r)| ground.is_ground(c as i64, r as i64)).collect::<Vec<_>>();
            params.points = Some(Arc::new(PointSet::new(points)));
        }
        scene.params = params;
        scene
    }

    fn ground(&self) -> Ground<'_> {
        let ground = Ground::new((self.width, self.height), &self.heights, &self.weights);
        ground.bridging(self.fill_holes as usize).trimmed(self.params.trim)
    }

    /// Whether there is no reason to refuse it.
    fn is_sound(&self) -> bool {
        let is_weighed = |i: usize| self.weights.get(i).is_none_or(|w| (0.0..=MAX_WEIGHT).contains(w));
        let is_sample = |(i, z): (usize, &f64)| z.is_nan() || z.abs() <= MAX_HEIGHT && is_weighed(i);
        let tolerance = self.params.tolerance.kept();
        tolerance.is_finite()
            && tolerance >= 0.0
            && self.heights.iter().enumerate().all(is_sample)
            && !self.ground().is_empty()
    }

    fn run(&self) {
        let of = |values: &[f64], single: bool| {
            let values = match single {
                true => Heights::F32(values.iter().map(|&z| z as f32).collect()),
                false => Heights::F64(values.to_vec()),
            };
            Field::from_heights(self.width, self.height, values).expect("a field")
        };
        let mut field = of(&self.heights, self.single);
        if !self.weights.is_empty() {
            field = field.with_importance(of(&self.weights, false)).expect("weights");
        }
        let made = self.triangulate(field, &Control::default());
        if let Some(mesh) = self.expected(made) {
            self.check(&mesh);
        }
    }

    fn triangulate(&self, field: Field, control: &Control<'_>) -> Result<Mesh, Error> {
        let holes = HoleOptions { most: self.fill_holes, memory_bytes: 1 << 20, temp_dir: temp_dir() };
        let field = field.with_holes_bridged(&holes, control)?;
        triangulate(&field, &self.params, control)
    }

    /// The same by way of a GeoTIFF with a nodata value and a PLY file, judged by the verifier as well.
    fn run_on_files(&self) {
        quiet_gdal();
        let folder = tempfile::tempdir_in(temp_dir()).expect("a folder");
        let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
        // Missing samples by their mark and by NaN, in turn.
        let marked = |(i, &z): (usize, &f64)| if z.is_nan() && i % 2 == 0 { NODATA } else { z };
        let samples: Vec<f64> = self.heights.iter().enumerate().map(marked).collect();
        write(&dem, (self.width, self.height), samples, Some(NODATA));
        let raster = Raster::open(&dem, 1).expect("opens");
        let importance = (!self.weights.is_empty()).then(|| {
            let path = folder.path().join("weights.tif");
            write(&path, (self.width, self.height), self.weights.clone(), None);
            Raster::open(&path, 1).and_then(|raster| raster.to_band()).expect("opens")
        });
        let (importance, control) = (importance.as_ref(), Control::default());
        let options = FieldOptions { temp_dir: temp_dir(), ..FieldOptions::default() };
        let field = Field::open_with_importance(&raster.to_band().expect("a band"), importance, &options, &control)
            .expect("a field");
        let Some(mesh) = self.expected(self.triangulate(field, &control)) else { return };
        self.check(&mesh);
        let sink = PlySink::new(StagedFile::create(&tin, false, &[&dem]).expect("staged"), Header::default());
        let summary = mesh.write(Box::new(sink), &control).expect("written");
        let options = VerifyOptions {
            lines: None,
            max_error: self.params.tolerance.kept(),
            max_stray: self.params.limit_on_straying(self.params.features()),
            importance,
            temp_dir: Some(folder.path().to_path_buf()),
        };
        let ground = GroundOptions { fill_holes: self.fill_holes, trim: self.params.trim };
        let verdict =
            verify_ground(&raster.to_band().expect("a band"), &tin, &options, ground, None, &control).expect("judged");
        assert!(verdict.passes(), "{verdict} for {self:?}");
        assert_eq!((verdict.vertices, verdict.triangles), (summary.vertices, summary.triangles));
    }

    /// The mesh, where there is to be one.
    fn expected(&self, made: Result<Mesh, Error>) -> Option<Mesh> {
        match made {
            Ok(mesh) => {
                assert!(self.is_sound(), "a mesh of {self:?}");
                Some(mesh)
            }
            Err(refused) => {
                assert!(!self.is_sound(), "{refused} for {self:?}");
                None
            }
        }
    }

    fn check(&self, mesh: &Mesh) {
        let told = Arc::new(Mutex::new(Surface::default()));
        mesh.write(Box::new(Listener(told.clone())), &Control::default()).expect("written");
        let surface = told.lock().expect("whole");
        let found = self.ground().check(&surface, self.params.tolerance.kept());
        assert!(found.is_ok(), "{found:?} for {self:?}");
        for (column, row) in self.params.points.iter().flat_map(|points| points.iter()) {
            let place = (4 * column as i64, 4 * row as i64);
            assert!(surface.places.contains(&place), "no vertex at point {column}, {row} of {self:?}");
        }
        if self.params.heights == VertexHeights::Sampled {
            for (&(x, y), z) in surface.places.iter().zip(&surface.heights) {
                let sample = self.heights[(y / 4) as usize * self.width + (x / 4) as usize];
                let is_free = sample.is_nan() && self.fill_holes > 0;
                assert!((x % 4, y % 4) == (0, 0) && (*z == sample || is_free), "vertex {x}, {y}, {z} of {self:?}");
            }
        }
    }
}

fn engine(from: &mut Bytes<'_>) -> EngineChoice {
    let default = InsertionOptions::default();
    let swap = |swap| InsertionOptions { swap, ..default };
    let measure = |measure| InsertionOptions { measure, ..default };
    let dependent =
        |fit, shape, quality_threshold| swap(Swap::DataDependent(DataDependent { fit, shape, quality_threshold }));
    let options = match from.byte() % 16 {
        0 => default,
        1 => return EngineChoice::GreedyCuts(GreedyCuts::PLAIN),
        2 => return EngineChoice::GreedyCuts(GreedyCuts::IMPROVED),
        3 => swap(Swap::DataDependent(DataDependent::default())),
        4 => dependent(Fit::L2, Shape::SmallestAngle, 0.0),
        5 => dependent(Fit::LInfinity, Shape::AreaOverDiameter, 0.5),
        6 => dependent(Fit::L2, Shape::AreaOverDiameter, 1.0),
        7 => InsertionOptions { selection: Selection::Fractional(0.6), ..default },
        8 => InsertionOptions { selection: Selection::Constant, ..default },
        9 => measure(Measure::Curvature(1.0)),
        10 => measure(Measure::GlobalError),
        11 => measure(Measure::Product(2.0)),
        12 => return EngineChoice::HittingSet(HittingSet::default()),
        13 => return hitting_set(HittingSetOptions { stitching: Stitching::Shared, ..HittingSetOptions::default() }),
        14 => return hitting_set(HittingSetOptions { squares: Squares::Sliding, ..HittingSetOptions::default() }),
        _ => measure(Measure::Curvature(0.0)),
    };
    EngineChoice::GreedyInsertion(GreedyInsertion { options })
}

fn hitting_set(options: HittingSetOptions) -> EngineChoice {
    EngineChoice::HittingSet(HittingSet { options })
}

fn write(path: &Path, size: (usize, usize), samples: Vec<f64>, nodata: Option<f64>) {
    let driver = DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    let dataset = driver.create_with_band_type::<f64, _>(path, size.0, size.1, 1).expect("a raster");
    {
        let mut band = dataset.rasterband(1).expect("a band");
        band.set_no_data_value(nodata).expect("a nodata value");
        band.write((0, 0), size, &mut Buffer::new(size, samples)).expect("written");
    }
    dataset.close().expect("closed");
}

/// Keeps the mesh.
struct Listener(Arc<Mutex<Surface>>);

impl Sink for Listener {
    fn begin(&mut self, _: &Contents<'_>) -> Result<(), SinkError> {
        Ok(())
    }
    fn vertices(&mut self, vertices: &[[f64; 3]], _: &[&[f64]]) -> Result<(), SinkError> {
        let mut surface = self.0.lock().expect("whole");
        for &[x, y, z] in vertices {
            surface.places.push(naive::place(x, y));
            surface.heights.push(z);
        }
        Ok(())
    }
    fn triangles(&mut self, triangles: &[[u64; 3]], _: &[[[f64; 3]; 3]]) -> Result<(), SinkError> {
        self.0.lock().expect("whole").faces.extend(triangles.iter().map(|t| t.map(|v| v as usize)));
        Ok(())
    }
    fn finish(self: Box<Self>) -> Result<(), SinkError> {
        Ok(())
    }
}
