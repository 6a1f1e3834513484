//! The samples of the raster itself, where tiles have to be within their errors at those, too.
//!
//! `store` keeps them by blocks of the finest grid, `sides` gives the sides of tiles vertices for those that lie on or near their line,
//! `near` looks for the samples under triangles, and `relief` knows how high they are. In come a raster and its samples on the grid; whoever
//! has the store needs no raster.
//!
//! **Which count.** Those with samples of the grid all around them, as [`crate::tiles_verify`] has it, or on a line of the grid
//! between two: elsewhere the surface runs down to the height outside.
//!
//! **Vertices.** A sample that is farther from the surface than a level allows becomes a vertex at the nearest place of the format's lattice,
//! with the height of the sample. The raster's bilinear surface has all samples, its own and those of the grid, so there is a mesh
//! within any error but for that rounding: of places by half a step, which takes half a step times the ground's slope. Steps and
//! errors double from level to level together, so what is left of an error is the same share of it at every level.

mod near;
mod relief;
mod sides;
mod store;
#[cfg(test)]
mod tests;

pub(super) use near::{DOUBT, OwnWindow, OwnWindows, Placed};
pub(super) use relief::{relief, widen};
pub(super) use sides::{Along, OnLine, OnSide, refine};
pub(super) use store::{OwnStore, WINDOW};

use super::quantize::SPAN;

/// How far beyond a line of the grid a sample may be and count as on it, in cells; whoever verifies takes half of that.
const ROUNDING: f64 = 2e-6;

/// How far from a side samples bind it, in steps of the lattice: vertices inside are off their places by up to half a step each way, so
/// that a side which is off there would be felt.
const BAND_STEPS: f64 = 2.0;

/// The same in cells, where the lattice is much finer than the grid: the surface beside a side then has room to go from one height to the other.
const BAND_CELLS: f64 = 0.125;

/// How far from a line samples bind a side on it, in cells.
pub(super) fn band(tile_cells: i64) -> f64 {
    BAND_CELLS.max(BAND_STEPS * tile_cells as f64 / SPAN as f64)
}
