//! Where samples lie on the map, and what coordinates and heights mean there.

mod geo_transform;
mod metres;
mod reference;
mod wkt;

pub use geo_transform::GeoTransform;
pub use metres::{Metres, metres_in};
pub use reference::Reference;
pub use wkt::CrsFacts;
