//! Opening a raster through GDAL, and what is known of it then.

use super::gdal_error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gdal::errors::GdalError;
use gdal::raster::RasterBand;
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};

use super::axes;
use super::drivers::{self, Unread};
use super::encoding::Encoded;
use super::gdal_error::reason;
use super::gdal_messages::About;
use super::remote::be_patient;
use super::sample_type::of_gdal;
use crate::base::warning::Warning;

use super::{GdalName, RasterError};
use crate::base::{Cutline, Encoding, Mark, Marks, SampleType, Scaling};
use crate::base::{GeoTransform, Window};

/// One band of an open raster. Not shared between threads: each opens its own.
#[derive(Debug)]
pub struct Raster {
    path: PathBuf,
    pub(super) dataset: Dataset,
    /// Kept as long as the dataset, which is dropped before it.
    _name: GdalName,
    pub(super) band: usize,
    /// Samples across and down the dataset.
    whole: (usize, usize),
    /// The window of it, if the view is not the whole raster.
    window: Window,
    pub(super) sample_type: SampleType,
    pub(super) scaling: Scaling,
    /// The raster's nodata tag.
    pub(super) tag: Option<Mark>,
    /// What counts as missing: the tag, unless the caller says otherwise.
    pub(super) marks: Marks,
    /// Whether somebody has said the marks.
    pub(super) marks_are_said: bool,
    /// The words by which nodata values were said.
    pub(super) nodata_words: Vec<String>,
    /// Whether the tag is among the marks because the raster has it, and not because the caller named that value.
    pub(super) tag_counts: bool,
    /// Where heights are stored as colours.
    pub(super) encoded: Option<Encoded>,
    /// Samples outside of it have no height.
    pub(super) cutline: Option<Arc<Cutline>>,
    open_options: Vec<String>,
    geo_transform: Option<GeoTransform>,
    /// What was found at opening.
    pub(super) warnings: Vec<Warning>,
}

/// How a raster was opened: threads that need a handle of their own take this along.
#[derive(Debug, Clone, PartialEq)]
pub struct Opening {
    path: PathBuf,
    open_options: Vec<String>,
    band: usize,
    marks: Marks,
    encoding: Option<Encoding>,
    cutline: Option<Arc<Cutline>>,
    window: Option<Window>,
}

impl Opening {
    /// Opens it.
    ///
    /// # Errors
    /// As [`Raster::open`] and [`Raster::clip`].
    pub fn open(&self) -> Result<Raster, RasterError> {
        let raster = self.open_band(self.band)?;
        let raster = match self.encoding {
            Some(encoding) => raster.with_encoding(encoding)?,
            None => raster,
        };
        Ok(Raster { marks: self.marks.clone(), cutline: self.cutline.clone(), ..raster })
    }

    /// Opens another band of the same file, in the same window; its nodata tag is its own, and it has no cutline and no
    /// encoding.
    ///
    /// # Errors
    /// As [`Opening::open`].
    pub fn open_band(&self, band: usize) -> Result<Raster, RasterError> {
        let raster = Raster::open_with(&self.path, band, &self.open_options)?;
        match self.window {
            Some(window) => raster.clip(window),
            None => Ok(raster),
        }
    }
}

impl Raster {
    /// Opens `path` (a file, or any name GDAL understands) for reading and looks at `band`, counted from 1.
    ///
    /// # Errors
    /// [`RasterError`] when the file is no raster, has no such band, its samples are complex, it is smaller than
    /// 2 × 2, or its geotransform or scaling cannot be used.
    pub fn open(path: &Path, band: usize) -> Result<Raster, RasterError> {
        Raster::open_with(path, band, &[])
    }

    /// The same with open options of the format's driver, `NAME=VALUE` each.
    ///
    /// # Errors
    /// As [`Raster::open`].
    pub fn open_with(path: &Path, band: usize, open_options: &[String]) -> Result<Raster, RasterError> {
        let words: Vec<&str> = open_options.iter().map(String::as_str).collect();
        let options = DatasetOptions {
            open_options: Some(&words),
            open_flags: GdalOpenFlags::GDAL_OF_READONLY
                | GdalOpenFlags::GDAL_OF_RASTER
                | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
            ..DatasetOptions::default()
        };
        be_patient(path);
        let _about = About::opening(path);
        let failed = |reason| RasterError::Open { path: path.to_path_buf(), reason };
        let name = GdalName::of(path).map_err(|e| failed(format!("its name is no UTF-8, and no link to it: {e}")))?;
        let dataset = Dataset::open_ex(name.path(), options).map_err(|e| failed(why_not(name.path(), &e)))?;
        let count = dataset.raster_count();
        refuse_unread(path, &dataset)?;
        if count == 0 {
            return Err(RasterError::NoBands { path: path.to_path_buf(), hint: subdatasets(&dataset) });
        }
        if band == 0 || band > count {
            return Err(RasterError::NoSuchBand { path: path.to_path_buf(), band, count });
        }
        let (width, height) = dataset.raster_size();
        if width < 2 || height < 2 {
            return Err(RasterError::TooSmall { path: path.to_path_buf(), width, height });
        }
        let warnings = axes::check(path, name.path(), &dataset)?;
        let geo_transform = match dataset.geo_transform() {
            Err(_) => match other_georeferencing(&dataset) {
                Some(found) => return Err(RasterError::NotAffine { path: path.to_path_buf(), found }),
                None => None,
            },
            Ok(c) => Some(GeoTransform::new(c, width, height).map_err(|reason| RasterError::GeoTransform {
                path: path.to_path_buf(),
                coefficients: c,
                reason,
            })?),
        };
        let (sample_type, scaling, tag) = {
            let b = dataset.rasterband(band).map_err(|e| gdal_error::failed(path, "band", &e))?;
            let sample_type = sample_type(&b).ok_or_else(|| RasterError::SampleType {
                path: path.to_path_buf(),
                band,
                found: type_name(&b),
            })?;
            (sample_type, scaling(path, &b)?, tag(&b, sample_type))
        };
        Ok(Raster {
            path: path.to_path_buf(),
            dataset,
            _name: name,
            band,
            whole: (width, height),
            window: Window { column: 0, row: 0, width, height },
            sample_type,
            scaling,
            tag,
            marks: Marks { values: tag.into_iter().collect(), valid: None },
            marks_are_said: false,
            nodata_words: Vec::new(),
            tag_counts: true,
            encoded: None,
            cutline: None,
            open_options: open_options.to_vec(),
            geo_transform,
            warnings,
        })
    }

    /// The same raster, of which only a window is looked at: from here on it is as large as the window, and columns and
    /// rows are counted from the window's first sample. Map coordinates of samples stay what they were, bit for bit.
    ///
    /// # Errors
    /// [`RasterError::Window`] if it reaches out of the raster or has less than 2 samples across or down.
    pub fn clip(self, window: Window) -> Result<Raster, RasterError> {
        let Window { column, row, width, height } = window;
        if !window.is_usable_in((self.width(), self.height())) {
            let (path, size) = (self.path, (self.window.width, self.window.height));
            return Err(RasterError::Window { path, window, width: size.0, height: size.1 });
        }
        let first = (self.window.column + column, self.window.row + row);
        Ok(Raster {
            window: Window { column: first.0, row: first.1, width, height },
            geo_transform: self.geo_transform.map(|g| g.of_window(column, row)),
            cutline: self.cutline.map(|cutline| Arc::new(cutline.of_window(column, row))),
            ..self
        })
    }

    /// The window, if the view is not the whole raster.
    pub fn window(&self) -> Option<Window> {
        let (width, height) = self.whole;
        (self.window != Window { column: 0, row: 0, width, height }).then_some(self.window)
    }

    /// Samples across and down the whole raster.
    pub fn whole_size(&self) -> (usize, usize) {
        self.whole
    }

    /// What it takes to open the same raster once more.
    pub fn opening(&self) -> Opening {
        let (path, cutline) = (self.path.clone(), self.cutline.clone());
        let (open_options, marks) = (self.open_options.clone(), self.marks.clone());
        Opening {
            path,
            open_options,
            band: self.band,
            marks,
            encoding: self.encoding(),
            cutline,
            window: self.window(),
        }
    }

    /// What a user should know of it, as far as opening it tells.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The band, counted from 1.
    pub fn band(&self) -> usize {
        self.band
    }

    /// How many bands the raster has.
    pub fn band_count(&self) -> usize {
        self.dataset.raster_count()
    }

    /// What the band is said to hold, in words; empty where nothing is said.
    pub fn description(&self) -> String {
        self.rasterband().ok().and_then(|b| b.description().ok()).unwrap_or_default()
    }

    /// The description, or else the colour, that the band is said to have; empty where neither is said.
    pub fn band_description(&self) -> String {
        match self.description() {
            text if text.is_empty() => self.colour_of(self.band).unwrap_or_default().to_string(),
            text => text,
        }
    }

    /// Samples across (columns).
    pub fn width(&self) -> usize {
        self.window.width
    }

    /// Samples down (rows).
    pub fn height(&self) -> usize {
        self.window.height
    }

    /// The type of the stored samples.
    pub fn sample_type(&self) -> SampleType {
        self.sample_type
    }

    /// How heights follow from stored samples.
    pub fn scaling(&self) -> Scaling {
        self.scaling
    }

    /// The open options it was opened with.
    pub fn open_options(&self) -> &[String] {
        &self.open_options
    }

    /// The raster's geotransform, or the default one where it has none.
    pub fn geo_transform(&self) -> GeoTransform {
        self.geo_transform.unwrap_or(GeoTransform::DEFAULT.of_window(self.window.column, self.window.row))
    }

    /// The raster's own geotransform, of the window.
    pub(super) fn own_geo_transform(&self) -> Option<GeoTransform> {
        self.geo_transform
    }

    /// Whether the raster brings a geotransform of its own.
    pub fn is_georeferenced(&self) -> bool {
        self.geo_transform.is_some()
    }

    /// The coordinate reference system as WKT; empty where the raster has none.
    pub fn crs_wkt(&self) -> String {
        self.dataset.projection()
    }

    /// The coordinate reference system in one line: its authority code where it has one, its name, or "none".
    pub fn crs_name(&self) -> String {
        self.dataset.spatial_ref().map_or_else(|_| "none".to_string(), |crs| crs_name(&crs))
    }

    /// GDAL's name of the format.
    pub fn driver(&self) -> String {
        self.dataset.driver().short_name()
    }

    /// Samples across and down in one block of the file.
    pub fn block_size(&self) -> (usize, usize) {
        self.rasterband().map_or((self.whole.0, 1), |b| b.block_size())
    }

    /// GDAL's name of the compression; `None` where the samples are stored as they are.
    pub fn compression(&self) -> Option<String> {
        self.dataset.metadata_item("COMPRESSION", "IMAGE_STRUCTURE")
    }

    pub(super) fn rasterband(&self) -> Result<RasterBand<'_>, RasterError> {
        self.dataset.rasterband(self.band).map_err(|e| gdal_error::failed(&self.path, "band", &e))
    }

    /// Where the samples of a window are in the dataset.
    pub(super) fn in_whole(&self, window: Window) -> Window {
        Window { column: self.window.column + window.column, row: self.window.row + window.row, ..window }
    }
}

pub(super) fn sample_type(band: &RasterBand<'_>) -> Option<SampleType> {
    let signed_byte = band.metadata_item("PIXELTYPE", "IMAGE_STRUCTURE").is_some_and(|v| v == "SIGNEDBYTE");
    of_gdal(band.band_type(), signed_byte)
}

pub(super) fn type_name(band: &RasterBand<'_>) -> String {
    match band.band_type().name() {
        name if name == "Unknown" => "a complex or unknown type".to_string(),
        name => name,
    }
}

fn scaling(path: &Path, band: &RasterBand<'_>) -> Result<Scaling, RasterError> {
    let scaling = Scaling { scale: band.scale().unwrap_or(1.0), offset: band.offset().unwrap_or(0.0) };
    if scaling.is_usable() {
        return Ok(scaling);
    }
    Err(RasterError::Scaling { path: path.to_path_buf(), scale: scaling.scale, offset: scaling.offset })
}

fn tag(band: &RasterBand<'_>, sample_type: SampleType) -> Option<Mark> {
    match sample_type {
        SampleType::I64 => band.no_data_value_i64().map(Mark::I64),
        SampleType::U64 => band.no_data_value_u64().map(Mark::U64),
        _ => band.no_data_value().map(Mark::Real),
    }
}

/// A CRS in one line, see [`Raster::crs_name`].
pub(super) fn crs_name(crs: &SpatialRef) -> String {
    let name = crs.name().unwrap_or_default();
    match (crs.auth_name(), crs.auth_code()) {
        (Some(authority), Ok(code)) => format!("{authority}:{code} ({name})"),
        _ if name.is_empty() => "none".to_string(),
        _ => name,
    }
}

/// Why GDAL does not open a file, in its words where there are no better ones.
fn why_not(name: &Path, error: &GdalError) -> String {
    if name.join("zarr.json").is_file() {
        return Unread::Zarr3.reason(drivers::version());
    }
    reason(error).trim_start_matches(&format!("{}: ", name.display())).to_string()
}

/// Refuses what GDAL opens without an idea of what it is.
fn refuse_unread(path: &Path, dataset: &Dataset) -> Result<(), RasterError> {
    let product = dataset.metadata_item("productSpecification", "").unwrap_or_default();
    match Unread::of_product(&dataset.driver().short_name(), &product) {
        Some(unread) => Err(RasterError::Open { path: path.to_path_buf(), reason: unread.reason(drivers::version()) }),
        None => Ok(()),
    }
}

/// What places a raster on the map in another way than by a geotransform.
fn other_georeferencing(dataset: &Dataset) -> Option<String> {
    let has = |domain: &str| dataset.metadata_domain(domain).is_some_and(|items| !items.is_empty());
    match dataset.gcps().len() {
        0 if has("RPC") => Some("rational polynomial coefficients (RPC)".to_string()),
        0 if has("GEOLOCATION") => Some("geolocation arrays".to_string()),
        0 => None,
        points => Some(format!("{points} ground control points")),
    }
}

/// The names of subdatasets in a message, at most so many.
const NAMED: usize = 12;

fn subdatasets(dataset: &Dataset) -> String {
    // The whole domain: some drivers do not find its items one by one.
    let items = dataset.metadata_domain("SUBDATASETS").unwrap_or_default();
    let name = |item: &String| item.split_once("_NAME=").map(|(_, name)| format!("'{name}'"));
    let mut names: Vec<String> = items.iter().filter_map(name).collect();
    let all = names.len();
    names.truncate(NAMED);
    let more = if all > NAMED { format!(" and {} more (gdalinfo lists them)", all - NAMED) } else { String::new() };
    match all {
        0 => String::new(),
        _ => format!("; it holds subdatasets, give the name of one in place of the file's: {}{more}", names.join(", ")),
    }
}
