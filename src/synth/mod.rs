//! Terrain out of nothing: fractal rasters of any size, for trying and measuring everything else.
//!
//! In come a seed and a few numbers, out goes the height at any (column, row): a pure function in additions,
//! multiplications, divisions, square roots and floors of doubles over hashes of integers, so that every machine,
//! thread count and window gives the same bits. [`synth`] streams it into a GeoTIFF; [`Terrain`] fills buffers.

mod erosion;
mod error;
mod faults;
mod gaps;
mod hash;
mod lakes;
mod landscape;
mod noise;
mod options;
mod patch;
mod spline;
mod terrain;
#[cfg(feature = "gdal")]
mod write;

pub use error::SynthError;
pub use options::{BlockLayout, Compression, OptionError, StoredAs, SynthOptions, TerrainOptions};
pub use terrain::Terrain;
#[cfg(feature = "gdal")]
pub use write::{SynthReport, synth};

#[cfg(test)]
mod tests;
