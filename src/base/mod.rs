//! The vocabulary of everything above: tiles of samples, places, meshes, exact arithmetic, control, warnings, files that
//! are written whole. Nothing here imports another folder of the house.

pub mod channels;
pub mod control;
mod coordinate_frame;
pub mod decimal;
pub mod durable;
pub mod exact;
pub mod faults;
mod geo_transform;
pub mod lattice;
pub mod mesh;
pub mod staged;
mod tile;
pub mod tiling;
mod validity;
pub mod warning;
mod window;

pub use coordinate_frame::CoordinateFrame;
pub use geo_transform::GeoTransform;
pub use tile::{Heights, Tile};
pub(crate) use tile::{PADDING, padded};
pub use validity::{Cell, Validity};
pub use window::Window;
