//! The engines' reader and that of `verify` and `preview` see the same samples, bit for bit, of every kind of raster.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use gdal::DriverManager;
use gdal::raster::{Buffer, GdalType};
use proptest::prelude::*;

use super::{Params, triangulate};
use crate::base::Tile;
use crate::base::Window;
use crate::base::control::Control;
use crate::base::staged::StagedFile;
use crate::base::{Band, Mark, SampleType};
use crate::field::{Choice, Field, FieldOptions};
use crate::formats::{Header, PlySink};
use crate::raster::View;
use crate::testing;
use crate::verify::{HeightReader, VerifyOptions, verify};

const SIZE: (usize, usize) = (13, 11);
const ALL: Window = Window { column: 0, row: 0, width: SIZE.0, height: SIZE.1 };

const TYPES: [&str; 9] = ["Byte", "UInt16", "Int16", "UInt32", "Int32", "UInt64", "Int64", "Float32", "Float64"];

/// What is opened, over a GeoTIFF.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    GeoTiff,
    Vrt,
    ScaledVrt,
    WarpedVrt,
    VrtOfType(&'static str),
}

#[derive(Debug, Clone)]
struct Case {
    kind: &'static str,
    form: Form,
    nodata: Option<f64>,
    scaling: Option<(f64, f64)>,
    samples: Vec<f64>,
}

fn case() -> impl Strategy<Value = Case> {
    let form = prop_oneof![
        Just(Form::GeoTiff),
        Just(Form::Vrt),
        Just(Form::ScaledVrt),
        Just(Form::WarpedVrt),
        proptest::sample::select(&TYPES[..]).prop_map(Form::VrtOfType),
    ];
    let mark = prop_oneof![
        Just(None),
        proptest::sample::select(vec![0.0, 7.0, 200.0, -9999.0, -9999.9, -9999.5, -3.4e38, 1.70141e38, 0.1])
            .prop_map(Some),
    ];
    let scaling = prop_oneof![Just(None), Just(Some((0.3048, 0.0))), Just(Some((-0.5, 100.25)))];
    let sample = prop_oneof![
        4 => (0i32..250).prop_map(f64::from),
        2 => -300.0f64..300.0,
        1 => Just(0.1),
        1 => Just(f64::INFINITY),
    ];
    let samples = proptest::collection::vec(sample, SIZE.0 * SIZE.1);
    (proptest::sample::select(&TYPES[..]), form, mark, scaling, samples).prop_map(
        |(kind, form, nodata, scaling, mut samples)| {
            // An infinity stands for the mark, or for what is near it.
            let stand_in = |i: usize| match nodata {
                None => 100.0,
                Some(mark) if i.is_multiple_of(3) => mark * (1.0 + 1e-9),
                Some(mark) => mark,
            };
            samples.iter_mut().enumerate().filter(|(_, s)| s.is_infinite()).for_each(|(i, s)| *s = stand_in(i));
            Case { kind, form, nodata, scaling, samples }
        },
    )
}

fn write<T: GdalType + Copy>(path: &Path, case: &Case) {
    let driver = DriverManager::get_driver_by_name("GTiff").expect("the driver");
    let mut dataset = driver.create_with_band_type::<T, _>(path, SIZE.0, SIZE.1, 1).expect("a raster");
    dataset.set_geo_transform(&[100.0, 2.0, 0.0, 50.0, 0.0, -2.0]).expect("placed");
    let mut band = dataset.rasterband(1).expect("a band");
    match (case.nodata, case.kind) {
        (Some(mark), "Int64") => band.set_no_data_value_i64(Some(mark as i64)).expect("tagged"),
        (Some(mark), "UInt64") => band.set_no_data_value_u64(Some(mark as u64)).expect("tagged"),
        (mark, _) => band.set_no_data_value(mark).expect("tagged"),
    }
    if let Some((scale, offset)) = case.scaling {
        band.set_scale(scale).and_then(|()| band.set_offset(offset)).expect("scaled");
    }
    band.write((0, 0), SIZE, &mut Buffer::new(SIZE, case.samples.clone())).expect("written");
    dataset.close().expect("closed");
}

/// A VRT over `base.tif`, in the words of GDAL's documentation of the format.
fn vrt(case: &Case) -> String {
    let mark = case.nodata.map(|mark| format!("<NoDataValue>{mark:?}</NoDataValue>")).unwrap_or_default();
    let scaling = case.scaling.map(|(s, o)| format!("<Scale>{s:?}</Scale><Offset>{o:?}</Offset>")).unwrap_or_default();
    let source = r#"<SourceFilename relativeToVRT="1">base.tif</SourceFilename><SourceBand>1</SourceBand>"#;
    let (kind, inside) = match case.form {
        Form::ScaledVrt => {
            let ratio = "<ScaleOffset>3.25</ScaleOffset><ScaleRatio>0.3048</ScaleRatio>";
            (case.kind, format!("{mark}<ComplexSource>{source}{ratio}</ComplexSource>"))
        }
        Form::VrtOfType(kind) => (kind, format!("{mark}{scaling}<SimpleSource>{source}</SimpleSource>")),
        _ => (case.kind, format!("{mark}{scaling}<SimpleSource>{source}</SimpleSource>")),
    };
    let (width, height) = SIZE;
    format!(
        r#"<VRTDataset rasterXSize="{width}" rasterYSize="{height}"><GeoTransform>100, 2, 0, 50, 0, -2</GeoTransform>
        <VRTRasterBand dataType="{kind}" band="1">{inside}</VRTRasterBand></VRTDataset>"#
    )
}

/// A warped VRT that moves the raster by a third of a cell and interpolates.
fn warped_vrt(case: &Case) -> String {
    let (width, height) = SIZE;
    let transform = |name: &str, x: f64| {
        let numbers = format!("{x:?},2,0,50,0,-2");
        let inverse = format!("{:?},0.5,0,25,0,-0.5", -x / 2.0);
        format!(
            "<{name}GeoTransform>{numbers}</{name}GeoTransform><{name}InvGeoTransform>{inverse}</{name}InvGeoTransform>"
        )
    };
    let transforms = transform("Src", 100.0) + &transform("Dst", 100.75);
    let mut mapping = String::new();
    let mut tag = String::new();
    if let Some(mark) = case.nodata {
        for side in ["Src", "Dst"] {
            let _ =
                write!(mapping, "<{side}NoDataReal>{mark:?}</{side}NoDataReal><{side}NoDataImag>0</{side}NoDataImag>");
        }
        tag = format!("<NoDataValue>{mark:?}</NoDataValue>");
    }
    let kind = case.kind;
    format!(
        r#"<VRTDataset rasterXSize="{width}" rasterYSize="{height}" subClass="VRTWarpedDataset">
        <GeoTransform>100.75, 2, 0, 50, 0, -2</GeoTransform>
        <VRTRasterBand dataType="{kind}" band="1" subClass="VRTWarpedRasterBand">{tag}</VRTRasterBand>
        <BlockXSize>{width}</BlockXSize><BlockYSize>{height}</BlockYSize>
        <GDALWarpOptions><WarpMemoryLimit>6.7e+07</WarpMemoryLimit><ResampleAlg>Bilinear</ResampleAlg>
        <WorkingDataType>{kind}</WorkingDataType><Option name="INIT_DEST">NO_DATA</Option>
        <SourceDataset relativeToVRT="1">base.tif</SourceDataset>
        <Transformer><GenImgProjTransformer>{transforms}</GenImgProjTransformer></Transformer>
        <BandList><BandMapping src="1" dst="1">{mapping}</BandMapping></BandList></GDALWarpOptions></VRTDataset>"#
    )
}

/// Writes the rasters of a case, and gives the path of the one that is opened.
fn make(folder: &Path, case: &Case) -> PathBuf {
    let base = folder.join("base.tif");
    match case.kind {
        "Byte" => write::<u8>(&base, case),
        "UInt16" => write::<u16>(&base, case),
        "Int16" => write::<i16>(&base, case),
        "UInt32" => write::<u32>(&base, case),
        "Int32" => write::<i32>(&base, case),
        "UInt64" => write::<u64>(&base, case),
        "Int64" => write::<i64>(&base, case),
        "Float32" => write::<f32>(&base, case),
        _ => write::<f64>(&base, case),
    }
    if case.form == Form::GeoTiff {
        return base;
    }
    let path = folder.join("view.vrt");
    let text = if case.form == Form::WarpedVrt { warped_vrt(case) } else { vrt(case) };
    std::fs::write(&path, text).expect("written");
    path
}

/// What the engines see: heights as bits, `None` where there is none.
fn seen_by_engines(band: &Band, choice: Choice) -> Option<Vec<Option<u64>>> {
    let options = FieldOptions { choice, ..FieldOptions::default() };
    let field = Field::open(band, &options, &Control::default()).expect("a field");
    let mut tile = Tile::default();
    field.load(ALL, &mut tile).ok()?;
    let at = |i: usize| (i % SIZE.0, i / SIZE.0);
    let seen = (0..ALL.len())
        .map(at)
        .map(|(c, r)| tile.validity().is_valid(c as i32, r as i32).then(|| tile.at(c, r).to_bits()));
    Some(seen.collect())
}

fn seen_by_verify(band: &Band) -> Vec<Option<u64>> {
    let mut heights = vec![0.0; ALL.len()];
    HeightReader::new(band).read(ALL, &mut heights).expect("read");
    heights.into_iter().map(|h| Some(h).filter(|h| !h.is_nan()).map(f64::to_bits)).collect()
}

proptest! {
    #![proptest_config(testing::cases(150, 3000))]

    #[test]
    fn both_readers_see_the_same_samples(case in case()) {
        let folder = tempfile::tempdir().expect("a folder");
        let raster = testing::band(&make(folder.path(), &case), 1);
        let expected = seen_by_verify(&raster);
        let in_place = raster.plain_layout().is_ok().then_some(Choice::InPlace);
        prop_assert_eq!(in_place.is_some(), case.form == Form::GeoTiff);
        for choice in [Choice::Windows, Choice::Decode].into_iter().chain(in_place) {
            // A 64-bit integer beyond 2^53, or what is beyond 10^30, is refused.
            let Some(found) = seen_by_engines(&raster, choice) else { continue };
            prop_assert_eq!(&found, &expected, "{:?}", choice);
        }
        if seen_by_engines(&raster, Choice::Windows).is_none() || expected.iter().all(Option::is_none) {
            return Ok(());
        }
        prop_assert!(largest_errors_agree(&raster, folder.path(), None, 20.0));
    }
}

/// Whether `simplify` and `verify` pass and report the same largest error, to the last bit; if there is ground at all.
fn largest_errors_agree(band: &Band, folder: &Path, importance: Option<&Band>, tolerance: f64) -> bool {
    let (control, output) = (Control::default(), folder.join("tin.ply"));
    let field = Field::open_with_importance(band, importance, &FieldOptions::default(), &control).expect("a field");
    let params = Params { tile: 7, ..Params::new(tolerance) };
    let mesh = match triangulate(&field, &params, &control) {
        Err(super::Error::NoGround { .. }) => return true,
        mesh => mesh.expect("a mesh"),
    };
    let staged = StagedFile::create(&output, true, &[]).expect("staged");
    let summary = mesh.write(Box::new(PlySink::new(staged, Header::default())), &control).expect("written");
    let options = VerifyOptions {
        lines: None,
        max_error: tolerance,
        max_stray: params.limit_on_straying(params.features()),
        importance,
        temp_dir: None,
    };
    let verdict = verify(band, &output, &options, &control).expect("judged");
    assert!(verdict.passes(), "{verdict}");
    let worst = verdict.worst.map_or(0.0, |w| w.error);
    let weighted = verdict.weighted_worst.map_or(worst, |w| w.weighted_error);
    assert_eq!((summary.errors.max, summary.errors.weighted_max), (worst, weighted));
    true
}

fn nothing_marked() -> Case {
    let samples = (0..ALL.len()).map(|i| 20.0 + 3.0 * ((i * 7919) % 31) as f64).collect();
    Case { kind: "Int16", form: Form::ScaledVrt, nodata: None, scaling: None, samples }
}

/// A VRT of Int16 that scales gave 3 to one reader and 2.745 to the other.
#[test]
fn a_scaled_vrt_is_read_in_its_own_type() {
    let folder = tempfile::tempdir().expect("a folder");
    let raster = testing::band(&make(folder.path(), &nothing_marked()), 1);
    let seen = seen_by_verify(&raster);
    assert_eq!(seen_by_engines(&raster, Choice::Windows).as_ref(), Some(&seen));
    assert!(seen.iter().flatten().all(|bits| f64::from_bits(*bits).fract() == 0.0));
    assert!(largest_errors_agree(&raster, folder.path(), None, 0.5));
}

#[test]
fn importance_of_a_scaled_vrt_weighs_the_same_for_both() {
    let (folder, heights) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("another"));
    let weights = testing::band(&make(folder.path(), &nothing_marked()), 1);
    let case = Case { form: Form::GeoTiff, kind: "Float64", ..nothing_marked() };
    let raster = testing::band(&make(heights.path(), &case), 1);
    assert!(largest_errors_agree(&raster, heights.path(), Some(&weights), 300.0));
}

/// A mark that a VRT has with fewer digits than the samples.
#[test]
fn voids_of_a_vrt_are_missing_for_both() {
    let mut case = Case { form: Form::Vrt, kind: "Float32", nodata: Some(-9999.9), ..nothing_marked() };
    case.samples[40..44].fill(-9999.9);
    let folder = tempfile::tempdir().expect("a folder");
    let raster = testing::band(&make(folder.path(), &case), 1);
    assert_eq!(raster.tag(), Some(Mark::Real(-9999.9)));
    assert_eq!(seen_by_verify(&raster).iter().filter(|s| s.is_none()).count(), 4);
    assert!(largest_errors_agree(&raster, folder.path(), None, 2.0));
}

/// Marks as they are written, with fewer digits than the samples have: the rule of `Mark`, sample by sample.
#[test]
fn marks_that_were_rounded_when_written() {
    let missing = |kind: &'static str, mark: f64, sample: f64| {
        let mut case = Case { form: Form::GeoTiff, kind, nodata: Some(mark), ..nothing_marked() };
        case.samples[40] = sample;
        let folder = tempfile::tempdir().expect("a folder");
        let raster = testing::band(&make(folder.path(), &case), 1);
        let seen = seen_by_verify(&raster);
        if let Some(engines) = seen_by_engines(&raster, Choice::Auto) {
            assert_eq!(seen, engines, "{kind} {mark} {sample}");
        }
        seen[40].is_none()
    };
    let lowest = f64::from(f32::MIN);
    assert!(missing("Float64", 1.797_693_13e308, f64::MAX));
    assert!(missing("Float64", -1.797_693_13e308, f64::MIN));
    assert!(missing("Float32", -3.4e38, lowest));
    assert!(missing("Float32", -3.40282e38, lowest));
    assert!(missing("Float32", 1.70141e38, 1.70141e38));
    assert!(missing("Float64", 1.70141e38, f64::from(1.70141e38_f32)));
    assert!(missing("Float32", -9999.0, -9999.002));
    assert!(!missing("Float32", -9999.0, -9999.01));
    assert!(missing("Int16", -9999.5, -9999.0));
    assert!(!missing("Int16", -9999.5, -10000.0));
    assert!(!missing("UInt16", -1.0, 65535.0));
    // GDAL does not mask it either: in double precision they are far apart.
    assert!(!missing("Float64", -3.40282e38, lowest));
}

#[test]
fn marks_of_the_caller_count_for_both() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut case = Case { form: Form::GeoTiff, kind: "Float32", nodata: Some(-9999.0), ..nothing_marked() };
    for (sample, value) in case.samples.iter_mut().zip([-9999.0, f64::NEG_INFINITY, -1e4, 9000.0, 9000.5]) {
        *sample = value;
    }
    let path = make(folder.path(), &case);
    let seen = |nodata: &[&str], valid_range| {
        let nodata = nodata.iter().map(|text| text.to_string()).collect();
        let view = View { nodata, valid_range, ..View::default() };
        let raster = view.open(&path, &Control::default().cancel).expect("opened").to_band().expect("told");
        let seen = seen_by_verify(&raster);
        if let Some(engines) = seen_by_engines(&raster, Choice::Auto) {
            assert_eq!(engines, seen);
        }
        std::array::from_fn::<bool, 5, _>(|i| seen[i].is_some())
    };
    let range = |min, max| Some(crate::base::ValidRange { min, max });
    assert_eq!(seen(&[], None), [false, true, true, true, true]);
    assert_eq!(seen(&["tag", "-inf"], None), [false, false, true, true, true]);
    assert_eq!(seen(&["-inf", "-1e4"], None), [true, false, false, true, true]);
    assert_eq!(seen(&["none"], None), [true; 5]);
    assert_eq!(seen(&[], range(-500.0, 9000.0)), [false, false, false, true, false]);
    assert_eq!(seen(&["none"], range(-9999.0, 9000.0)), [true, false, false, true, false]);
}

#[test]
fn half_floats_have_the_rules_of_singles() {
    use crate::base::{Marks, Scaling};
    assert_eq!((SampleType::F16.name(), SampleType::F16.bytes(), SampleType::F16.fits_f32()), ("Float16", 2, true));
    assert_eq!(Mark::parse("-9999", SampleType::F16), Some(Mark::Real(-9999.0)));
    assert_eq!(Mark::parse("1e6", SampleType::F16), None);
    let marks = Marks { values: vec![Mark::Real(-9999.0)], valid: None };
    let missing = crate::base::stored::missing_halves(&marks, Scaling::NONE, &[-10000.0, -9992.0, f32::NAN, 1.5]);
    // No half float is -9999: it is rounded to -10000.
    assert_eq!(missing, [true, false, true, false]);
}
