//! What is known of a raster before a run: its description, and an estimate of what the run will need.
//!
//! In comes an open raster; out goes plain data that serializes. No sample is read, but for those that tell whether the
//! file can be mapped.

use serde::Serialize;
use serde_json::{Value, json};

use crate::base::tiling::TileGrid;
use crate::base::{Encoding, Mark, RasterError, Reference, SampleType, ValidRange};
use crate::field::suits_windows;
use crate::formats::FORMATS;
use crate::job::DEFAULT_TILE;
use crate::job::plan::{Estimate, Load, Plan, SAMPLES_PER_TRIANGLE, default_budget, estimate};
use crate::raster::Raster;
use crate::run::look::Look;

/// A raster's description.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Info {
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
    /// Samples without a height; null where nobody has looked.
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
    /// The memory a run will need, with the default budget and tile size; null where it takes a larger budget.
    pub memory: Option<Plan>,
}

impl Info {
    /// Describes a raster; `threads` is the number of threads the estimate is for.
    ///
    /// # Errors
    /// [`RasterError`] when GDAL cannot tell whether there is a mask.
    pub fn of(raster: &Raster, threads: usize) -> Result<Info, RasterError> {
        let band = raster.to_band()?;
        let not_in_place_because = band.plain_layout().err();
        let mapped_in_place = not_in_place_because.is_none();
        let grid = TileGrid::new(raster.width(), raster.height(), DEFAULT_TILE);
        let scaling = raster.scaling();
        Ok(Info {
            file: raster.path().display().to_string(),
            driver: raster.driver(),
            band: raster.band(),
            bands: raster.band_count(),
            band_description: raster.band_description(),
            width: raster.width(),
            height: raster.height(),
            window: raster.window().map(|w| [w.column, w.row, w.width, w.height]),
            whole_size: raster.whole_size(),
            sample_type: raster.sample_type().name(),
            nodata: raster.tag().map_or(Value::Null, nodata),
            marks: raster.marks().values.iter().map(|mark| nodata(*mark)).collect(),
            valid_range: raster.marks().valid,
            encoding: raster.encoding(),
            scale: scaling.scale,
            offset: scaling.offset,
            nan_possible: matches!(raster.sample_type(), SampleType::F32 | SampleType::F64),
            mask: band.has_mask(),
            height_range: None,
            missing_samples: None,
            crs: raster.crs_name(),
            reference: raster.reference(),
            crs_wkt: raster.crs_wkt(),
            georeferenced: raster.is_georeferenced(),
            geotransform: raster.geo_transform().coefficients(),
            block: raster.block_size(),
            compression: raster.compression(),
            mapped_in_place,
            not_in_place_because,
            read_by_windows: !mapped_in_place && suits_windows(&band),
            estimate: estimate(&band, None, SAMPLES_PER_TRIANGLE, FORMATS[0]),
            memory: Plan::new(default_budget(), &Load::of(&band, grid), threads).ok(),
        })
    }
}

impl Info {
    /// With what a look at all samples has found.
    pub fn with_look(self, look: &Look) -> Info {
        let height_range = look.range.map(|(min, max)| [min, max]);
        Info { height_range, missing_samples: Some(look.missing), ..self }
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
