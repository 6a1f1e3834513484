use serde::Serialize;

use crate::field::{decoded_bytes, suits_windows};
use crate::raster::{Raster, plain_layout};

/// How dense a mesh the estimate assumes where no tolerance is known. What it will be is known only after the run: 5 to
/// 20 where the tolerance is tight, several hundred where it is wide or the ground is smooth.
pub const SAMPLES_PER_TRIANGLE: f64 = 80.0;

/// Samples per triangle where every sample is a vertex: no mesh is denser.
pub const DENSEST: f64 = 0.5;

/// A chunk stores three references to vertices and half a vertex per triangle.
const SPOOL_BYTES_PER_TRIANGLE: f64 = 20.0;
/// A face of a PLY file is 13 bytes, and there is half a vertex of 24 bytes to it.
const OUTPUT_BYTES_PER_TRIANGLE: f64 = 25.0;

/// The disk that a run of `simplify` will need, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Temporary disk for decoded samples and weights, exactly; 0 where nothing is decoded beforehand.
    pub field_bytes: u64,
    /// Temporary disk for finished tiles, at `samples_per_triangle`.
    pub spool_bytes: u64,
    /// The output file, at `samples_per_triangle`.
    pub output_bytes: u64,
    /// The density assumed, or found at a few tiles.
    pub samples_per_triangle: f64,
}

/// Estimates a run over a raster, and its importance raster where it has one, that will have so many samples per triangle.
pub fn estimate(raster: &Raster, importance: Option<&Raster>, samples_per_triangle: f64) -> Estimate {
    let samples = raster.width() as f64 * raster.height() as f64;
    let triangles = samples / samples_per_triangle;
    Estimate {
        field_bytes: field_bytes(raster) + importance.map_or(0, field_bytes),
        spool_bytes: (triangles * SPOOL_BYTES_PER_TRIANGLE) as u64,
        output_bytes: (triangles * OUTPUT_BYTES_PER_TRIANGLE) as u64,
        samples_per_triangle,
    }
}

fn field_bytes(raster: &Raster) -> u64 {
    let in_use_as_it_is = suits_windows(raster) || plain_layout(raster).is_ok();
    if in_use_as_it_is { 0 } else { decoded_bytes(raster) }
}
