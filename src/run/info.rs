//! What is known of a raster before a run: its description, and an estimate of what the run will need.
//!
//! In comes an open raster; out goes plain data that serializes. No sample is read, but for those that tell whether the
//! file can be mapped.

use serde::Serialize;
use serde_json::{Value, json};

use super::inputs::{open, open_importance};
use super::look::look;
use super::report::SCHEMA;
use super::{Input, Request, RunError, Warned};
use crate::base::channels::ChannelBands;
use crate::base::control::Control;
use crate::base::warning::Warnings;
use crate::base::{Band, Encoding, Mark, RasterError, Reference, SampleType, ValidRange};
use crate::field::{may_have_holes, suits_windows};
use crate::formats::FORMATS;
use crate::job::grid;
use crate::job::plan::{Estimate, Load, Plan, SAMPLES_PER_TRIANGLE, all_cores, default_budget, estimate};
use crate::raster::{Raster, View};

/// A raster's description.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
    /// See [`SCHEMA`].
    pub schema: u32,
    /// The path it was opened by.
    pub file: String,
    /// GDAL's name of the format.
    pub driver: String,
    /// The band described, from 1.
    pub band: usize,
    /// How many bands there are.
    pub bands: usize,
    /// What the band is said to hold; empty where nothing is said.
    pub band_description: String,
    /// Samples across.
    pub width: usize,
    /// Samples down.
    pub height: usize,
    /// Columns and rows before the samples described, and samples across and down; null where they are the whole raster.
    pub window: Option<[usize; 4]>,
    /// Samples across and down the whole raster.
    pub whole_size: (usize, usize),
    /// GDAL's name of the samples' type.
    #[serde(rename = "type")]
    pub sample_type: &'static str,
    /// The raster's nodata tag: a number, "nan", "inf" or "-inf"; null where there is none.
    pub nodata: Value,
    /// The stored values that count as missing: the tag, unless others were given.
    pub marks: Vec<Value>,
    /// The heights that are valid; null where all are.
    pub valid_range: Option<ValidRange>,
    /// How heights are stored as colours; null where they are not.
    pub encoding: Option<Encoding>,
    /// Height = stored value × scale + offset.
    pub scale: f64,
    /// See `scale`.
    pub offset: f64,
    /// Whether samples may be NaN, which have no height either, tagged or not: real types have NaN.
    pub nan_possible: bool,
    /// Whether a mask or alpha band marks samples invalid.
    pub mask: bool,
    /// The least and the largest height; null where no sample has one, or nobody has looked.
    pub height_range: Option<[f64; 2]>,
    /// All samples of the raster, or of the window.
    pub raster_samples: u64,
    /// Samples without a height, those of voids that will be filled among them; null where nobody has looked.
    pub missing_samples: Option<u64>,
    /// The coordinate reference system in one line; "none" where there is none.
    pub crs: String,
    /// What coordinates and heights mean.
    pub reference: Reference,
    /// The coordinate reference system as WKT; empty where there is none.
    pub crs_wkt: String,
    /// Whether the raster brings its own geotransform.
    pub georeferenced: bool,
    /// The geotransform of the whole raster, in GDAL's order; the default one where the raster has none.
    pub geotransform: [f64; 6],
    /// Samples across and down in one block of the file.
    pub block: (usize, usize),
    /// GDAL's name of the compression; null where there is none.
    pub compression: Option<String>,
    /// Whether the samples can be used where they lie in the file, without a copy.
    pub mapped_in_place: bool,
    /// Why not, as the end of the sentence "it is not mapped: …".
    pub not_in_place_because: Option<String>,
    /// Whether, if not, its samples are read by windows, without a temporary file.
    pub read_by_windows: bool,
    /// The disk a run will need.
    pub estimate: Estimate,
    /// The memory a run will need, as the request has budget and tile size; null where it takes a larger budget.
    pub memory: Option<Plan>,
}

/// Describes the raster of a request, and what the run will need as far as that can be told without making tiles: as the
/// request says, so with its importance raster, attributes, tile size, memory and so on. Its output is not looked at.
///
/// All samples are looked at, for the range of heights and for warnings about them, where `looks` says so of their number.
///
/// # Errors
/// [`RunError`]: something cannot be opened, or the caller asked to stop.
pub fn describe(
    request: &Request<'_>,
    looks: impl FnOnce(u64) -> bool,
    control: &Control<'_>,
) -> Result<Description, RunError> {
    let warned = Warned::new(control);
    let Input::Raster { path, view } = &request.input else {
        let path = request.input.path().to_path_buf();
        return Err(RasterError::Open { path, reason: "its samples come from a program".to_string() }.into());
    };
    // A raster of colours is described, too.
    let input = Input::Raster { path: path.clone(), view: View { accept_pictures: true, ..view.clone() } };
    let opened = open(&input, request.attributes.as_ref(), &control.cancel)?;
    let importance = request.importance.as_ref().map(|input| open_importance(input, &opened)).transpose()?;
    let (band, attributes) = (&opened.band, &opened.attributes);
    let importance = importance.as_ref().map(|opened| &opened.band);
    let raster = opened.raster.as_ref().expect("a raster is opened as one");
    let info = Info::of(raster, band, importance, attributes.as_ref(), request)?;
    warned.tell_all(band.warnings());
    importance.iter().for_each(|importance| warned.tell_all(importance.warnings()));
    let is_flat = attributes.as_ref().is_some_and(|a| a.planar);
    let info = if !is_flat && looks(band.samples()) {
        let look = look(band, control).map_err(RunError::of_look)?;
        warned.tell_all(&look.warnings(band));
        Info { height_range: look.range.map(|(min, max)| [min, max]), missing_samples: Some(look.missing), ..info }
    } else {
        info
    };
    let is_refused = view.band.is_none() && request.attributes.is_none();
    let picture = if is_refused { raster.expect_heights().err() } else { None };
    Ok(Description { info, picture, warnings: warned.take() })
}

/// What [`describe`] has found out.
#[derive(Debug)]
pub struct Description {
    /// The raster.
    pub info: Info,
    /// Why a run refuses it: it holds colours, and no band is named.
    pub picture: Option<RasterError>,
    /// What the user should know of it.
    pub warnings: Warnings,
}

impl Info {
    fn of(
        raster: &Raster,
        band: &Band,
        importance: Option<&Band>,
        attributes: Option<&ChannelBands>,
        request: &Request<'_>,
    ) -> Result<Info, RunError> {
        let not_in_place_because = band.plain_layout().err();
        let mapped_in_place = not_in_place_because.is_none();
        let grid = grid(band.width(), band.height(), &request.params)?;
        let scaling = band.scaling();
        let format = request.format.unwrap_or(FORMATS[0]);
        let heights = estimate(band, importance, SAMPLES_PER_TRIANGLE, format);
        let estimate = match attributes {
            None => heights,
            Some(a) => heights.with_channels(&a.bands, a.planar, format),
        };
        let load = Load {
            band,
            importance,
            channels: attributes.map_or(&[], |a| &a.bands),
            grid,
            params: &request.params,
            points: 0,
            lines_bytes: 0,
            holes: request.fill_voids > 0 && may_have_holes(band),
            solid: false,
            normals: false,
        };
        let threads = request.threads.map_or_else(all_cores, usize::from);
        Ok(Info {
            schema: SCHEMA,
            file: band.path().display().to_string(),
            driver: raster.driver(),
            band: band.number(),
            bands: band.bands,
            band_description: band.title.clone(),
            width: band.width(),
            height: band.height(),
            window: band.window.map(|w| [w.column, w.row, w.width, w.height]),
            whole_size: raster.whole_size(),
            sample_type: band.sample_type().name(),
            nodata: band.tag().map_or(Value::Null, nodata),
            marks: band.marks().values.iter().map(|mark| nodata(*mark)).collect(),
            valid_range: band.marks().valid,
            encoding: band.encoding,
            scale: scaling.scale,
            offset: scaling.offset,
            nan_possible: matches!(band.sample_type(), SampleType::F32 | SampleType::F64),
            mask: band.has_mask(),
            height_range: None,
            raster_samples: band.samples(),
            missing_samples: None,
            crs: raster.crs_name(),
            reference: band.reference().clone(),
            crs_wkt: raster.crs_wkt(),
            georeferenced: band.is_georeferenced(),
            geotransform: band.geo_transform().coefficients(),
            block: band.block_size(),
            compression: raster.compression(),
            mapped_in_place,
            not_in_place_because,
            read_by_windows: !mapped_in_place && suits_windows(band),
            estimate,
            memory: Plan::new(request.memory.unwrap_or_else(default_budget), &load, threads).ok(),
        })
    }
}

/// JSON has no NaN and no infinity; a null would read as "none".
fn nodata(mark: Mark) -> Value {
    match mark {
        Mark::Real(v) if v.is_finite() => json!(v),
        Mark::Real(v) => json!(v.to_string().to_lowercase()),
        Mark::I64(v) => json!(v),
        Mark::U64(v) => json!(v),
    }
}
