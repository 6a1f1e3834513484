use std::path::{Path, PathBuf};
use std::sync::Arc;

use gdal::raster::{ColorInterpretation, RasterBand};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DatasetOptions, GdalOpenFlags, Metadata};

use super::axes;
use super::error::reason;
use super::sample_type::with_sample_type;
use crate::warning::Warning;

use super::{Cutline, GdalName, GeoTransform, Nodata, RasterError, SampleType, Scaling, Window};

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
    /// What of it is looked at.
    window: Window,
    sample_type: SampleType,
    scaling: Scaling,
    /// What the raster's tag says.
    pub(super) nodata: Nodata,
    /// What the caller says.
    pub(super) given_nodata: Option<Nodata>,
    /// What is outside of it has no height.
    pub(super) cutline: Option<Arc<Cutline>>,
    geo_transform: Option<GeoTransform>,
    /// What was found at opening.
    warnings: Vec<Warning>,
}

/// How a raster was opened: threads that need a handle of their own take this along.
#[derive(Debug, Clone, PartialEq)]
pub struct Opening {
    path: PathBuf,
    band: usize,
    given_nodata: Option<Nodata>,
    cutline: Option<Arc<Cutline>>,
    window: Option<Window>,
}

impl Opening {
    /// Opens it.
    ///
    /// # Errors
    /// As [`Raster::open`] and [`Raster::clip`].
    pub fn open(&self) -> Result<Raster, RasterError> {
        Ok(Raster { given_nodata: self.given_nodata, cutline: self.cutline.clone(), ..self.open_band(self.band)? })
    }

    /// Opens another band of the same file, of which the same window is looked at; its nodata value is its own, and it has
    /// no cutline.
    ///
    /// # Errors
    /// As [`Opening::open`].
    pub fn open_band(&self, band: usize) -> Result<Raster, RasterError> {
        let raster = Raster::open(&self.path, band)?;
        match self.window {
            Some(window) => raster.clip(window),
            None => Ok(raster),
        }
    }
}

/// Keeps GDAL from printing on standard error by itself: errors reach the user as [`RasterError`]s, once.
pub fn quiet_gdal() {
    gdal::config::set_error_handler(|_, _, _| {});
}

/// Keeps GDAL's block cache to so many bytes, where the user has not said otherwise by `GDAL_CACHEMAX`: blocks are read
/// and written whole, and GDAL's own choice is a twentieth of the machine's memory. GDAL looks at it once, before the
/// first block is read.
pub fn bound_gdal_cache(bytes: u64) {
    if gdal::config::get_config_option("GDAL_CACHEMAX", "").is_ok_and(|v| v.is_empty()) {
        // A number of 100,000 or more is taken as bytes. Not worth failing for: the cache is larger then.
        let _ = gdal::config::set_config_option("GDAL_CACHEMAX", &bytes.to_string());
    }
}

impl Raster {
    /// Opens `path` (a file, or any name GDAL understands) for reading and looks at `band`, counted from 1.
    ///
    /// # Errors
    /// [`RasterError`] when the file is no raster, has no such band, its samples are complex, it is smaller than
    /// 2 × 2, or its geotransform or scaling cannot be used.
    pub fn open(path: &Path, band: usize) -> Result<Raster, RasterError> {
        let options = DatasetOptions {
            open_flags: GdalOpenFlags::GDAL_OF_READONLY
                | GdalOpenFlags::GDAL_OF_RASTER
                | GdalOpenFlags::GDAL_OF_VERBOSE_ERROR,
            ..DatasetOptions::default()
        };
        let failed = |reason| RasterError::Open { path: path.to_path_buf(), reason };
        let name = GdalName::of(path).map_err(|e| failed(format!("its name is no UTF-8, and no link to it: {e}")))?;
        let dataset = Dataset::open_ex(name.path(), options)
            .map_err(|e| failed(reason(&e).trim_start_matches(&format!("{}: ", name.path().display())).to_string()))?;
        let count = dataset.raster_count();
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
        axes::check(path, name.path(), &dataset)?;
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
        let (sample_type, scaling, nodata) = {
            let b = dataset.rasterband(band).map_err(|e| RasterError::gdal(path, "band", &e))?;
            let sample_type = sample_type(&b).ok_or_else(|| RasterError::SampleType {
                path: path.to_path_buf(),
                band,
                found: type_name(&b),
            })?;
            (sample_type, scaling(path, &b)?, nodata(&b, sample_type))
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
            nodata,
            given_nodata: None,
            cutline: None,
            geo_transform,
            warnings: Vec::new(),
        })
    }

    /// The same raster, of which only a window is looked at: from here on it is as large as the window, and columns and
    /// rows are counted from the window's first sample. Map coordinates of samples stay what they were, bit for bit.
    ///
    /// # Errors
    /// [`RasterError::Window`] if it reaches out of the raster or has less than 2 samples across or down.
    ///
    /// # Panics
    /// If the raster has a cutline: its places are those of the window for which it was read.
    pub fn clip(self, window: Window) -> Result<Raster, RasterError> {
        assert!(self.cutline.is_none(), "a window of a raster with a cutline");
        let inside = |first: usize, count: usize, all: usize| first.checked_add(count).is_some_and(|end| end <= all);
        let Window { column, row, width, height } = window;
        if !inside(column, width, self.width()) || !inside(row, height, self.height()) || width < 2 || height < 2 {
            let (path, size) = (self.path, (self.window.width, self.window.height));
            return Err(RasterError::Window { path, window, width: size.0, height: size.1 });
        }
        let first = (self.window.column + column, self.window.row + row);
        Ok(Raster {
            window: Window { column: first.0, row: first.1, width, height },
            geo_transform: self.geo_transform.map(|g| g.of_window(column, row)),
            ..self
        })
    }

    /// Makes sure that a row of so many samples can be held in memory: a file may claim any size.
    ///
    /// # Errors
    /// [`RasterError::Wide`].
    pub fn holds_rows(&self, found: usize) -> Result<(), RasterError> {
        /// As doubles, half a gibibyte.
        const LIMIT: usize = 1 << 26;
        if found <= LIMIT { Ok(()) } else { Err(RasterError::Wide { path: self.path.clone(), limit: LIMIT, found }) }
    }

    /// What of the whole raster is looked at, if it is not all of it.
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
        Opening { path, band: self.band, given_nodata: self.given_nodata, cutline, window: self.window() }
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

    /// The colour that the band is said to hold: red, green, blue or alpha.
    pub fn colour(&self) -> Option<&'static str> {
        match self.rasterband().ok()?.color_interpretation() {
            ColorInterpretation::RedBand => Some("red"),
            ColorInterpretation::GreenBand => Some("green"),
            ColorInterpretation::BlueBand => Some("blue"),
            ColorInterpretation::AlphaBand => Some("alpha"),
            _ => None,
        }
    }

    /// Whether samples are numbers of entries in a table of colours, and so no heights. A table of greys, from dark to
    /// bright, is none: with that, some formats say that samples are a measure of something.
    pub fn has_colour_table(&self) -> bool {
        let Ok(band) = self.rasterband() else { return false };
        let Some(table) = band.color_table() else { return false };
        let entries: Vec<_> = (0..table.entry_count()).filter_map(|i| table.entry_as_rgb(i)).collect();
        let grey = entries.iter().all(|e| e.r == e.g && e.g == e.b);
        !(grey && entries.windows(2).all(|pair| pair[0].r < pair[1].r))
    }

    /// What the band is said to hold, in words; empty where nothing is said.
    pub fn description(&self) -> String {
        self.rasterband().ok().and_then(|b| b.description().ok()).unwrap_or_default()
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

    /// The mark of samples without a height: what the raster says, unless the caller has said otherwise.
    pub fn nodata(&self) -> Nodata {
        self.given_nodata.unwrap_or(self.nodata)
    }

    /// The raster's geotransform, or the default one where it has none.
    pub fn geo_transform(&self) -> GeoTransform {
        self.geo_transform.unwrap_or(GeoTransform::DEFAULT.of_window(self.window.column, self.window.row))
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

    /// Whether GDAL marks samples invalid by a mask or alpha band, or by one value for each band together
    /// (`NODATA_VALUES`), apart from any nodata value of the band's own.
    ///
    /// # Errors
    /// [`RasterError::Gdal`] when GDAL cannot tell.
    pub fn has_mask(&self) -> Result<bool, RasterError> {
        let flags = self.rasterband()?.mask_flags().map_err(|e| RasterError::gdal(&self.path, "mask", &e))?;
        Ok(!flags.is_all_valid() && (!flags.is_nodata() || flags.is_per_dataset()))
    }

    /// Reads a window as it is stored, in the machine's byte order, rows one after the other. `out` is
    /// `window.len()` samples long and aligned to 8 bytes.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    ///
    /// # Panics
    /// If `out` has another length, or the window is not inside the raster.
    pub fn read_native(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.check(window);
        assert_eq!(out.len(), window.len() * self.sample_type.bytes(), "buffer of {window:?}");
        match self.sample_type {
            SampleType::I8 => self.read_signed_bytes(window, out),
            other => with_sample_type!(other, T => self.read_cast::<T>(window, bytemuck::cast_slice_mut(out))),
        }
    }

    /// GDAL before 3.7 has signed bytes as bytes with a mark; later ones have a type for them, which these bindings do
    /// not always know, and would cut negative values off on the way to bytes: it is read as 16-bit integers.
    fn read_signed_bytes(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        if self.rasterband()?.band_type().name() == "Byte" {
            return self.read::<u8>(window, out);
        }
        let mut wide = vec![0i16; out.len()];
        self.read(window, &mut wide)?;
        for (byte, value) in out.iter_mut().zip(wide) {
            *byte = value as i8 as u8;
        }
        Ok(())
    }

    /// Reads a window as heights, scale and offset applied, rows one after the other. Samples marked nodata come as
    /// the number they are stored as.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    ///
    /// # Panics
    /// If `out` is not `window.len()` long, or the window is not inside the raster.
    pub fn read_heights(&self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        self.read_stored(window, out)?;
        self.scale(out);
        Ok(())
    }

    /// Reads a window of stored values as doubles: exactly, but for 64-bit integers beyond 2⁵³.
    pub(super) fn read_stored(&self, window: Window, out: &mut [f64]) -> Result<(), RasterError> {
        self.check(window);
        self.read(window, out)?;
        if self.sample_type == SampleType::I8 {
            out.iter_mut().filter(|v| **v >= 128.0).for_each(|v| *v -= 256.0);
        }
        Ok(())
    }

    /// Stored values become heights.
    pub(super) fn scale(&self, values: &mut [f64]) {
        if !self.scaling.is_none() {
            values.iter_mut().for_each(|v| *v = self.scaling.height(*v));
        }
    }

    /// Reads the validity mask of a window: 0 is invalid.
    ///
    /// # Errors
    /// [`RasterError::Read`].
    pub fn read_mask(&self, window: Window, out: &mut [u8]) -> Result<(), RasterError> {
        self.check(window);
        let band = self.rasterband()?;
        let mask = band.open_mask_band().map_err(|e| RasterError::gdal(&self.path, "mask", &e))?;
        read(&mask, self.in_whole(window), out).map_err(|e| self.read_error(window, &e))
    }

    pub(super) fn rasterband(&self) -> Result<RasterBand<'_>, RasterError> {
        self.dataset.rasterband(self.band).map_err(|e| RasterError::gdal(&self.path, "band", &e))
    }

    fn read_cast<T: Stored>(&self, window: Window, out: &mut [T]) -> Result<(), RasterError> {
        T::read_from(self, window, out)
    }

    fn read<T: gdal::raster::GdalType + Copy>(&self, window: Window, out: &mut [T]) -> Result<(), RasterError> {
        read(&self.rasterband()?, self.in_whole(window), out).map_err(|e| self.read_error(window, &e))
    }

    fn read_error(&self, window: Window, error: &gdal::errors::GdalError) -> RasterError {
        let Window { column, row, width, height } = window;
        RasterError::Read { path: self.path.clone(), column, row, width, height, reason: reason(error) }
    }

    fn check(&self, w: Window) {
        let inside = w.column + w.width <= self.width() && w.row + w.height <= self.height();
        assert!(inside, "{w:?} of a raster of {} × {}", self.width(), self.height());
    }

    /// Where the samples of a window are in the dataset.
    fn in_whole(&self, window: Window) -> Window {
        Window { column: self.window.column + window.column, row: self.window.row + window.row, ..window }
    }
}

/// The types GDAL reads straight into; its bindings for 3.6 know no signed bytes, which are read as bytes.
trait Stored: Sized {
    fn read_from(raster: &Raster, window: Window, out: &mut [Self]) -> Result<(), RasterError>;
}
macro_rules! stored {
    ($($t:ty),*) => {$(
        impl Stored for $t {
            fn read_from(raster: &Raster, window: Window, out: &mut [Self]) -> Result<(), RasterError> {
                raster.read(window, out)
            }
        }
    )*};
}
stored!(u8, u16, i16, u32, i32, u64, i64, f32, f64);
impl Stored for i8 {
    fn read_from(raster: &Raster, window: Window, out: &mut [Self]) -> Result<(), RasterError> {
        raster.read::<u8>(window, bytemuck::cast_slice_mut(out))
    }
}

fn read<T: gdal::raster::GdalType + Copy>(
    band: &RasterBand<'_>,
    window: Window,
    out: &mut [T],
) -> gdal::errors::Result<()> {
    let size = (window.width, window.height);
    band.read_into_slice((window.column as isize, window.row as isize), size, size, out, None)
}

fn sample_type(band: &RasterBand<'_>) -> Option<SampleType> {
    let signed_byte = band.metadata_item("PIXELTYPE", "IMAGE_STRUCTURE").is_some_and(|v| v == "SIGNEDBYTE");
    SampleType::from_gdal(band.band_type(), signed_byte)
}

fn type_name(band: &RasterBand<'_>) -> String {
    match band.band_type().name() {
        name if name == "Unknown" => "a complex or unknown type".to_string(),
        name => name,
    }
}

fn scaling(path: &Path, band: &RasterBand<'_>) -> Result<Scaling, RasterError> {
    let scaling = Scaling { scale: band.scale().unwrap_or(1.0), offset: band.offset().unwrap_or(0.0) };
    let usable = scaling.scale.is_finite() && scaling.scale != 0.0 && scaling.offset.is_finite();
    if usable {
        return Ok(scaling);
    }
    Err(RasterError::Scaling { path: path.to_path_buf(), scale: scaling.scale, offset: scaling.offset })
}

fn nodata(band: &RasterBand<'_>, sample_type: SampleType) -> Nodata {
    match sample_type {
        SampleType::I64 => band.no_data_value_i64().map_or(Nodata::None, Nodata::I64),
        SampleType::U64 => band.no_data_value_u64().map_or(Nodata::None, Nodata::U64),
        _ => band.no_data_value().map_or(Nodata::None, Nodata::Real),
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
