//! Where the samples of an uncompressed GeoTIFF lie in its file.

use gdal::Metadata;

use super::Raster;
use crate::base::PlainLayout;

/// No block of a TIFF begins before.
const HEADER_BYTES: u64 = 8;

/// Finds the blocks of a raster, or says why it cannot be used in place and has to be decoded.
///
/// # Errors
/// The reason, as the end of the sentence "is decoded: …".
pub(super) fn plain_layout(raster: &Raster) -> Result<PlainLayout, String> {
    let driver = raster.driver();
    if driver != "GTiff" {
        return Err(format!("its format is {driver}, only GeoTIFF is mapped"));
    }
    let file = raster.path().to_path_buf();
    if !file.is_file() {
        return Err("it is not a plain file".to_string());
    }
    native_byte_order(&file)?;
    if has_bits_reversed(&file).map_err(|e| e.to_string())? {
        return Err("the bits of its bytes are in reverse order (FillOrder)".to_string());
    }
    let band = raster.rasterband().map_err(|e| e.to_string())?;
    if let Some(compression) = raster.compression() {
        return Err(format!("it is compressed ({compression})"));
    }
    if let Some(bits) = band.metadata_item("NBITS", "IMAGE_STRUCTURE") {
        return Err(format!("its samples are packed ({bits} bits)"));
    }
    if raster.dataset.raster_count() > 1
        && raster.dataset.metadata_item("INTERLEAVE", "IMAGE_STRUCTURE").is_none_or(|v| v != "BAND")
    {
        return Err("its bands are interleaved by pixel".to_string());
    }
    if raster.has_mask().map_err(|e| e.to_string())? {
        return Err("it has a mask or alpha band".to_string());
    }
    let (block_width, block_height) = band.block_size();
    let (width, height) = raster.whole_size();
    let (across, down) = (width.div_ceil(block_width), height.div_ceil(block_height));
    // Grows as blocks are found: a file may claim any size.
    let mut offsets = Vec::new();
    for y in 0..down {
        for x in 0..across {
            let item =
                |name| band.metadata_item(&format!("BLOCK_{name}_{x}_{y}"), "TIFF").and_then(|v| v.parse::<u64>().ok());
            let (Some(offset), Some(size)) = (item("OFFSET"), item("SIZE")) else {
                return Err(format!("its block {x}, {y} is sparse (not in the file)"));
            };
            // Of a damaged file GDAL tells 0 when it is asked once more, where it told nothing before.
            if offset < HEADER_BYTES {
                return Err(format!("its block {x}, {y} lies in the header"));
            }
            let tiled = block_width != width;
            let rows = if tiled { block_height } else { block_height.min(height - y * block_height) };
            let expected = (block_width * rows * raster.sample_type().bytes()) as u64;
            if size < expected {
                return Err(format!("its block {x}, {y} has {size} bytes where {expected} are expected"));
            }
            offsets.push(offset);
        }
    }
    let first = raster.window().map_or((0, 0), |w| (w.column, w.row));
    Ok(PlainLayout { file, whole: (width, height), first, block_width, block_height, blocks_across: across, offsets })
}

/// The first two bytes of a TIFF name its byte order.
fn native_byte_order(file: &std::path::Path) -> Result<(), String> {
    use std::io::Read;
    let mut mark = [0u8; 2];
    std::fs::File::open(file).and_then(|mut f| f.read_exact(&mut mark)).map_err(|e| e.to_string())?;
    let native = if cfg!(target_endian = "little") { *b"II" } else { *b"MM" };
    if mark == native { Ok(()) } else { Err("its byte order is not this machine's".to_string()) }
}

/// Whether the first directory says that bytes begin with their lowest bit: GDAL turns them around when it reads, and
/// has no metadata that tells. The byte order is the machine's.
fn has_bits_reversed(file: &std::path::Path) -> std::io::Result<bool> {
    use std::os::unix::fs::FileExt;
    const FILL_ORDER: u64 = 266;
    let file = std::fs::File::open(file)?;
    let half = |at: u64| {
        let mut bytes = [0; 2];
        file.read_exact_at(&mut bytes, at).map(|()| u64::from(u16::from_ne_bytes(bytes)))
    };
    let word = |at: u64| {
        let mut bytes = [0; 4];
        file.read_exact_at(&mut bytes, at).map(|()| u64::from(u32::from_ne_bytes(bytes)))
    };
    let long = |at: u64| {
        let mut bytes = [0; 8];
        file.read_exact_at(&mut bytes, at).map(|()| u64::from_ne_bytes(bytes))
    };
    let is_big = half(2)? == 43;
    let directory = if is_big { long(8)? } else { word(4)? };
    let (count, first, length, value) =
        if is_big { (long(directory)?, 8, 20, 12) } else { (half(directory)?, 2, 12, 8) };
    for entry in 0..count {
        let at = directory.saturating_add(first).saturating_add(entry.saturating_mul(length));
        if half(at)? == FILL_ORDER && half(at.saturating_add(value))? != 1 {
            return Ok(true);
        }
    }
    Ok(false)
}
