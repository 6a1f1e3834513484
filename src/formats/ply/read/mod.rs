//! Reads triangle meshes from PLY files of any origin, in constant memory.
//!
//! In comes a path; out go the header's promises ([`PlyFile`]) and, pass by pass, the vertices and the faces, each
//! handed to a closure. Nothing is kept but one buffer: a file of any size is read in the same few hundred KiB. The
//! header is not believed: counts are held against the file's length, list lengths and indices against their limits,
//! and whatever does not fit is a [`PlyError`] that names the place.
//!
//! Taken are `ascii`, `binary_little_endian` and `binary_big_endian` of version 1.0, elements and properties in any
//! order, any number types, and the 64-bit integers `int64` and `uint64` that the format's description does not know.
//! Bytes after the last element are ignored. [`PlyReader`] is the same file as a [`crate::formats::MeshReader`].

mod error;
mod file;
mod header;
mod reader;
#[cfg(test)]
mod tests;
mod values;

pub use error::PlyError;
pub use file::PlyFile;
pub use header::{Encoding, ScalarType};
pub use reader::PlyReader;
