//! 2DM, the meshes of SMS (Aquaveo) and of hydraulic models: text, with nodes and elements that have numbers of their own.
//! Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::Sms2dmSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Recognised, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "2dm",
    title: "2DM",
    extensions: &["2dm"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::Shared,
    header: HeaderKept::All,
    // MDAL 1.3.1 and py2dm 0.2.2 take no larger numbers.
    limits: Limits { vertices: i32::MAX as u64, triangles: i32::MAX as u64 },
    attributes: Attributes::None,
    options: &[],
    bytes: Bytes { vertex: 66.0, triangle: 41.0, attribute: 0.0 },
    sink: |staged, setup| Ok(Box::new(Sms2dmSink::new(staged, setup))),
    reader: |path, options| Ok(Box::new(read::Sms2dmReader::open(path, &options.cancel)?)),
    recognise: |beginning| match beginning.trim_ascii_start() {
        [b'M', b'E', b'S', b'H', b'2', b'D', after, ..] if after.is_ascii_whitespace() => Recognised::Surely,
        _ => Recognised::No,
    },
};
