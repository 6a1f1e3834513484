//! terrabite bites terrains of any size into triangles.
pub mod cli;
pub mod control;
pub mod raster;
pub mod synth;
