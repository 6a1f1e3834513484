//! Decoding a raster into a temporary file of square blocks.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::FieldError;
use super::map::map;
use super::store::{Bytes, Offsets, Store};
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::base::{Band, Window};

/// Samples along one side of a block of the temporary file, at most: small enough that a tile touches few pages it does
/// not need, large enough that a run is worth a copy.
const BLOCK: usize = 256;

/// The most bytes of samples one thread reads at a time, unless one block of the source alone has more.
pub const UNIT_BYTES: usize = 4 << 20;

/// The temporary file's shape. Blocks are no longer than the raster, so that thin rasters are not padded.
#[derive(Clone, Copy)]
struct Layout {
    width: usize,
    block_width: usize,
    block_height: usize,
    blocks_across: usize,
    sample_bytes: usize,
    bytes: u64,
}

impl Layout {
    fn of(band: &Band, sample_bytes: usize) -> Layout {
        let (block_width, block_height) = (BLOCK.min(band.width()), BLOCK.min(band.height()));
        let blocks_across = band.width().div_ceil(block_width);
        let blocks = blocks_across as u64 * band.height().div_ceil(block_height) as u64;
        // A file may claim any size; this much no disk has.
        let bytes = blocks.saturating_mul((block_width * block_height * sample_bytes) as u64);
        Layout { width: band.width(), block_width, block_height, blocks_across, sample_bytes, bytes }
    }
}

/// How many bytes the temporary files of a raster take.
pub fn decoded_bytes(band: &Band) -> u64 {
    let mask = band.has_mask().then(|| Layout::of(band, 1).bytes);
    Layout::of(band, band.sample_type().bytes()).bytes + mask.unwrap_or(0)
}

/// A temporary file of samples, or of the bytes of a mask, that is being filled; already unlinked.
pub(super) struct Decoding {
    file: File,
    layout: Layout,
    is_mask: bool,
    folder: PathBuf,
}

impl Decoding {
    /// Makes the file. It has its full size, and no blocks on the disk.
    pub(super) fn new(band: &Band, is_mask: bool, folder: &Path) -> Result<Decoding, FieldError> {
        let sample_bytes = if is_mask { 1 } else { band.sample_type().bytes() };
        let (layout, folder) = (Layout::of(band, sample_bytes), folder.to_path_buf());
        let sized = |file: File| file.set_len(layout.bytes).map(|()| file);
        match tempfile::tempfile_in(&folder).and_then(sized) {
            Ok(file) => Ok(Decoding { file, layout, is_mask, folder }),
            Err(source) => Err(FieldError::Temporary { dir: folder, bytes: layout.bytes, source }),
        }
    }

    /// Reads a window of the band, and writes it to the file. Takes the window's bytes.
    pub(super) fn fill(&self, band: &Band, unit: Window) -> Result<(), FieldError> {
        let unit_bytes = unit.len() * self.layout.sample_bytes;
        let mut words = vec![0u64; unit_bytes.div_ceil(8)];
        let read = &mut bytemuck::cast_slice_mut(&mut words)[..unit_bytes];
        if self.is_mask {
            band.read_mask(unit, read)?
        } else {
            band.read(unit, read)?
        }
        write_unit(&self.file, self.layout, unit, read).map_err(|source| self.failed(source))
    }

    /// The file, mapped. What is filled later is seen, too.
    pub(super) fn mapped(&self) -> Result<Store, FieldError> {
        let (file, layout) = (&self.file, self.layout);
        let bytes = file.try_clone().and_then(|clone| Ok(Bytes::Mapped(map(file)?, clone)));
        Ok(Store {
            bytes: bytes.map_err(|source| self.failed(source))?,
            block_width: layout.block_width,
            block_height: layout.block_height,
            blocks_across: layout.blocks_across,
            offsets: Offsets::Regular,
            sample_bytes: layout.sample_bytes,
            first: (0, 0),
        })
    }

    fn failed(&self, source: std::io::Error) -> FieldError {
        FieldError::Temporary { dir: self.folder.clone(), bytes: self.layout.bytes, source }
    }
}

/// What decoding leaves: files already unlinked.
pub(super) struct Decoded {
    pub(super) samples: Store,
    /// A byte for every sample, where the raster has a mask.
    pub(super) mask: Option<Store>,
}

/// Decodes all samples, in parallel, and the mask beside them.
pub(super) fn decode(band: &Band, folder: &Path, control: &Control<'_>) -> Result<Decoded, FieldError> {
    let samples = Decoding::new(band, false, folder)?;
    let mask = band.has_mask().then(|| Decoding::new(band, true, folder)).transpose()?;

    let units = units(band);
    control.progress.begin(Stage::Decode, units.len() as u64, band.width() as u64 * band.height() as u64);
    units.par_iter().try_for_each(|&unit| {
        control.cancel.check()?;
        faults::reach(Point::DecodeUnit);
        samples.fill(band, unit)?;
        mask.iter().try_for_each(|mask| mask.fill(band, unit))?;
        control.progress.step(Stage::Decode, unit.len() as u64);
        Ok::<(), FieldError>(())
    })?;
    control.progress.end(Stage::Decode);
    // Nothing is read any more.
    band.release();
    Ok(Decoded { samples: samples.mapped()?, mask: mask.map(|mask| mask.mapped()).transpose()? })
}

/// Windows that together are the raster. Whole blocks of the source as far as [`UNIT_BYTES`] allow; where one row of
/// blocks is more than that, columns of blocks, or, in strips, as many whole strips as fit and at least one.
pub(super) fn units(band: &Band) -> Vec<Window> {
    windows_of((band.width(), band.height()), band.block_size(), band.sample_type().bytes())
}

/// Samples across and down in each of [`units`], but for the last ones.
pub(super) fn unit_size(band: &Band) -> (usize, usize) {
    size_of_units((band.width(), band.height()), band.block_size(), band.sample_type().bytes())
}

fn size_of_units(
    (raster_width, raster_height): (usize, usize),
    (block_width, block_height): (usize, usize),
    sample_bytes: usize,
) -> (usize, usize) {
    let most = (UNIT_BYTES / sample_bytes).max(1);
    let fitting = |side: usize, other: usize, whole: usize| {
        let blocks = (most / other / side).max(1);
        (blocks * side).min(whole)
    };
    let width = fitting(block_width, block_height, raster_width);
    let rows = fitting(block_height, width, raster_height);
    // One block larger than a unit is read in parts; GDAL keeps it decoded.
    let rows = if rows * width > most && block_height > 1 { (most / width).max(1) } else { rows };
    (width, rows)
}

/// The units of a raster of this size in blocks of this size, where a unit takes `sample_bytes` for each sample.
pub(super) fn windows_of(size: (usize, usize), block: (usize, usize), sample_bytes: usize) -> Vec<Window> {
    let ((raster_width, raster_height), (width, rows)) = (size, size_of_units(size, block, sample_bytes));
    let mut units = Vec::new();
    for row in (0..raster_height).step_by(rows) {
        for column in (0..raster_width).step_by(width) {
            let width = width.min(raster_width - column);
            units.push(Window { column, row, width, height: rows.min(raster_height - row) });
        }
    }
    units
}

/// Writes a window's samples to their blocks. Only the window's own samples are written: other threads write their
/// neighbours in the same blocks at the same time.
fn write_unit(file: &File, layout: Layout, unit: Window, samples: &[u8]) -> std::io::Result<()> {
    let Layout { width, block_width, block_height, blocks_across, sample_bytes, .. } = layout;
    let row_bytes = unit.width * sample_bytes;
    let mut block = vec![0u8; block_width * block_height * sample_bytes];
    for block_row in unit.row / block_height..(unit.row + unit.height).div_ceil(block_height) {
        for block_column in unit.column / block_width..(unit.column + unit.width).div_ceil(block_width) {
            let (left, top) = (block_column * block_width, block_row * block_height);
            let columns = left.max(unit.column)..(left + block_width).min(unit.column + unit.width);
            let rows = top.max(unit.row)..(top + block_height).min(unit.row + unit.height);
            let start = (block_row * blocks_across + block_column) * block.len();
            let run = columns.len() * sample_bytes;
            let place = |row: usize| ((row - top) * block_width + columns.start - left) * sample_bytes;
            for row in rows.clone() {
                let from = (row - unit.row) * row_bytes + (columns.start - unit.column) * sample_bytes;
                block[place(row)..place(row) + run].copy_from_slice(&samples[from..from + run]);
            }
            let whole_rows = columns.start == left && columns.end == (left + block_width).min(width);
            if whole_rows {
                // Nothing between these rows is anyone else's: one write for all of them.
                let (first, last) = (place(rows.start), place(rows.end - 1) + run);
                file.write_all_at(&block[first..last], (start + first) as u64)?;
            } else {
                for row in rows {
                    file.write_all_at(&block[place(row)..place(row) + run], (start + place(row)) as u64)?;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Tile;
    use crate::field::{Choice, Field, FieldOptions};
    use crate::raster::Raster;
    use gdal::raster::{Buffer, RasterCreationOptions};

    /// Source blocks whose sides are no multiples of the file's, and units that end inside the file's blocks.
    #[test]
    fn every_sample_is_where_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        for (width, height, tile) in [(700, 90, 80), (1100, 300, 1040), (500, 400, 16), (3, 3000, 16), (3000, 2, 0)] {
            let path = folder.path().join(format!("{width}x{height}.tif"));
            let tile = tile.to_string();
            let mut options = RasterCreationOptions::new();
            options.set_name_value("COMPRESS", "DEFLATE").expect("an option");
            if tile != "0" {
                for (name, value) in [("TILED", "YES"), ("BLOCKXSIZE", &tile), ("BLOCKYSIZE", &tile)] {
                    options.set_name_value(name, value).expect("an option");
                }
            }
            let driver = gdal::DriverManager::get_driver_by_name("GTiff").expect("GTiff");
            let made = driver.create_with_band_type_with_options::<f64, _>(&path, width, height, 1, &options);
            let made = made.expect("a raster");
            let heights: Vec<f64> = (0..width * height).map(|i| i as f64).collect();
            let mut buffer = Buffer::new((width, height), heights.clone());
            made.rasterband(1).expect("a band").write((0, 0), (width, height), &mut buffer).expect("written");
            made.close().expect("closed");

            let band = Raster::open(&path, 1).and_then(|r| r.to_band()).expect("a raster");
            let options = FieldOptions { choice: Choice::Decode, ..FieldOptions::default() };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads");
            let field = pool.install(move || Field::open(&band, &options, &Control::default())).expect("a field");
            let mut tile = Tile::default();
            field.load(Window { column: 0, row: 0, width, height }, &mut tile).expect("heights");
            for (i, &height) in heights.iter().enumerate() {
                assert_eq!(tile.at(i % width, i / width), height, "sample {i} of {width} × {height}");
            }
        }
    }
}
