//! Decoding a raster into a temporary file of square blocks.

use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::Path;

use rayon::prelude::*;

use super::map::map;
use super::store::{Bytes, Offsets, Store};
use super::windows::refuse_masked;
use super::{FieldError, FieldOptions};
use crate::control::{Control, Stage};
use crate::faults::{self, Point};
use crate::raster::{Raster, Window};

/// Samples along one side of a block of the temporary file: small enough that a tile touches few pages it does not
/// need, large enough that a run is worth a copy.
const BLOCK: usize = 256;

/// The most samples one thread reads at a time, unless one block of the source alone is larger.
const UNIT_SAMPLES: usize = 1 << 22;

/// The temporary file's shape.
#[derive(Clone, Copy)]
struct Layout {
    blocks_across: usize,
    sample_bytes: usize,
    bytes: u64,
}

impl Layout {
    fn of(raster: &Raster) -> Layout {
        let blocks_across = raster.width().div_ceil(BLOCK);
        let sample_bytes = raster.sample_type().bytes();
        let blocks = blocks_across as u64 * raster.height().div_ceil(BLOCK) as u64;
        Layout { blocks_across, sample_bytes, bytes: blocks * (BLOCK * BLOCK * sample_bytes) as u64 }
    }
}

/// How many bytes the temporary file of a raster takes.
pub fn decoded_bytes(raster: &Raster) -> u64 {
    Layout::of(raster).bytes
}

/// Decodes all samples, in parallel; returns them mapped, and the size of the file (already unlinked).
pub(super) fn decode(
    raster: &Raster,
    options: &FieldOptions,
    control: &Control<'_>,
) -> Result<(Store, u64), FieldError> {
    let layout = Layout::of(raster);
    let failed = |source| FieldError::Temporary { dir: options.temp_dir.clone(), bytes: layout.bytes, source };
    let file = tempfile::tempfile_in(&options.temp_dir).map_err(failed)?;
    file.set_len(layout.bytes).map_err(failed)?;

    let masked = raster.has_mask()?;
    let units = units(raster);
    let (path, band) = (raster.path(), raster.band());
    control.progress.begin(Stage::Decode, units.len() as u64, raster.width() as u64 * raster.height() as u64);
    units.par_iter().try_for_each_init(Reader::default, |reader, &unit| {
        control.cancel.check()?;
        faults::reach(Point::DecodeUnit);
        let source = reader.open(path, band)?;
        let mut words = vec![0u64; (unit.len() * layout.sample_bytes).div_ceil(8)];
        let samples = &mut bytemuck::cast_slice_mut(&mut words)[..unit.len() * layout.sample_bytes];
        source.read_native(unit, samples)?;
        if masked {
            refuse_masked(source, unit)?;
        }
        write_unit(&file, layout, unit, samples).map_err(failed)?;
        control.progress.step(Stage::Decode, unit.len() as u64);
        Ok::<(), FieldError>(())
    })?;
    control.progress.end(Stage::Decode);

    let bytes = Bytes::Mapped(map(&file).map_err(failed)?, file);
    let store = Store {
        bytes,
        block_width: BLOCK,
        block_height: BLOCK,
        blocks_across: layout.blocks_across,
        offsets: Offsets::Regular,
        sample_bytes: layout.sample_bytes,
    };
    Ok((store, layout.bytes))
}

/// A thread's own handle of the raster, opened when first needed: GDAL's datasets serve one thread at a time.
#[derive(Default)]
struct Reader(Option<Raster>);

impl Reader {
    fn open(&mut self, path: &Path, band: usize) -> Result<&Raster, FieldError> {
        let own = match self.0.take() {
            Some(own) => own,
            None => Raster::open(path, band)?,
        };
        Ok(self.0.insert(own))
    }
}

/// Windows that together are the raster, none of which cuts a source block where that can be helped.
fn units(raster: &Raster) -> Vec<Window> {
    let (block_width, block_height) = raster.block_size();
    let stripped = block_width >= raster.width();
    let unit_height = if block_height >= BLOCK { block_height } else { BLOCK.next_multiple_of(block_height) };
    let unit_width = if stripped {
        raster.width()
    } else {
        (UNIT_SAMPLES / unit_height).max(block_width).next_multiple_of(block_width)
    };
    // Wide strips, or one strip for the whole raster: fewer rows at a time; GDAL keeps the block.
    let rows = unit_height.min((UNIT_SAMPLES / unit_width.min(raster.width())).max(1));
    let mut units = Vec::new();
    for row in (0..raster.height()).step_by(rows) {
        for column in (0..raster.width()).step_by(unit_width) {
            let width = unit_width.min(raster.width() - column);
            units.push(Window { column, row, width, height: rows.min(raster.height() - row) });
        }
    }
    units
}

/// Writes a window's samples to their blocks, one run after the other.
fn write_unit(file: &File, layout: Layout, unit: Window, samples: &[u8]) -> std::io::Result<()> {
    let row_bytes = unit.width * layout.sample_bytes;
    let mut block = vec![0u8; BLOCK * BLOCK * layout.sample_bytes];
    for block_row in unit.row / BLOCK..(unit.row + unit.height).div_ceil(BLOCK) {
        for block_column in unit.column / BLOCK..(unit.column + unit.width).div_ceil(BLOCK) {
            let (left, top) = (block_column * BLOCK, block_row * BLOCK);
            let columns = left.max(unit.column)..(left + BLOCK).min(unit.column + unit.width);
            let rows = top.max(unit.row)..(top + BLOCK).min(unit.row + unit.height);
            let start =
                ((block_row * layout.blocks_across + block_column) * BLOCK * BLOCK * layout.sample_bytes) as u64;
            let run = columns.len() * layout.sample_bytes;
            let place = |row: usize| ((row - top) * BLOCK + columns.start - left) * layout.sample_bytes;
            for row in rows.clone() {
                let from = (row - unit.row) * row_bytes + (columns.start - unit.column) * layout.sample_bytes;
                block[place(row)..place(row) + run].copy_from_slice(&samples[from..from + run]);
            }
            if columns.start == left && columns.len() == BLOCK.min(unit.column + unit.width - left) {
                // The unit has the block's rows from their first column on: one write for all of them.
                let (first, last) = (place(rows.start), place(rows.end - 1) + run);
                file.write_all_at(&block[first..last], start + first as u64)?;
            } else {
                for row in rows {
                    file.write_all_at(&block[place(row)..place(row) + run], start + place(row) as u64)?;
                }
            }
        }
    }
    Ok(())
}
