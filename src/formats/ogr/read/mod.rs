//! Reads triangles from layers of any origin that OGR opens, in constant memory.
//!
//! In comes a path; out go the vertices and faces that are welded from the corners of polygons, triangles, TINs, polyhedral
//! surfaces and collections of them, all with heights, in the layer's own order. Opening reads the layer once, to count and to
//! weld; each pass over vertices reads it again, and notices when it has changed. Memory: the welder's, and one feature.
//! Temporary file: 8 bytes for each corner.
//!
//! In a file of terrabite's edges that follow lines are a second layer; their ends are the vertices at the same places, which two sorts
//! find when they are asked for.
//!
//! A field for each corner (`NAME_1`, `NAME_2`, `NAME_3`) is an attribute of vertices. Where corners at one place differ in it, the
//! first counts.

mod error;
mod facts;
mod layer;
mod reader;
mod wkb;

pub use error::OgrError;
pub use reader::OgrReader;
