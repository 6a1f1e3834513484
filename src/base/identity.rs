//! What a raster is recognised by, between two runs of one job.

use super::{Band, Mark, Marks, RasterError};
use crate::base::Window;
use crate::base::decimal::Decimal;

/// The places whose samples are read, spread evenly over the rows, the first and the last among them.
const PLACES: usize = 64;

/// The same where each costs a block or two that are fetched from another machine.
const REMOTE_PLACES: usize = 8;

/// What the checksum of samples is called.
pub const SOME_SAMPLES: &str = "checksum of some samples";

/// The samples read at one place, along a row.
const RUN: usize = 1024;

/// The same where they come from another machine.
const REMOTE_RUN: usize = 64;

/// What a raster is recognised by, whatever its file is called and wherever it lies: names and values for people to
/// compare. Equal doubles are told by their bits.
///
/// Size, band, sample type, geotransform, nodata, scale and offset are those that decide a mesh; a checksum of some of
/// the samples tells rasters apart that agree in all of them, as mosaics of one survey do. It is no proof that all
/// samples are equal; who needs that compares tile by tile ([`crate::base::Tile::checksum`]).
///
/// Cost: 64 windows of 1024 × 1 samples are read (8 of 64 × 1 where the raster is on another machine), at most 64 × (1024 / block width + 2) blocks are decoded.
///
/// # Errors
/// [`RasterError::Read`].
pub fn identity(raster: &Band) -> Result<Vec<(&'static str, String)>, RasterError> {
    let scaling = raster.scaling();
    let nodata = raster.tag().map_or("none".to_string(), exact_mark);
    let mut named = vec![
        ("size", format!("{} × {} samples", raster.width(), raster.height())),
        ("band", raster.number().to_string()),
        ("sample type", raster.sample_type().name().to_string()),
        ("geotransform", raster.geo_transform().coefficients().map(exact_double).join(", ")),
        ("nodata", nodata),
        ("scale", exact_double(scaling.scale)),
        ("offset", exact_double(scaling.offset)),
        (SOME_SAMPLES, format!("{:08x}", some_samples(raster)?)),
    ];
    named.extend(raster.view.iter().cloned());
    Ok(named)
}

/// What was said of the heights of a band, beside what [`identity`] tells: marks and a cutline.
pub fn said(band: &Band) -> Vec<(&'static str, String)> {
    let nodata = band.marks_are_said.then(|| ("nodata", exact_marks(band.marks())));
    let cutline = band.cutline().map(|c| ("cutline", format!("polygons with checksum {:08x}", c.checksum())));
    nodata.into_iter().chain(cutline).collect()
}

fn exact_mark(mark: Mark) -> String {
    match mark {
        Mark::Real(value) => exact_double(value),
        Mark::I64(value) => value.to_string(),
        Mark::U64(value) => value.to_string(),
    }
}

/// What counts as missing where the caller says so, exactly, for what identifies a job.
fn exact_marks(marks: &Marks) -> String {
    let values: Vec<String> = marks.values.iter().map(|mark| exact_mark(*mark)).collect();
    let valid = marks.valid.map(|v| format!("heights from {} to {}", exact_double(v.min), exact_double(v.max)));
    values.into_iter().chain(valid).collect::<Vec<_>>().join(", ")
}

/// A double as people read it, and its bits.
pub fn exact_double(value: f64) -> String {
    format!("{}{BITS}{:016x})", Decimal(value), value.to_bits())
}

/// What stands between a double and its bits.
const BITS: &str = " (bits ";

/// A text without what [`exact_double`] adds to doubles.
pub fn without_bits(text: &str) -> String {
    let mut parts = text.split(BITS);
    let mut plain = parts.next().unwrap_or_default().to_string();
    parts.for_each(|part| plain.push_str(part.split_once(')').map_or(part, |(_, after)| after)));
    plain
}

fn some_samples(raster: &Band) -> Result<u32, RasterError> {
    let (places, run) = if raster.is_remote() { (REMOTE_PLACES, REMOTE_RUN) } else { (PLACES, RUN) };
    let (width, height, places) = (raster.width().min(run), 1, raster.height().min(places));
    let bytes = width * raster.sample_type().bytes();
    let mut words = vec![0u64; bytes.div_ceil(8)];
    let mut hasher = crc32fast::Hasher::new();
    for place in 0..places {
        let row = place * (raster.height() - 1) / (places - 1);
        // Columns far from those of the place before: 5/8 of the way on, around the end.
        let column = (raster.width() - width) * (place * 5 % 8) / 7;
        let samples = &mut bytemuck::cast_slice_mut(&mut words)[..bytes];
        raster.read(Window { column, row, width, height }, samples)?;
        hasher.update(samples);
    }
    Ok(hasher.finalize())
}
