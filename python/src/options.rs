//! Options: the command's, by its names with underscores.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use terrabite::base::features::{Feature, FeatureSet};
use terrabite::base::{Band, LineKind, LineType, Polylines};
use terrabite::field::Choice;
use terrabite::job::normals::Normals;
use terrabite::job::rules::{self, default_engine, default_quality};
use terrabite::job::{EngineChoice, Goal, Params, Quality, VertexHeights};
use terrabite::kernel::triangulate::Feasibility;
use terrabite::kernel::triangulate::cuts::GreedyCuts;
use terrabite::kernel::triangulate::hitting_set::{Corners, HittingSet, HittingSetOptions, Squares, Stitching};
use terrabite::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Selection, Shape, Swap,
};
use terrabite::run::{
    AttributeBands, Attributes, HeightSource, Input, LakeHeight, LineInput, LineTypes, Lines, PointInput, Request,
    VerifyRequest,
};

use crate::band::PyBand;
use crate::errors::exception;
use crate::polishing::Polishing;

/// The lines of a call that makes a mesh, or of one that judges it.
macro_rules! asked_lines {
    ($options:expr) => {
        AskedLines {
            breaklines: $options.breaklines.as_ref(),
            footprints: $options.footprints.as_ref(),
            cutline: $options.cutline_exact.as_ref(),
            lakes: $options.lake_polygons.as_ref(),
            lake_z: &$options.lake_z,
            shift: $options.breakline_shift,
            z: &$options.breakline_z,
        }
    };
}

/// What decides a mesh, as the words of a call.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Options<'py> {
    max_error: Option<f64>,
    max_rms: Option<f64>,
    max_points: Option<u64>,
    max_triangles: Option<u64>,
    quality: Option<String>,
    heights: String,
    feasibility: String,
    min_angle: Option<f64>,
    max_stray: Option<f64>,
    tile: usize,
    trim: u32,
    fill_holes: u64,
    importance: Option<Bound<'py, PyBand>>,
    attributes: Option<Vec<Bound<'py, PyBand>>>,
    attribute_weight: Option<f64>,
    image: bool,
    points: Option<Vec<(f64, f64)>>,
    breaklines: Option<Vertices>,
    footprints: Option<Vec<Vertices>>,
    cutline_exact: Option<Vec<Vertices>>,
    lake_polygons: Option<Vec<Vertices>>,
    lake_z: LakeZ,
    breakline_shift: f64,
    breakline_z: String,
    breakline_type: LineTypeOf,
    engine: Option<String>,
    cuts: Option<String>,
    swap: Option<String>,
    quality_threshold: Option<f64>,
    shape: Option<String>,
    fit: Option<String>,
    selection: Option<String>,
    fraction: Option<f64>,
    measure: Option<String>,
    smoothing: Option<f64>,
    squares: Option<String>,
    corners: Option<String>,
    stitching: Option<String>,
    access: String,
    memory: Option<u64>,
    threads: Option<usize>,
    temp_dir: Option<PathBuf>,
    normals: Option<String>,
    work_dir: Option<PathBuf>,
    keep_work_dir: bool,
    polishing: Polishing,
}

/// What a mesh is judged by, as the words of a call.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct VerifyOptions<'py> {
    max_error: f64,
    max_stray: Option<f64>,
    fill_holes: u64,
    trim: u32,
    importance: Option<Bound<'py, PyBand>>,
    attributes: Option<Vec<Bound<'py, PyBand>>>,
    attribute_weight: Option<f64>,
    image: bool,
    breaklines: Option<Vertices>,
    footprints: Option<Vec<Vertices>>,
    cutline_exact: Option<Vec<Vertices>>,
    lake_polygons: Option<Vec<Vertices>>,
    lake_z: LakeZ,
    breakline_shift: f64,
    breakline_z: String,
    threads: Option<usize>,
    temp_dir: Option<PathBuf>,
}

/// One of some words, or an error that lists them.
fn choose<T: Copy>(name: &str, word: &str, choices: &[(&str, T)]) -> PyResult<T> {
    choices.iter().find(|(choice, _)| *choice == word).map(|(_, value)| *value).ok_or_else(|| {
        let known: Vec<String> = choices.iter().map(|(choice, _)| format!("{choice:?}")).collect();
        PyValueError::new_err(format!("{name}: expected one of {}, found {word:?}", known.join(", ")))
    })
}

/// The same where a word may be left out.
pub(crate) fn chosen<T: Copy>(name: &str, word: Option<&String>, choices: &[(&str, T)]) -> PyResult<Option<T>> {
    word.map(|word| choose(name, word, choices)).transpose()
}

/// A number in a range, or an error that says which.
pub(crate) fn within(name: &str, number: Option<f64>, fits: impl Fn(f64) -> bool, expected: &str) -> PyResult<()> {
    match number.filter(|number| !fits(*number)) {
        None => Ok(()),
        Some(found) => Err(PyValueError::new_err(format!("{name}: expected {expected}, found {found}"))),
    }
}

fn threads(number: Option<usize>) -> PyResult<Option<NonZeroUsize>> {
    let of = |number| NonZeroUsize::new(number).ok_or_else(|| PyValueError::new_err("threads: expected 1 or more"));
    number.map(of).transpose()
}

fn bands(bands: &[Bound<'_, PyBand>]) -> Vec<Band> {
    bands.iter().map(|band| band.get().band.clone()).collect()
}

fn attributes(
    named: Option<&Vec<Bound<'_, PyBand>>>,
    weight: Option<f64>,
    image: bool,
) -> PyResult<Option<Attributes>> {
    within("attribute_weight", weight, |weight| (0.0..=1.0).contains(&weight), "a number from 0 to 1")?;
    Ok(named.map(|named| {
        let (bands, weight) = (AttributeBands::Bands(bands(named)), weight.unwrap_or(0.5));
        Attributes { bands, weight, image }
    }))
}

impl Options<'_> {
    /// The run that is asked for, of this band.
    pub(crate) fn request(&self, band: &Band) -> PyResult<Request<'static>> {
        self.check_numbers()?;
        let tolerance = self.max_error.unwrap_or(f64::INFINITY);
        let request = Request::new(band.clone(), PathBuf::new(), tolerance);
        let heights = choose(
            "heights",
            &self.heights,
            &[("sampled", VertexHeights::Sampled), ("fitted", VertexHeights::Fitted)],
        )?;
        let feasibility =
            choose("feasibility", &self.feasibility, &[("weak", Feasibility::Weak), ("strong", Feasibility::Strong)])?;
        let asked = self.asked(heights, feasibility);
        let qualities = [Quality::None, Quality::Fast, Quality::Balanced, Quality::Best].map(|q| (q.name(), q));
        let quality = chosen("quality", self.quality.as_ref(), &qualities)?;
        let quality = quality.unwrap_or_else(|| default_quality(asked));
        let asked = if quality == Quality::None { asked } else { asked.with(Feature::Polishing) };
        let engine = self.engine(asked)?;
        rules::check(asked.and(engine.features())).map_err(|conflicts| exception(&conflicts.into()))?;
        let mut params = Params {
            goal: Goal { max_points: self.max_points, max_triangles: self.max_triangles, max_rms: self.max_rms },
            tuning: self.polishing.tuning(quality, heights, self.min_angle)?,
            max_stray: self.max_stray,
            tile: self.tile,
            trim: self.trim,
            heights,
            feasibility,
            quality,
            engine,
            ..request.params.clone()
        };
        if let Some(dir) = &self.temp_dir {
            params.temp_dir.clone_from(dir);
        }
        let types = line_types(&self.breakline_type, self.breaklines.as_ref().map(Vec::len))?;
        Ok(Request {
            params,
            attributes: attributes(self.attributes.as_ref(), self.attribute_weight, self.image)?,
            importance: self.importance.as_ref().map(|band| Input::Band(band.get().band.clone())),
            points: self.points.as_ref().map(|places| PointInput::Places(places.as_slice().into())),
            lines: lines(&asked_lines!(self))?.into_iter().map(|input| input.of_types(&types)).collect(),
            fill_voids: self.fill_holes,
            access: choose(
                "access",
                &self.access,
                &[("auto", Choice::Auto), ("windows", Choice::Windows), ("decode", Choice::Decode)],
            )?,
            memory: self.memory,
            threads: threads(self.threads)?,
            normals: chosen(
                "normals",
                self.normals.as_ref(),
                &[("gradient", Normals::Gradient), ("area", Normals::Area)],
            )?,
            work_dir: self.work_dir.clone(),
            keep_work_dir: self.keep_work_dir,
            ..request
        })
    }

    fn check_numbers(&self) -> PyResult<()> {
        let usable = |error: f64| error.is_finite() && error >= 0.0;
        within("max_error", self.max_error, usable, "a finite number, 0 or above, in the units of the heights")?;
        within("max_rms", self.max_rms, usable, "a finite number, 0 or above, in the units of the heights")?;
        let is_share = |share: f64| (0.0..=1.0).contains(&share);
        within("quality_threshold", self.quality_threshold, is_share, "a number from 0 to 1")?;
        within("fraction", self.fraction, is_share, "a number from 0 to 1")?;
        within("smoothing", self.smoothing, |s| s > 0.0 && s <= 64.0, "a number of cells above 0, at most 64")?;
        within("max_stray", self.max_stray, |limit| limit >= 1.0, "1 or more, or inf for no limit")?;
        within("min_angle", self.min_angle, |angle| (0.0..=60.0).contains(&angle), "degrees from 0 to 60")?;
        let goals = [self.max_error.is_some(), self.max_rms.is_some(), self.max_points.is_some()];
        if goals.contains(&true) || self.max_triangles.is_some() {
            return Ok(());
        }
        let message = "expected max_error, or one of max_triangles, max_points and max_rms in its place";
        Err(pyo3::exceptions::PyTypeError::new_err(message))
    }

    /// What is asked for, apart from polishing and the engine.
    fn asked(&self, heights: VertexHeights, feasibility: Feasibility) -> FeatureSet {
        let swap = |word: &str| self.swap.as_deref() == Some(word);
        let selection = |word: &str| self.selection.as_deref() == Some(word);
        let measure = |word: &str| self.measure.as_deref() == Some(word);
        let wanted = [
            (Feature::VertexBudget, self.max_points.is_some()),
            (Feature::TriangleBudget, self.max_triangles.is_some()),
            (Feature::RmsGoal, self.max_rms.is_some()),
            (Feature::Image, self.image),
            (Feature::Attributes, self.attributes.is_some() && !self.image),
            (Feature::AttributeWeight, self.attribute_weight.is_some()),
            (Feature::Importance, self.importance.is_some()),
            (Feature::Points, self.points.is_some()),
            (Feature::Breaklines, self.breaklines.is_some()),
            (Feature::Footprints, self.footprints.is_some()),
            (Feature::ExactCutline, self.cutline_exact.is_some()),
            (Feature::Cutline, self.cutline_exact.is_some()),
            (Feature::LineHeights, self.breakline_z == HeightSource::Own.name()),
            (Feature::Lakes, self.lake_polygons.is_some()),
            (Feature::Trim, self.trim > 0),
            (Feature::FilledVoids, self.fill_holes > 0),
            (Feature::FittedHeights, heights == VertexHeights::Fitted),
            (Feature::MinAngle, self.min_angle.is_some_and(|floor| floor > 0.0)),
            (Feature::MaxStray, self.max_stray.is_some_and(f64::is_finite)),
            (Feature::StrongFeasibility, feasibility == Feasibility::Strong),
            (Feature::CutOrder, self.cuts.is_some()),
            (Feature::Squares, self.squares.is_some()),
            (Feature::SampledCorners, self.corners.as_deref() == Some("samples")),
            (Feature::FreeCorners, self.corners.as_deref() == Some("free")),
            (Feature::Stitching, self.stitching.is_some()),
            (Feature::DelaunaySwap, swap("delaunay")),
            (Feature::DataDependentSwap, swap("data-dependent")),
            (Feature::QualityThreshold, self.quality_threshold.is_some()),
            (Feature::Shape, self.shape.is_some()),
            (Feature::Fit, self.fit.is_some()),
            (Feature::SequentialSelection, selection("sequential")),
            (Feature::FractionalSelection, selection("fractional")),
            (Feature::ConstantSelection, selection("constant")),
            (Feature::Fraction, self.fraction.is_some()),
            (Feature::LocalErrorMeasure, measure("local-error")),
            (Feature::GlobalErrorMeasure, measure("global-error")),
            (Feature::SmoothedMeasure, measure("curvature") || measure("product")),
            (Feature::Smoothing, self.smoothing.is_some()),
        ];
        let wanted = wanted.into_iter().chain(self.polishing.wanted());
        wanted.filter(|(_, is_wanted)| *is_wanted).map(|(feature, _)| feature).collect()
    }

    fn engine(&self, asked: FeatureSet) -> PyResult<EngineChoice> {
        let (cuts, insertion, hitting_set) = (self.cuts()?, self.insertion()?, self.hitting_set()?);
        let engines: [EngineChoice; 3] = [cuts.into(), insertion.into(), hitting_set.into()];
        let named = engines.map(|engine| (engine.name(), engine));
        let usual = default_engine(asked).name();
        let usual = engines.into_iter().find(|engine| engine.name() == usual).expect("one of them");
        Ok(chosen("engine", self.engine.as_ref(), &named)?.unwrap_or(usual))
    }

    fn hitting_set(&self) -> PyResult<HittingSet> {
        let usual = HittingSetOptions::default();
        let squares = [("nested", Squares::Nested), ("sliding", Squares::Sliding)];
        let corners = [("samples", Corners::Samples), ("free", Corners::Free)];
        let stitchings = [("shared", Stitching::Shared), ("merged", Stitching::Merged)];
        Ok(HittingSet {
            options: HittingSetOptions {
                squares: chosen("squares", self.squares.as_ref(), &squares)?.unwrap_or(usual.squares),
                corners: chosen("corners", self.corners.as_ref(), &corners)?.unwrap_or(usual.corners),
                stitching: chosen("stitching", self.stitching.as_ref(), &stitchings)?.unwrap_or(usual.stitching),
            },
        })
    }

    fn cuts(&self) -> PyResult<GreedyCuts> {
        let known = [("plain", GreedyCuts::PLAIN), ("improved", GreedyCuts::IMPROVED)];
        Ok(chosen("cuts", self.cuts.as_ref(), &known)?.unwrap_or(GreedyCuts::PLAIN))
    }

    fn insertion(&self) -> PyResult<GreedyInsertion> {
        let usual = DataDependent::default();
        let fits = [("max-sum", Fit::MaxSum), ("l2", Fit::L2), ("l-infinity", Fit::LInfinity)];
        let shapes = [("area-over-diameter", Shape::AreaOverDiameter), ("smallest-angle", Shape::SmallestAngle)];
        let by_data = DataDependent {
            fit: chosen("fit", self.fit.as_ref(), &fits)?.unwrap_or(usual.fit),
            shape: chosen("shape", self.shape.as_ref(), &shapes)?.unwrap_or(usual.shape),
            quality_threshold: self.quality_threshold.unwrap_or(usual.quality_threshold),
        };
        let swaps = [("delaunay", Swap::Delaunay), ("data-dependent", Swap::DataDependent(by_data))];
        let selections = [
            ("sequential", Selection::Sequential),
            ("fractional", Selection::Fractional(self.fraction.unwrap_or(0.9))),
            ("constant", Selection::Constant),
        ];
        let smoothing = self.smoothing.unwrap_or(1.0);
        let measures = [
            ("local-error", Measure::LocalError),
            ("curvature", Measure::Curvature(smoothing)),
            ("global-error", Measure::GlobalError),
            ("product", Measure::Product(smoothing)),
        ];
        Ok(GreedyInsertion {
            options: InsertionOptions {
                swap: chosen("swap", self.swap.as_ref(), &swaps)?.unwrap_or(Swap::Delaunay),
                selection: chosen("selection", self.selection.as_ref(), &selections)?.unwrap_or(Selection::Sequential),
                measure: chosen("measure", self.measure.as_ref(), &measures)?.unwrap_or(Measure::LocalError),
            },
        })
    }
}

/// Vertices of lines, of two or three numbers each.
type Vertices = Vec<Vec<Vec<f64>>>;

/// Heights of lakes: a word, or one for each.
#[derive(FromPyObject)]
enum LakeZ {
    Word(String),
    Each(Vec<f64>),
}

/// Types of lines: one word for all, or one for each.
#[derive(FromPyObject)]
enum LineTypeOf {
    All(String),
    Each(Vec<String>),
}

/// Of what type the lines of a call are, where there are so many.
fn line_types(types: &LineTypeOf, breaklines: Option<usize>) -> PyResult<LineTypes> {
    let line_type = |word: &String| {
        choose("breakline_type", word, &[LineType::Hard, LineType::Soft].map(|line_type| (line_type.name(), line_type)))
    };
    let found = match types {
        LineTypeOf::All(word) => LineTypes::All(line_type(word)?),
        LineTypeOf::Each(words) => {
            if let Some(lines) = breaklines.filter(|lines| *lines != words.len()) {
                let message = format!("breakline_type: expected {lines} types, found {}", words.len());
                return Err(PyValueError::new_err(message));
            }
            LineTypes::Each(words.iter().map(line_type).collect::<PyResult<_>>()?)
        }
    };
    if breaklines.is_none() && found != LineTypes::default() {
        return Err(PyValueError::new_err("breakline_type: expected breaklines, whose type it is, found none"));
    }
    Ok(found)
}

/// The lines that a call names.
struct AskedLines<'a> {
    breaklines: Option<&'a Vertices>,
    footprints: Option<&'a Vec<Vertices>>,
    /// That the mesh ends at.
    cutline: Option<&'a Vec<Vertices>>,
    lakes: Option<&'a Vec<Vertices>>,
    lake_z: &'a LakeZ,
    shift: f64,
    z: &'a str,
}

/// Lines through places on the map, and the outlines of polygons, as far as there are any.
fn lines(asked: &AskedLines<'_>) -> PyResult<Vec<LineInput>> {
    let &AskedLines { breaklines, footprints, cutline, lakes, lake_z, shift, z } = asked;
    let is_own = choose("breakline_z", z, &[("raster", false), ("line", true)])?;
    if breaklines.is_none() && is_own {
        return Err(PyValueError::new_err("breakline_z: expected breaklines, whose heights these are, found none"));
    }
    let input = |kind, lines, shift, heights| LineInput {
        kind,
        from: Lines::Places(lines),
        shift,
        heights,
        types: LineTypes::default(),
    };
    let breaklines = breaklines.map(|lines| {
        let heights = if is_own { HeightSource::Own } else { HeightSource::Raster };
        Ok::<_, PyErr>(input(LineKind::Breaklines, polylines(lines)?, shift, heights))
    });
    let outlines = |polygons: &Vec<Vertices>| {
        let rings: Vertices = polygons.iter().flatten().cloned().collect();
        let of = polygons.iter().zip(0u64..).flat_map(|(rings, number)| rings.iter().map(move |_| number));
        Ok::<_, PyErr>(polylines(&rings)?.without_heights().of_features(of.collect()))
    };
    let lakes = lakes.map(|polygons| {
        let height = match lake_z {
            LakeZ::Word(word) => choose("lake_z", word, &[("min", true), ("median", false)])
                .map(|is_min| if is_min { LakeHeight::Min } else { LakeHeight::Median })?,
            LakeZ::Each(heights) if heights.len() == polygons.len() => LakeHeight::Each(heights.clone()),
            LakeZ::Each(heights) => {
                let message = format!("lake_z: expected {} heights, found {}", polygons.len(), heights.len());
                return Err(PyValueError::new_err(message));
            }
        };
        Ok(input(LineKind::Lakes, outlines(polygons)?, 0.0, HeightSource::Lake(height)))
    });
    let footprints =
        footprints.map(|polygons| Ok(input(LineKind::Footprints, outlines(polygons)?, shift, HeightSource::Raster)));
    let cutline = cutline.map(|rings| Ok(input(LineKind::Cutline, outlines(rings)?, 0.0, HeightSource::Raster)));
    breaklines.into_iter().chain(lakes).chain(footprints).chain(cutline).collect()
}

/// Lines, with heights where all vertices have three numbers.
fn polylines(lines: &Vertices) -> PyResult<Polylines> {
    let place = |vertex: &Vec<f64>| match vertex[..] {
        [x, y, ..] => Ok((x, y)),
        _ => Err(PyValueError::new_err("expected vertices of two or three numbers")),
    };
    let places = lines.iter().map(|line| line.iter().map(place).collect()).collect::<PyResult<_>>()?;
    let height = |vertex: &Vec<f64>| vertex.get(2).copied();
    let own: Option<Vec<Vec<f64>>> = lines.iter().map(|line| line.iter().map(height).collect()).collect();
    let placed = Polylines::new(places);
    Ok(match own {
        Some(own) => placed.with_heights(own),
        None => placed,
    })
}

impl VerifyOptions<'_> {
    /// What is to be judged, of this band; the mesh is open, or in this file.
    pub(crate) fn request(&self, band: &Band, mesh: PathBuf) -> PyResult<VerifyRequest> {
        let usable = |error: f64| error.is_finite() && error >= 0.0;
        within("max_error", Some(self.max_error), usable, "a finite number, 0 or above, in the units of the heights")?;
        within("max_stray", self.max_stray, |limit| limit >= 1.0, "1 or more, or inf to judge samples alone")?;
        Ok(VerifyRequest {
            max_stray: self.max_stray.filter(|limit| limit.is_finite()),
            attributes: attributes(self.attributes.as_ref(), self.attribute_weight, self.image)?,
            importance: self.importance.as_ref().map(|band| Input::Band(band.get().band.clone())),
            fill_voids: self.fill_holes,
            trim: self.trim,
            lines: lines(&asked_lines!(self))?,
            threads: threads(self.threads)?,
            temp_dir: self.temp_dir.clone(),
            ..VerifyRequest::new(band.clone(), mesh, self.max_error)
        })
    }
}
