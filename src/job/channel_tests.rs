//! Meshes with channels from bands to file, as the independent verifier finds them.

use std::path::{Path, PathBuf};

use gdal::raster::{Buffer, GdalType, RasterCreationOptions};
use proptest::prelude::*;

use super::*;
use crate::base::Band;
use crate::base::channels::ChannelBands;
use crate::base::control::Control;
use crate::base::features::{Feature, FeatureSet};
use crate::base::staged::StagedFile;
use crate::field::{Field, FieldOptions, find_ranges};
use crate::formats::ply::read::{PlyFile, ScalarType};
use crate::formats::{FORMATS, Header, PlySink};
use crate::kernel::triangulate::Feasibility;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::{DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Swap};
use crate::testing;
use crate::verify::{GroundOptions, Verdict, VerifyOptions, verify_ground, verify_with_channels};

fn by(swap: Swap, params: Params) -> Params {
    let engine = EngineChoice::GreedyInsertion(GreedyInsertion {
        options: InsertionOptions { swap, ..InsertionOptions::default() },
    });
    Params { engine, quality: Quality::None, ..params }
}

fn delaunay(params: Params) -> Params {
    by(Swap::Delaunay, params)
}

/// Which bands of a file are channels.
#[derive(Debug, Clone)]
struct Choice {
    bands: Vec<usize>,
    emphasis: f64,
    planar: bool,
}

impl Choice {
    fn open(&self, path: &Path) -> ChannelBands {
        let bands = self.bands.iter().map(|&number| testing::band(path, number)).collect();
        ChannelBands { bands, emphasis: self.emphasis, planar: self.planar }
    }
}

/// A raster whose bands are functions of column, row and band.
fn geotiff<T: GdalType + Copy>(path: &Path, (width, height): (usize, usize), bands: &[Vec<f64>]) {
    let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("GTiff");
    // Else GDAL takes the fourth of four bands of bytes for a mask.
    let options: RasterCreationOptions = ["PHOTOMETRIC=MINISBLACK", "ALPHA=NO"].into_iter().collect();
    let dataset = driver.create_with_band_type_with_options::<T, _>(path, width, height, bands.len(), &options);
    let dataset = dataset.expect("a raster");
    for (i, values) in bands.iter().enumerate() {
        let mut buffer = Buffer::new((width, height), values.clone());
        dataset.rasterband(i + 1).expect("a band").write((0, 0), (width, height), &mut buffer).expect("written");
    }
    dataset.close().expect("closed");
}

/// A written mesh with channels, and what it was made from.
struct Made {
    _folder: tempfile::TempDir,
    tin: PathBuf,
    raster: Band,
    channels: ChannelBands,
    summary: Summary,
}

impl Made {
    fn new(folder: tempfile::TempDir, channels: &Choice, params: &Params) -> Made {
        let (dem, tin) = (folder.path().join("dem.tif"), folder.path().join("tin.ply"));
        let raster = testing::band(&dem, if channels.planar { channels.bands[0] } else { 1 });
        let channels = channels.open(&dem);
        let control = Control::default();
        let ranges = find_ranges(&raster, &channels, &control).expect("ranges");
        let field = Field::open_extended(&raster, &FieldOptions::default(), &channels, &ranges, &control);
        let mesh = triangulate(&field.expect("a field"), params, &control).expect("a mesh");
        let sink = PlySink::new(StagedFile::create(&tin, false, &[&dem]).expect("staged"), Header::default());
        let summary = mesh.write(Box::new(sink), &control).expect("written");
        Made { _folder: folder, tin, raster, channels, summary }
    }

    fn judge(&self, max_error: f64) -> Verdict {
        self.judge_ground(max_error, None, 0)
    }

    fn judge_ground(&self, max_error: f64, max_stray: Option<f64>, trim: u32) -> Verdict {
        let options = VerifyOptions { lines: None, max_error, max_stray, importance: None, temp_dir: None };
        let ground = GroundOptions { trim, ..GroundOptions::default() };
        let judged =
            verify_ground(&self.raster, &self.tin, &options, ground, Some(&self.channels), &Control::default());
        judged.expect("judged")
    }
}

fn noise(seed: u64, i: usize) -> u64 {
    (i as u64 + 1).wrapping_mul(seed | 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40
}

fn swaps() -> impl Strategy<Value = Swap> {
    let by_data = |fit| Swap::DataDependent(DataDependent { fit, ..DataDependent::default() });
    prop_oneof![
        Just(Swap::Delaunay),
        prop::sample::select(vec![Fit::L2, Fit::LInfinity, Fit::MaxSum]).prop_map(by_data)
    ]
}

fn measures() -> impl Strategy<Value = Measure> {
    use Measure::{Curvature, GlobalError, LocalError, Product};
    prop_oneof![4 => Just(LocalError), 1 => prop_oneof![Just(GlobalError), Just(Curvature(1.0)), Just(Product(1.0))]]
}

proptest! {
    #![proptest_config(testing::cases(48, 1000))]

    #[test]
    fn what_is_written_passes_the_verifier(
        width in 2usize..22, height in 2usize..22, count in 1usize..5, seed in any::<u64>(), kind in 0u8..3,
        emphasis in prop_oneof![Just(0.0), Just(0.5), Just(1.0), 0.0f64..1.0], planar in any::<bool>(),
        max_error in prop_oneof![Just(0.0), Just(2.0), 0.0f64..60.0, Just(1e6)],
        tile in prop_oneof![Just(0usize), 3usize..12], swap in swaps(), measure in measures(), strong in any::<bool>(),
        quality in prop::sample::select(vec![Quality::None, Quality::Fast, Quality::Balanced, Quality::Best]),
        max_stray in prop_oneof![2 => Just(None), 1 => Just(Some(1.0))], gaps in 0u64..3, trim in 0u32..2,
    ) {
        let folder = testing::folder();
        let smooth = |i: usize, band: usize| {
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            110.0 + 60.0 * (x / 7.0 + band as f64).sin() + 40.0 * (y / 5.0 - band as f64).cos()
        };
        let value = |i: usize, band: usize| match kind {
            0 => (noise(seed, i + band * 1000) % 256) as f64,
            1 => smooth(i, band).round(),
            // A height is missing here and there, but for the first cell's; in an image so are its colours.
            _ if noise(seed, i) % 16 < gaps && i % width > 1 && i / width > 1 && (band == 0 || planar) => f64::NAN,
            _ => smooth(i, band) * 100.0,
        };
        let bands: Vec<Vec<f64>> = (0..=count).map(|b| (0..width * height).map(|i| value(i, b)).collect()).collect();
        let dem = folder.path().join("dem.tif");
        match kind {
            0 => geotiff::<u8>(&dem, (width, height), &bands),
            1 => geotiff::<i16>(&dem, (width, height), &bands),
            _ => geotiff::<f64>(&dem, (width, height), &bands),
        }
        let emphasis = if planar { 1.0 } else { emphasis };
        let channels = Choice { bands: (2..count + 2).collect(), emphasis, planar };
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        let options = InsertionOptions { swap, measure, ..InsertionOptions::default() };
        let engine = EngineChoice::GreedyInsertion(GreedyInsertion { options });
        let params = Params { tile, feasibility, engine, quality, max_stray, trim, ..Params::new(max_error) };
        let made = Made::new(folder, &channels, &params);
        let max_stray = params.limit_on_straying(FeatureSet::default().with(Feature::Attributes));
        let verdict = made.judge_ground(max_error, max_stray, trim);
        prop_assert!(verdict.passes(), "{:?}", verdict.failures());
        let (measured, judged) = (made.summary.errors.extended, verdict.extended.and_then(|w| w.worst));
        let (measured, judged) = (measured.expect("measured").max, judged.expect("judged").error);
        prop_assert!((measured - judged).abs() <= 1e-9 * (1.0 + judged), "{} against {}", measured, judged);
    }
}

/// Hills in one band, stripes of colour across them in three.
fn striped(folder: &tempfile::TempDir) {
    let (width, height) = (40, 30);
    let hills = |i: usize| (i % width / 8 * 20) as f64;
    let stripe = |i: usize, band: usize| if i / width % 10 < 5 { 40.0 * band as f64 } else { 200.0 };
    let mut bands = vec![(0..width * height).map(hills).collect::<Vec<f64>>()];
    bands.extend((1..4).map(|b| (0..width * height).map(|i| stripe(i, b)).collect()));
    geotiff::<u8>(&folder.path().join("dem.tif"), (width, height), &bands);
}

fn colours() -> Choice {
    Choice { bands: vec![2, 3, 4], emphasis: 0.5, planar: false }
}

#[test]
fn colours_are_written_as_bytes_and_come_back_as_the_samples() {
    let folder = testing::folder();
    striped(&folder);
    let made = Made::new(folder, &colours(), &delaunay(Params { tile: 16, ..Params::new(5.0) }));
    let mut mesh = PlyFile::open(&made.tin).expect("a mesh");
    let attributes: Vec<(String, ScalarType)> = mesh.attributes().map(|(n, t)| (n.to_string(), t)).collect();
    assert_eq!(attributes, ["red", "green", "blue"].map(|n| (n.to_string(), ScalarType::U8)));
    let mut different = std::collections::BTreeSet::new();
    mesh.for_each_vertex_with(&["blue", "red"], |_, [_, y, _], values| {
        let row = (-y - 0.5) as usize;
        assert_eq!(values, if row % 10 < 5 { [120.0, 40.0] } else { [200.0, 200.0] });
        different.insert(values[0] as u8);
        Ok::<(), crate::formats::ply::read::PlyError>(())
    })
    .expect("vertices");
    assert_eq!(different.len(), 2);
    assert!(made.judge(5.0).passes());
    // Edges of the stripes cost vertices that the heights alone do not need.
    assert!(made.summary.vertices > 100, "{}", made.summary.vertices);
}

#[test]
fn a_mesh_that_keeps_heights_alone_is_found_out() {
    let folder = testing::folder();
    striped(&folder);
    let heights_alone = Choice { emphasis: 0.0, ..colours() };
    let mut made = Made::new(folder, &heights_alone, &delaunay(Params { tile: 16, ..Params::new(5.0) }));
    assert!(made.judge(5.0).passes());
    made.channels = colours().open(made.raster.path());
    let verdict = made.judge(5.0);
    assert_eq!(verdict.failures().len(), 1, "{verdict}");
    assert!(verdict.failures()[0].contains("heights and attributes"), "{verdict}");
    let weighted = verdict.extended.expect("judged");
    assert!(weighted.above_tolerance.count > 100 && weighted.worst.expect("covered").error > 5.0);
}

#[test]
fn attributes_that_are_not_in_the_file_are_named() {
    let folder = testing::folder();
    striped(&folder);
    let made = Made::new(folder, &Choice { bands: vec![2], ..colours() }, &delaunay(Params::new(300.0)));
    let weighted = colours().open(made.raster.path());
    let options = VerifyOptions { lines: None, max_error: 300.0, max_stray: None, importance: None, temp_dir: None };
    let found = verify_with_channels(&made.raster, &made.tin, &options, &weighted, &Control::default());
    assert!(found.expect_err("no red").to_string().contains("attribute \"red\" of vertices"));
}

fn striped_field() -> (tempfile::TempDir, Field) {
    let folder = testing::folder();
    striped(&folder);
    let raster = testing::band(&folder.path().join("dem.tif"), 1);
    let colours = colours().open(raster.path());
    let ranges = find_ranges(&raster, &colours, &Control::default()).expect("ranges");
    let field = Field::open_extended(&raster, &FieldOptions::default(), &colours, &ranges, &Control::default());
    (folder, field.expect("a field"))
}

#[test]
fn what_does_not_keep_channels_is_not_given_any() {
    let (_folder, field) = striped_field();
    let cuts = Params { engine: EngineChoice::GreedyCuts(GreedyCuts::PLAIN), ..delaunay(Params::new(1.0)) };
    let run = triangulate(&field, &cuts, &Control::default());
    assert!(matches!(run, Err(Error::Incompatible(_))), "{run:?}");
    let fitted = Params { quality: Quality::Fast, heights: VertexHeights::Fitted, ..delaunay(Params::new(1.0)) };
    let run = triangulate(&field, &fitted, &Control::default());
    assert!(matches!(run, Err(Error::Incompatible(_))), "{run:?}");
}

#[test]
fn a_budget_is_kept_with_channels() {
    let (_folder, field) = striped_field();
    let goal = Goal { max_points: Some(400), ..Goal::default() };
    let params = delaunay(Params { goal, ..Params::new(f64::INFINITY) });
    let mesh = triangulate(&field, &params, &Control::default()).expect("a mesh");
    let search = mesh.outcome().and_then(|outcome| outcome.search).expect("a search");
    assert!(search.share.is_some_and(|share| share <= 1.0) && search.tolerance > 0.0, "{search:?}");
    let alone = Params { goal: Goal::default(), ..delaunay(Params::new(search.tolerance)) };
    let alone = triangulate(&field, &alone, &Control::default()).expect("a mesh").figures().expect("figures");
    assert_eq!(alone, mesh.figures().expect("figures"));
    assert_eq!(alone.vertices as f64 / 400.0, search.share.expect("a budget"));
}

#[test]
fn channels_are_reckoned_with() {
    use crate::job::plan::{DENSEST, estimate};
    let folder = testing::folder();
    striped(&folder);
    let raster = testing::band(&folder.path().join("dem.tif"), 1);
    let bands = colours().open(raster.path()).bands;
    let params = delaunay(Params::new(1.0));
    let grid = grid(40, 30, &params).expect("a grid");
    let load = Load::of(&raster, grid, &params);
    let plain = Plan::new(1 << 30, &load, 1).expect("a plan");
    let more = Plan::new(1 << 30, &Load { channels: &bands, ..load }, 1).expect("a plan");
    assert!(more.needed_bytes >= plain.needed_bytes + 3 * 24 * 40 * 30);
    let plain = estimate(&raster, None, DENSEST, FORMATS[0]);
    let (plain, more) = (plain, plain.with_channels(&bands, false, FORMATS[0]));
    assert_eq!(more.output_bytes - plain.output_bytes, 3 * 4 * 2 * 40 * 30);
    assert_eq!(more.spool_bytes - plain.spool_bytes, 3 * 4 * 2 * 40 * 30);
}
