//! Where samples lie on the map, and what coordinates and heights mean there.

mod geo_transform;
mod reference;

pub use geo_transform::GeoTransform;
pub use reference::Reference;
