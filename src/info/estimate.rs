use serde::Serialize;

use crate::raster::SampleType;

/// How dense a mesh the estimate assumes. What it will be is known only after the run: 5 to 20 where the tolerance is
/// tight, several hundred where it is wide or the ground is smooth.
pub const SAMPLES_PER_TRIANGLE: u64 = 80;

/// A chunk stores three references to vertices and half a vertex per triangle.
const SPOOL_BYTES_PER_TRIANGLE: u64 = 20;
/// A face of a PLY file is 13 bytes, and there is half a vertex of 24 bytes to it.
const OUTPUT_BYTES_PER_TRIANGLE: u64 = 25;
/// A tile at work: its samples as doubles, the grids over them, the front and the mesh.
const TILE_BYTES_PER_SAMPLE: u64 = 32;
/// The side of a tile the estimate assumes, in samples.
const TILE_SIDE: u64 = 513;
/// GDAL's block cache, buffers, the program.
const FIXED_BYTES: u64 = 64 << 20;

/// What a run of `simplify` will need, in bytes. A rough figure, meant to tell megabytes from gigabytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Estimate {
    /// Temporary disk for the decoded height field; 0 where the raster is mapped in place.
    pub field_bytes: u64,
    /// Temporary disk for finished tiles, at [`SAMPLES_PER_TRIANGLE`].
    pub spool_bytes: u64,
    /// The output file, at [`SAMPLES_PER_TRIANGLE`].
    pub output_bytes: u64,
    /// Memory, for `threads` threads. It does not grow with the raster.
    pub memory_bytes: u64,
    /// The density assumed.
    pub samples_per_triangle: u64,
    /// The number of threads assumed.
    pub threads: usize,
}

/// Estimates a run over `width` × `height` samples.
pub fn estimate(
    width: usize,
    height: usize,
    sample_type: SampleType,
    mapped_in_place: bool,
    threads: usize,
) -> Estimate {
    let samples = width as u64 * height as u64;
    let triangles = samples.div_ceil(SAMPLES_PER_TRIANGLE);
    Estimate {
        field_bytes: if mapped_in_place { 0 } else { samples * sample_type.bytes() as u64 },
        spool_bytes: triangles * SPOOL_BYTES_PER_TRIANGLE,
        output_bytes: triangles * OUTPUT_BYTES_PER_TRIANGLE,
        memory_bytes: FIXED_BYTES + threads as u64 * TILE_SIDE * TILE_SIDE * TILE_BYTES_PER_SAMPLE,
        samples_per_triangle: SAMPLES_PER_TRIANGLE,
        threads,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disk_follows_the_raster_and_memory_does_not() {
        let small = estimate(1000, 800, SampleType::I16, false, 4);
        assert_eq!((small.field_bytes, small.spool_bytes, small.output_bytes), (1_600_000, 200_000, 250_000));
        let vast = estimate(1_000_000, 1_000_000, SampleType::F32, true, 4);
        assert_eq!((vast.field_bytes, vast.spool_bytes), (0, 250_000_000_000));
        assert_eq!(vast.memory_bytes, small.memory_bytes);
    }
}
