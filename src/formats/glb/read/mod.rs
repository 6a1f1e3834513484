//! Reads triangle meshes from GLB files of any origin, in constant memory.
//!
//! In comes a path; out go, pass by pass, the vertices and the faces of all meshes in the file's scene, turned so that z is up.
//! A mesh of one primitive with indices keeps its vertices as they are; where there are more, or triangles have no indices,
//! opening reads all positions and joins vertices at the same place, bit for bit (temporary files: at most 80 bytes a vertex).
//!
//! Where the nodes move all meshes by the same way and do nothing else, that way is the frame's origin, and coordinates are
//! those of the meshes; for files of terrabite, as long as that way is the one they say, the frame is what they say. Other
//! transformations are applied, in doubles.
//!
//! Taken are triangles (mode 4), positions in single precision, indices of 8, 16 and 32 bits or none, buffers in the BIN
//! chunk, plain or compressed (`EXT_meshopt_compression`, without filters or with `EXPONENTIAL`). Attributes are those that
//! begin with `_` and have one component, `COLOR_0` as `red`, `green` and `blue`, and `NORMAL` as `nx`, `ny` and `nz`, where
//! all primitives have them. Textures, materials, animations, morph targets and cameras are passed over.
//!
//! Memory: the JSON chunk (64 MiB at most) and what it says, a buffer of 256 KiB for each of a primitive's buffer views, and
//! compressed views as a whole (1 GiB at most; terrabite's have 17 MB).

mod columns;
mod container;
mod document;
mod error;
mod packed;
mod reader;
mod scene;
#[cfg(test)]
mod tests;
mod transform;

pub use error::GlbError;
pub use reader::GlbReader;
