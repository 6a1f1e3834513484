//! Writing one band of single floats, row by row, as a tiled GeoTIFF.

use std::path::{Path, PathBuf};

use gdal::errors::GdalError;
use gdal::raster::{Buffer, RasterCreationOptions};
use gdal::spatial_ref::SpatialRef;
use gdal::{Dataset, DriverManager, Metadata};

use super::{About, GdalName, reason};
use crate::base::Band;
use crate::base::staged::{OutputError, StagedFile};

/// Why a raster cannot be written. Every message names the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// It cannot be made where it shall be, or take its name.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// GDAL refuses to do something.
    #[error("{}: {what}: {reason}", path.display())]
    Gdal {
        /// The raster that is written.
        path: PathBuf,
        /// What failed.
        what: &'static str,
        /// What GDAL said.
        reason: String,
    },
}

/// What is said of a raster in its file.
#[derive(Debug, Clone, Copy)]
pub struct Described<'a> {
    /// What the band holds, its unit with it.
    pub band: &'a str,
    /// What it is, in a sentence (the tag ImageDescription).
    pub image: &'a str,
}

/// A GeoTIFF of single floats on the samples of a band, that is written by rows: tiled, DEFLATE, NaN where there is no number. It
/// appears whole, when it is finished, or not at all. The bytes depend on the numbers, on what is said of them and on the version of GDAL alone.
///
/// Memory: a row of tiles, 4 bytes a sample, 32 MiB at most; more only where 16 rows are more.
pub struct RowWriter {
    // Closed before the file is removed, where it is not finished.
    dataset: Dataset,
    staged: StagedFile,
    width: usize,
    height: usize,
    tile: (usize, usize),
    /// The rows of the next row of tiles, as far as they are there.
    rows: Vec<f32>,
    /// How many rows of tiles are written.
    written: usize,
}

impl RowWriter {
    /// Makes a file for the samples of `band`, with its place on the map and CRS. `inputs` are files that it may not replace.
    ///
    /// # Errors
    /// [`WriteError`].
    pub fn create(
        path: &Path,
        overwrite: bool,
        inputs: &[&Path],
        band: &Band,
        described: Described<'_>,
    ) -> Result<RowWriter, WriteError> {
        let staged = StagedFile::create(path, overwrite, inputs)?;
        let name = GdalName::of(staged.partial_path()).map_err(|e| staged.write_error(e))?;
        let _about = About::reading(path);
        let failed = |e| gdal_failed(path, "cannot be created", &e);
        let (width, height) = (band.width(), band.height());
        let tile = tile_size(width);
        let options = RasterCreationOptions::from_iter([
            "TILED=YES".to_string(),
            format!("BLOCKXSIZE={}", tile.0),
            format!("BLOCKYSIZE={}", tile.1),
            "COMPRESS=DEFLATE".to_string(),
            "PREDICTOR=3".to_string(),
            // Errors are nearly noise: more work makes the file 3 % smaller, and takes 70 % longer.
            "ZLEVEL=1".to_string(),
            // Compressed by threads of its own, written in order.
            "NUM_THREADS=ALL_CPUS".to_string(),
            "BIGTIFF=IF_SAFER".to_string(),
        ]);
        let driver = DriverManager::get_driver_by_name("GTiff").map_err(failed)?;
        let mut dataset = driver
            .create_with_band_type_with_options::<f32, _>(name.path(), width, height, 1, &options)
            .map_err(failed)?;
        describe(&mut dataset, band, described).map_err(|e| gdal_failed(path, "cannot be described", &e))?;
        Ok(RowWriter { staged, dataset, width, height, tile, rows: Vec::new(), written: 0 })
    }

    /// Takes the next rows.
    ///
    /// # Errors
    /// [`WriteError::Gdal`].
    ///
    /// # Panics
    /// If they are no whole rows, or more than there are.
    pub fn write(&mut self, rows: &[f32]) -> Result<(), WriteError> {
        assert_eq!(rows.len() % self.width, 0, "whole rows of {} samples", self.width);
        for row in rows.chunks(self.width) {
            self.rows.extend_from_slice(row);
            let there = self.rows.len() / self.width;
            if there == self.tile.1 || self.written * self.tile.1 + there == self.height {
                self.write_tiles()?;
            }
        }
        Ok(())
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`WriteError`].
    ///
    /// # Panics
    /// If rows are missing.
    pub fn finish(self) -> Result<(), WriteError> {
        let RowWriter { staged, dataset, height, tile, written, .. } = self;
        assert_eq!(written, height.div_ceil(tile.1), "rows of tiles");
        let failed = |e| gdal_failed(staged.path(), "cannot be completed", &e);
        dataset.close().map_err(failed)?;
        // GDAL before 3.7 closes files without a word about errors: the last sample tells whether all went well.
        let again = Dataset::open(staged.partial_path()).map_err(failed)?;
        let last = (self.width as isize - 1, height as isize - 1);
        again.rasterband(1).and_then(|band| band.read_as::<f32>(last, (1, 1), (1, 1), None)).map_err(failed)?;
        drop(again);
        Ok(staged.commit()?)
    }

    /// Writes the tiles whose rows are there; what lies beyond the raster's rim has no number.
    fn write_tiles(&mut self) -> Result<(), WriteError> {
        let (across, down) = self.tile;
        let failed = |e: GdalError| gdal_failed(self.staged.path(), "cannot be written", &e);
        let mut band = self.dataset.rasterband(1).map_err(failed)?;
        for column in 0..self.width.div_ceil(across) {
            let mut tile = vec![f32::NAN; across * down];
            for (to, from) in tile.chunks_mut(across).zip(self.rows.chunks(self.width)) {
                let part = &from[column * across..((column + 1) * across).min(self.width)];
                to[..part.len()].copy_from_slice(part);
            }
            band.write_block((column, self.written), &mut Buffer::new(self.tile, tile)).map_err(failed)?;
        }
        self.rows.clear();
        self.written += 1;
        Ok(())
    }
}

/// Samples across and down a tile, for rows of this length.
fn tile_size(width: usize) -> (usize, usize) {
    const MOST: usize = 8 << 20;
    let down = [256, 128, 64, 32].into_iter().find(|down| down * width <= MOST).unwrap_or(16);
    (256, down)
}

fn describe(dataset: &mut Dataset, band: &Band, described: Described<'_>) -> gdal::errors::Result<()> {
    if let Some(crs) = band.crs_definition() {
        dataset.set_spatial_ref(&SpatialRef::from_definition(crs)?)?;
    }
    if band.is_georeferenced() {
        let transform = band.geo_transform();
        let [_, c1, c2, _, c4, c5] = transform.coefficients();
        // Of a window, too: its corner is half a cell from its first sample.
        let (x, y) = transform.place(-0.5, -0.5);
        dataset.set_geo_transform(&[x, c1, c2, y, c4, c5])?;
    }
    let pixel_is = &band.reference().pixel_is;
    if !pixel_is.is_empty() {
        dataset.set_metadata_item("AREA_OR_POINT", pixel_is, "")?;
    }
    dataset.set_metadata_item("TIFFTAG_SOFTWARE", concat!("terrabite ", env!("CARGO_PKG_VERSION")), "")?;
    dataset.set_metadata_item("TIFFTAG_IMAGEDESCRIPTION", described.image, "")?;
    let mut own = dataset.rasterband(1)?;
    own.set_no_data_value(Some(f64::NAN))?;
    own.set_description(described.band)
}

fn gdal_failed(path: &Path, what: &'static str, error: &GdalError) -> WriteError {
    WriteError::Gdal { path: path.to_path_buf(), what, reason: reason(error) }
}
