//! terrabite bites terrains of any size into triangles.
pub mod cli;
pub mod control;
pub mod ply;
pub mod preview;
pub mod raster;
pub mod synth;
pub mod verify;
