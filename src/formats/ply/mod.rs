//! PLY, the Stanford polygon format: the usual one. Binary, in double or single precision, any attributes, no CRS but what
//! comments say. Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::PlySink;

use super::{Attributes, Bytes, Format, Limits, Precision, Recognised};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "ply",
    title: "PLY",
    extensions: &["ply"],
    precisions: &[Precision::Double, Precision::Single],
    // Faces number vertices in 32 bits without a sign.
    limits: Limits { vertices: u32::MAX as u64, triangles: u64::MAX },
    attributes: Attributes::All,
    bytes: Bytes { vertex: 24.0, triangle: 13.0, attribute: 8.0 },
    sink: |staged, header, loss| Ok(Box::new(PlySink::new(staged, header).with_loss(loss))),
    reader: |path, cancel| Ok(Box::new(read::PlyReader::open(path, cancel)?)),
    recognise: |beginning| match beginning {
        [b'p', b'l', b'y', b'\n' | b'\r' | b' ', ..] => Recognised::Surely,
        _ => Recognised::No,
    },
};
