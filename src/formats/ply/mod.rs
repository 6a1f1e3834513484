//! PLY, the Stanford polygon format: the usual one. Binary or text, in double or single precision, any attributes, no CRS but what
//! comments say. Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::PlySink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Recognised, SinkOption, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "ply",
    title: "PLY",
    extensions: &["ply"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::Shared,
    header: HeaderKept::AllButHeights,
    // Faces number vertices in 32 bits without a sign.
    limits: Limits { vertices: u32::MAX as u64, triangles: u64::MAX },
    attributes: Attributes::All,
    options: &[SinkOption::Ascii, SinkOption::Normals],
    bytes: Bytes { vertex: 24.0, triangle: 13.0, attribute: 8.0 },
    sink: |staged, setup| Ok(Box::new(PlySink::with_setup(staged, setup)?)),
    reader: |path, options| Ok(Box::new(read::PlyReader::open(path, &options.cancel)?)),
    recognise: |beginning| match beginning {
        [b'p', b'l', b'y', b'\n' | b'\r' | b' ', ..] => Recognised::Surely,
        _ => Recognised::No,
    },
};
