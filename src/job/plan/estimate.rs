//! The disk that a run will need, from its raster's size and the density of its mesh.

use serde::Serialize;

use crate::base::Band;
use crate::field::{decoded_bytes, suits_windows};
use crate::formats::Format;

/// How dense a mesh the estimate assumes where no tolerance is known. What it will be is known only after the run: 5 to
/// 20 where the tolerance is tight, several hundred where it is wide or the ground is smooth.
pub const SAMPLES_PER_TRIANGLE: f64 = 80.0;

/// Samples per triangle where every sample is a vertex: no mesh is denser.
pub const DENSEST: f64 = 0.5;

/// A chunk stores three references to vertices and half a vertex per triangle.
const SPOOL_BYTES_PER_TRIANGLE: f64 = 20.0;

/// The disk that a run of `simplify` will need, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Temporary disk for decoded samples and weights, exactly; 0 where nothing is decoded beforehand.
    pub field_bytes: u64,
    /// Temporary disk for finished tiles, at `samples_per_triangle`; before [`Estimate::with_tiles`] for one pass over them.
    pub spool_bytes: u64,
    /// Temporary disk for what tiles tell of their insertions; 0 where no budget or root mean square ends the run.
    pub survey_bytes: u64,
    /// The output file, at `samples_per_triangle`.
    pub output_bytes: u64,
    /// The density assumed, or found at a few tiles.
    pub samples_per_triangle: f64,
}

/// What a channel adds to a chunk, for half a vertex per triangle.
const SPOOL_BYTES_PER_CHANNEL: f64 = 4.0;

/// What a chunk has for its tile, however few triangles there are: how errors are distributed, and angles. Measured 3.1 to
/// 3.3 KiB.
const SPOOL_BYTES_PER_TILE: u64 = 3200;

impl Estimate {
    /// The same run with this number of tiles, where chunks of this number of passes are kept at a time.
    pub fn with_tiles(self, tiles: u64, passes: u64) -> Estimate {
        let once = self.spool_bytes.saturating_add(tiles.saturating_mul(SPOOL_BYTES_PER_TILE));
        Estimate { spool_bytes: once.saturating_mul(passes), ..self }
    }

    /// The same run, into a file of this format, with these bands as channels; without the heights, if the raster is a planar
    /// image.
    pub fn with_channels(self, channels: &[Band], planar: bool, format: &Format) -> Estimate {
        let field_bytes = if planar { 0 } else { self.field_bytes };
        channels.iter().fold(Estimate { field_bytes, ..self }, |sum, band| {
            let of_band = estimate(band, None, self.samples_per_triangle, format);
            let triangles = band.width() as f64 * band.height() as f64 / self.samples_per_triangle;
            Estimate {
                field_bytes: sum.field_bytes.saturating_add(of_band.field_bytes),
                spool_bytes: sum.spool_bytes.saturating_add((triangles * SPOOL_BYTES_PER_CHANNEL) as u64),
                output_bytes: sum.output_bytes.saturating_add((triangles * format.bytes.attribute / 2.0) as u64),
                ..sum
            }
        })
    }
}

/// Estimates a run over a raster, and its importance raster where it has one, that will have so many samples per triangle in a
/// file of this format.
pub fn estimate(band: &Band, importance: Option<&Band>, samples_per_triangle: f64, format: &Format) -> Estimate {
    let samples = band.samples() as f64;
    let triangles = samples / samples_per_triangle;
    Estimate {
        field_bytes: field_bytes(band).saturating_add(importance.map_or(0, field_bytes)),
        spool_bytes: (triangles * SPOOL_BYTES_PER_TRIANGLE) as u64,
        survey_bytes: 0,
        output_bytes: (triangles * format.bytes.per_triangle()) as u64,
        samples_per_triangle,
    }
}

fn field_bytes(band: &Band) -> u64 {
    let in_use_as_it_is = suits_windows(band) || band.plain_layout().is_ok();
    if in_use_as_it_is { 0 } else { decoded_bytes(band) }
}
