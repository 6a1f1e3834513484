//! GLB, the binary form of glTF 2.0, for looking at meshes: single precision, y up, the origin in a node and, in doubles,
//! beside it. Compressed by meshoptimizer's codecs on request. Reader and writer know nothing of each other.

pub mod read;
#[cfg(test)]
mod tests;
mod write;

pub use write::GlbSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Recognised, SinkOption, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "glb",
    title: "GLB",
    extensions: &["glb"],
    precisions: &[Precision::Single],
    unit: Unit::Metre,
    vertices: Vertices::Shared,
    header: HeaderKept::All,
    // The largest number of 32 bits restarts a primitive. What limits triangles is the length of the file.
    limits: Limits { vertices: u32::MAX as u64 - 1, triangles: u64::MAX },
    attributes: Attributes::Single,
    options: &[SinkOption::Compression, SinkOption::Normals, SinkOption::Texture],
    bytes: Bytes { vertex: 12.0, triangle: 12.0, attribute: 4.0 },
    sink: |staged, setup| Ok(Box::new(GlbSink::new(staged, setup))),
    reader: |path, options| Ok(Box::new(read::GlbReader::open(path, options)?)),
    recognise: |beginning| match beginning.starts_with(b"glTF") {
        true => Recognised::Surely,
        false => Recognised::No,
    },
};
