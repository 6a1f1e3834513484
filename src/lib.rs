//! terrabite bites terrains of any size into triangles.
pub mod cli;
pub mod control;
pub mod exact;
pub mod field;
pub mod info;
pub mod lattice;
pub mod measure;
pub mod mesh;
pub mod raster;
pub mod seam;
pub mod simplify;
pub mod sink;
pub mod spool;
pub mod staged;
pub mod tiling;
pub mod triangulate;
