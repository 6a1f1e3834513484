//! Streaming a terrain into a GeoTIFF.

use std::path::Path;

use gdal::errors::GdalError;
use gdal::raster::{Buffer, GdalType, RasterCreationOptions};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DriverManager, Metadata};
use rayon::prelude::*;

use super::{BlockLayout, Compression, StoredAs, SynthError, SynthOptions, Terrain};
use crate::base::Window;
use crate::base::control::{Control, Stage};
use crate::base::staged::StagedFile;
use crate::raster::{GdalName, reason};

/// What was made.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct SynthReport {
    /// Samples, those without heights among them.
    pub samples: u64,
    /// Samples without heights.
    pub nodata_samples: u64,
    /// The lowest height as stored; NaN where there is none at all.
    pub lowest_m: f64,
    /// The highest height as stored.
    pub highest_m: f64,
}

/// Makes a raster and writes it as a GeoTIFF.
///
/// The samples are made in batches of whole blocks, in parallel on the current rayon pool, and written in order:
/// memory is a few blocks per thread (strips: a few dozen rows per thread), and the samples do not depend on the
/// number of threads. The file is written under a temporary name beside `path` and renamed when it is complete.
///
/// # Errors
/// [`SynthError`]; then nothing new is left at `path` or beside it.
pub fn synth(path: &Path, options: &SynthOptions, control: &Control) -> Result<SynthReport, SynthError> {
    options.check()?;
    let terrain = Terrain::new(&options.terrain)?;
    let staged = StagedFile::create(path, options.overwrite, &[])?;
    let name = GdalName::of(staged.partial_path()).map_err(|e| staged.write_error(e))?;
    let job = Job { path, staged: name.path(), options, terrain: &terrain, control };
    let report = match options.stored_as {
        StoredAs::Int16 => job.run::<i16>(),
        StoredAs::Float32 => job.run::<f32>(),
        StoredAs::Float64 => job.run::<f64>(),
    }?;
    staged.commit()?;
    Ok(report)
}

/// A height as it is stored.
trait Stored: GdalType + Copy + Send + Into<f64> {
    const NODATA: Self;
    fn of(height: f64) -> Self;
}

impl Stored for i16 {
    const NODATA: i16 = i16::MIN;
    fn of(height: f64) -> i16 {
        (height + 0.5).floor().clamp(-32767.0, 32767.0) as i16
    }
}

// Heights never reach −9999: they end at −0.3 of a relief of at most 25,000 metres.
impl Stored for f32 {
    const NODATA: f32 = -9999.0;
    fn of(height: f64) -> f32 {
        height as f32
    }
}

impl Stored for f64 {
    const NODATA: f64 = -9999.0;
    fn of(height: f64) -> f64 {
        height
    }
}

struct Job<'a> {
    path: &'a Path,
    staged: &'a Path,
    options: &'a SynthOptions,
    terrain: &'a Terrain,
    control: &'a Control<'a>,
}

impl Job<'_> {
    fn run<T: Stored>(&self) -> Result<SynthReport, SynthError> {
        let SynthOptions { width, height, .. } = *self.options;
        let failed = |what| move |e| gdal_failed(self.path, what, &e);
        let mut dataset = self.create::<T>()?;
        self.describe::<T>(&mut dataset).map_err(failed("cannot be described"))?;
        let samples = width as u64 * height as u64;
        self.control.progress.begin(Stage::Rows, Units::of(self.options).count() as u64, samples);
        let report = self.fill::<T>(&dataset)?;
        dataset.close().map_err(failed("cannot be completed"))?;
        self.check_complete()?;
        self.control.progress.end(Stage::Rows);
        Ok(report)
    }

    /// Batch by batch: made in parallel, written in order.
    fn fill<T: Stored>(&self, dataset: &Dataset) -> Result<SynthReport, SynthError> {
        let failed = |what| move |e| gdal_failed(self.path, what, &e);
        let mut band = dataset.rasterband(1).map_err(failed("has no band"))?;
        let units = Units::of(self.options);
        let mut report = SynthReport::default();
        let batch = 2 * rayon::current_num_threads();
        for first in (0..units.count()).step_by(batch) {
            self.control.cancel.check()?;
            let indices = first..(first + batch).min(units.count());
            let made: Vec<Made<T>> = indices.into_par_iter().map(|i| self.make(units.window(i))).collect();
            for mut unit in made {
                let Window { column, row, width, height } = unit.window;
                report.count(&unit);
                band.write((column as isize, row as isize), (width, height), &mut unit.samples)
                    .map_err(failed("cannot be written"))?;
                self.control.progress.step(Stage::Rows, unit.window.len() as u64);
            }
        }
        Ok(report.finished())
    }

    fn make<T: Stored>(&self, window: Window) -> Made<T> {
        let mut heights = vec![0.0; window.len()];
        self.terrain.fill(window, &mut heights);
        let gaps = heights.iter().filter(|h| h.is_nan()).count();
        let samples: Vec<T> = heights.iter().map(|&h| if h.is_nan() { T::NODATA } else { T::of(h) }).collect();
        Made { window, gaps, samples: Buffer::new((window.width, window.height), samples) }
    }

    fn create<T: Stored>(&self) -> Result<Dataset, SynthError> {
        let SynthOptions { width, height, .. } = *self.options;
        let failed = |e| gdal_failed(self.path, "cannot be created", &e);
        let creation = RasterCreationOptions::from_iter(creation_options(self.options));
        let driver = DriverManager::get_driver_by_name("GTiff").map_err(failed)?;
        driver.create_with_band_type_with_options::<T, _>(self.staged, width, height, 1, &creation).map_err(failed)
    }

    fn describe<T: Stored>(&self, dataset: &mut Dataset) -> gdal::errors::Result<()> {
        let cell = self.options.cell_m;
        dataset.set_spatial_ref(&SpatialRef::from_epsg(32633)?)?;
        dataset.set_geo_transform(&[ORIGIN.0, cell, 0.0, ORIGIN.1, 0.0, -cell])?;
        dataset.set_metadata_item("AREA_OR_POINT", "Area", "")?;
        dataset.set_metadata_item("TIFFTAG_SOFTWARE", concat!("terrabite ", env!("CARGO_PKG_VERSION")), "")?;
        dataset.set_metadata_item("TIFFTAG_IMAGEDESCRIPTION", &recipe(self.options), "")?;
        let mut band = dataset.rasterband(1)?;
        band.set_description("elevation")?;
        if self.options.terrain.nodata_share > 0.0 {
            band.set_no_data_value(Some(T::NODATA.into()))?;
        }
        Ok(())
    }

    /// GDAL before 3.7 closes files without a word about errors: the last block tells whether all went well.
    fn check_complete(&self) -> Result<(), SynthError> {
        let SynthOptions { width, height, .. } = *self.options;
        let failed = |e| gdal_failed(self.path, "cannot be completed", &e);
        let dataset = Dataset::open(self.staged).map_err(failed)?;
        let band = dataset.rasterband(1).map_err(failed)?;
        let last = (width as isize - 1, height as isize - 1);
        band.read_as::<f64>(last, (1, 1), (1, 1), None).map_err(failed)?;
        Ok(())
    }
}

/// The raster's upper left corner in UTM zone 33N: the Eastern Alps.
const ORIGIN: (f64, f64) = (300_000.0, 5_400_000.0);

/// What it takes to make the same raster again.
fn recipe(options: &SynthOptions) -> String {
    let t = &options.terrain;
    format!(
        "terrabite synth --size {}x{} --seed {} --relief {} --roughness {} --lakes {} --nodata-share {}{}",
        options.width,
        options.height,
        t.seed,
        t.relief_m,
        t.roughness,
        t.lakes,
        t.nodata_share,
        if t.cliffs { " --cliffs" } else { "" }
    )
}

fn creation_options(options: &SynthOptions) -> Vec<String> {
    let mut list = vec!["BIGTIFF=IF_SAFER".to_string()];
    match options.layout {
        BlockLayout::Tiles(n) => {
            list.extend(["TILED=YES".to_string(), format!("BLOCKXSIZE={n}"), format!("BLOCKYSIZE={n}")]);
        }
        BlockLayout::Strips(n) => list.push(format!("BLOCKYSIZE={n}")),
    }
    let name = match options.compression {
        Compression::None => None,
        Compression::Deflate => Some("DEFLATE"),
        Compression::Lzw => Some("LZW"),
        Compression::Zstd => Some("ZSTD"),
    };
    if let Some(name) = name {
        let predictor = match options.stored_as {
            StoredAs::Int16 => 2,
            // libtiff 4.5 (GDAL 3.6) writes the floating-point predictor wrongly into big-endian files.
            _ if options.big_endian => 1,
            StoredAs::Float32 | StoredAs::Float64 => 3,
        };
        let threads = rayon::current_num_threads();
        list.extend([format!("COMPRESS={name}"), format!("PREDICTOR={predictor}"), format!("NUM_THREADS={threads}")]);
    }
    if options.big_endian {
        list.push("ENDIANNESS=BIG".to_string());
    }
    list
}

/// What one thread makes at a time: whole blocks, large enough that the nodes around its rim cost little.
struct Units {
    width: usize,
    height: usize,
    unit_width: usize,
    unit_height: usize,
}

impl Units {
    fn of(options: &SynthOptions) -> Units {
        const ENOUGH: usize = 128;
        let SynthOptions { width, height, .. } = *options;
        let (unit_width, unit_height) = match options.layout {
            BlockLayout::Tiles(n) => (n * ENOUGH.div_ceil(n), n * ENOUGH.div_ceil(n)),
            BlockLayout::Strips(n) => (width, n * 32usize.div_ceil(n)),
        };
        Units { width, height, unit_width, unit_height }
    }

    fn count(&self) -> usize {
        self.width.div_ceil(self.unit_width) * self.height.div_ceil(self.unit_height)
    }

    fn window(&self, index: usize) -> Window {
        let across = self.width.div_ceil(self.unit_width);
        let (column, row) = (index % across * self.unit_width, index / across * self.unit_height);
        let (width, height) = (self.unit_width.min(self.width - column), self.unit_height.min(self.height - row));
        Window { column, row, width, height }
    }
}

struct Made<T> {
    window: Window,
    gaps: usize,
    samples: Buffer<T>,
}

impl Default for SynthReport {
    fn default() -> Self {
        SynthReport { samples: 0, nodata_samples: 0, lowest_m: f64::INFINITY, highest_m: f64::NEG_INFINITY }
    }
}

impl SynthReport {
    fn count<T: Stored>(&mut self, unit: &Made<T>) {
        self.samples += unit.window.len() as u64;
        self.nodata_samples += unit.gaps as u64;
        let nodata: f64 = T::NODATA.into();
        for &stored in unit.samples.data() {
            let height: f64 = stored.into();
            if height != nodata {
                self.lowest_m = self.lowest_m.min(height);
                self.highest_m = self.highest_m.max(height);
            }
        }
    }

    fn finished(mut self) -> SynthReport {
        if self.nodata_samples == self.samples {
            (self.lowest_m, self.highest_m) = (f64::NAN, f64::NAN);
        }
        self
    }
}

/// What GDAL refuses to do.
fn gdal_failed(path: &Path, what: &'static str, error: &GdalError) -> SynthError {
    SynthError::Gdal { path: path.to_path_buf(), what, reason: reason(error) }
}
