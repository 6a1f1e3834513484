//! Points of a vector layer, as samples of a raster.
//!
//! In come a point layer of any format OGR reads and a raster; out goes a [`PointSet`]: the samples nearest to the points,
//! sorted, each once. `read` takes points from features, `place` finds their samples, `set` keeps them and finds those
//! in a window.

mod error;
mod place;
mod read;
mod set;

pub use error::PointsError;
pub use read::{PointCounts, PointSource, Points, read_points};
pub use set::PointSet;

#[cfg(test)]
mod tests;
