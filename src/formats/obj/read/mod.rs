//! Reads triangle meshes from OBJ files of any origin, in constant memory.
//!
//! In comes a path; out go, pass by pass, the vertices (`v`) and the faces (`f`). Opening reads the file once, to count them and
//! to find lines that belong to no mesh; each pass reads it again. Memory: one buffer of 256 KiB, one line of at most 1 MiB
//! and, while opening, the comments at the head of the file, 1 MiB of them at most.
//!
//! Taken are faces with `v`, `v/vt`, `v//vn` and `v/vt/vn`, negative numbers (they count back from the last vertex before the
//! face), lines that go on after a backslash, and vertices with a weight or a colour, which are not used. Not used either are
//! texture coordinates, normals, points, lines, names of objects, groups and materials. Faces with other than three corners
//! are refused, as are free-form surfaces: with them the file is not a mesh of triangles.

mod error;
mod file;
mod line;
#[cfg(test)]
mod tests;

pub use error::ObjError;
pub use file::ObjReader;

use crate::formats::Recognised;
use line::{Kind, is_header, kind};

/// By the first comment that terrabite writes, or by the keyword of the first line that is no comment.
pub(super) fn recognise(beginning: &[u8]) -> Recognised {
    let mut lines = beginning.split_inclusive(|b| *b == b'\n');
    if lines.next().is_some_and(is_header) {
        return Recognised::Surely;
    }
    let mut whole = beginning.split_inclusive(|b| *b == b'\n').filter(|line| line.ends_with(b"\n"));
    match whole.by_ref().map(kind).find(|kind| *kind != Kind::Nothing) {
        Some(Kind::Vertex | Kind::Face | Kind::Unused) => Recognised::Perhaps,
        None if beginning.starts_with(b"#") => Recognised::Perhaps,
        _ => Recognised::No,
    }
}
