//! Using an uncompressed GeoTIFF where it lies.

use super::map::map;
use super::store::{Bytes, Offsets, Store};
use crate::base::{Band, PlainLayout, Window};

/// Maps the raster's own file, and makes sure by reading that the samples are where the layout says.
pub(super) fn map_in_place(band: &Band, layout: PlainLayout) -> Result<Store, String> {
    let file = std::fs::File::open(&layout.file).map_err(|e| e.to_string())?;
    let mapped = map(&file).map_err(|e| format!("it cannot be mapped: {e}"))?;
    let sample_bytes = band.sample_type().bytes();
    let (width, height) = layout.whole;
    let tiled = layout.block_width != width;
    for (index, &offset) in layout.offsets.iter().enumerate() {
        let left = height - (index / layout.blocks_across) * layout.block_height;
        let rows = if tiled { layout.block_height } else { layout.block_height.min(left) };
        let end = offset.checked_add((layout.block_width * rows * sample_bytes) as u64);
        if end.is_none_or(|end| end > mapped.len() as u64) {
            return Err(format!("its block {index} reaches beyond the end of the file: it is truncated"));
        }
    }
    let store = Store {
        bytes: Bytes::Mapped(mapped, file),
        block_width: layout.block_width,
        block_height: layout.block_height,
        blocks_across: layout.blocks_across,
        offsets: Offsets::Table(layout.offsets),
        sample_bytes,
        first: layout.first,
    };
    agrees_with_reader(band, &store)?;
    Ok(store)
}

/// Compares the first and the last row of samples with what is read by windows.
fn agrees_with_reader(band: &Band, store: &Store) -> Result<(), String> {
    let sample_bytes = store.sample_bytes;
    let width = band.width().min(4096);
    for (column, row) in [(0, 0), (band.width() - width, band.height() - 1)] {
        let window = Window { column, row, width, height: 1 };
        let mut words = vec![0u64; (width * sample_bytes).div_ceil(8)];
        let expected = &mut bytemuck::cast_slice_mut(&mut words)[..width * sample_bytes];
        band.read(window, expected).map_err(|e| e.to_string())?;
        store.for_each_run(window, |_, column, bytes| {
            let at = column * sample_bytes;
            let same = expected[at..at + bytes.len()] == *bytes;
            if same { Ok(()) } else { Err(format!("its samples in row {row} are not stored as they are")) }
        })?;
    }
    Ok(())
}
