//! The height field: samples of a whole raster, out of memory, ready to be copied out tile by tile.
//!
//! In comes a [`crate::base::Band`] (or an array); out go [`crate::base::Tile`]s. An uncompressed GeoTIFF is mapped where it
//! lies; a raster in blocks of a moderate size is read through GDAL window by window; anything else is decoded once, in
//! parallel, into an unlinked temporary file of square blocks, which is then mapped; or, where a part of the raster is wanted,
//! in the units that are, when they are (`partial`). This is the only module that maps files.
//!
//! A second raster may come with the first, an importance raster: the weights of errors at the same samples. It is a
//! field of its own, read in the same ways, and its numbers become the weights of a tile.
//!
//! Small holes of a raster may be bridged ([`Field::with_holes_bridged`], `holes`): tiles then have their samples as ground
//! that no tolerance binds.
//!
//! Copying out ([`Field::load`]) is the one place that knows stored types, byte order, scale and offset, and which
//! stored values are no heights, or no weights. Behind it there are only heights and weights, and beside them the values
//! of channels, which are fields of their own (`channels`).

mod channels;
mod decode;
mod error;
mod holes;
mod in_place;
mod load;
mod map;
mod open;
mod partial;
mod source;
mod store;

pub use channels::{find_ranges, height_range, searched_range};
pub use decode::{UNIT_BYTES, decoded_bytes};
pub use error::FieldError;
pub use holes::{HoleOptions, Holes, may_have_holes};
pub use load::LoadScratch;
pub use open::{Access, Choice, Field, FieldOptions, suits_windows};

#[cfg(test)]
mod tests;
