//! Seams: the vertices on the line between two tiles, fixed before either tile is triangulated.
//!
//! In come the samples of one side of a tile, a tolerance, and vertices the side must have; out comes the polyline with
//! the fewest links whose every sample is within the tolerance ([`MinLink`]), and with channels also their weighted error
//! ([`WeightedLine`]). It is a function of these samples alone,
//! so both neighbours compute the same one without talking. [`Rim`] puts the four sides of a tile together and says
//! which vertices the tile owns.

mod min_link;
mod rim;
mod weighted;

pub use min_link::MinLink;
pub use rim::{Foreign, Rim, RimCounts};
pub use weighted::WeightedLine;
