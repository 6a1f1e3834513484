//! Points of a vector layer, as samples of a raster.
//!
//! In come a point layer of any format OGR reads and a raster; out goes a [`crate::base::PointSet`]: the samples nearest to the points,
//! sorted, each once. `read` takes points from features, `place` finds their samples.

mod error;
mod place;
mod read;

pub use error::PointsError;
pub use read::{PointSource, Points, read_points};

#[cfg(test)]
mod tests;
