//! Reads triangle meshes from STL files of any origin, in constant memory.
//!
//! In comes a path; out go, pass by pass, the vertices and the faces. Taken are binary files, whose length must be what their
//! count of triangles asks for, and text (`solid`, `facet`, `outer loop`, `vertex` …, a statement a line, several solids one
//! after the other). Normals, attribute bytes, names and the headers of other programs are passed over. Corners at one place are
//! one vertex; vertices are numbered as triangles name them first.
//!
//! Of a solid that terrabite has written (a surface with a floor and walls) the surface is read. Opening makes sure of
//! the rest: each triangle of the surface has its like on the floor, walls are upright, and every edge there is once
//! in either direction, so that the solid is closed.
//!
//! Opening reads the file once, a solid twice, and sorts corners in temporary files: some 200 bytes for each triangle of the
//! surface. Each pass over vertices reads the file again, one over faces a temporary file of 24 bytes for each triangle. Memory: two sorts of 16 MiB at a time, and one buffer of 256 KiB for a pass.

mod closed;
mod error;
mod file;
#[cfg(test)]
mod tests;
mod text;
mod triangles;

pub use error::StlError;
pub use file::StlReader;

use crate::formats::Recognised;

/// What the headers of terrabite's files begin with.
const MARK: &[u8] = b"terrabite STL";

/// By the header that terrabite writes, or the first word of a text. Other binary files bear no mark.
pub(super) fn recognise(beginning: &[u8]) -> Recognised {
    if beginning.starts_with(MARK) {
        return Recognised::Surely;
    }
    if text::is_text(beginning) { Recognised::Perhaps } else { Recognised::No }
}
