//! Seams: the vertices on the line between two tiles, fixed before either tile is triangulated.
//!
//! In come the samples of one side of a tile, the limits of error at them, and vertices the side must have; out comes
//! the polyline with the fewest links whose every sample is within its limit ([`MinLink`]), and with channels also within
//! that of the weighted error ([`WeightedLine`]). It is a function of these samples and their weights alone, so both
//! neighbours compute the same one without talking. [`Rim`] puts the four sides of a tile together and says which
//! vertices the tile owns. Vertices a side must have are the points on its line: both neighbours are given them. Where no
//! tolerance is known yet, [`levels`] has a side for every tolerance, each within the next ([`Rim::nested`]).
//!
//! Where samples are missing, `boundary` walks around the ground of the tile and `ground` makes its rim: a side is then
//! also a function of where the ground is in the two lines of samples beside its own.

mod boundary;
mod chained;
mod cut;
mod ground;
mod limits;
mod min_link;
mod nested;
mod rim;
mod runs;
mod weighted;

pub use limits::Limits;
pub use min_link::MinLink;
pub use nested::{Level, levels};
pub use rim::{Foreign, LateVertex, NestedRim, Rim, RimCounts, Side};
pub use runs::Sides;
pub use weighted::WeightedLine;

#[cfg(test)]
mod tests;
