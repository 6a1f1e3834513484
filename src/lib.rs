//! terrabite bites terrains of any size into triangles.
pub mod control;
pub mod exact;
pub mod field;
pub mod lattice;
pub mod mesh;
pub mod raster;
pub mod seam;
pub mod tiling;
pub mod triangulate;
