//! STL, the format of stereolithography: triangles that bring their corners in single precision, and nothing else. The frame
//! of coordinates stands in the 80 bytes at the beginning, which belong to whoever writes. Reader and writer know nothing of
//! each other.

pub mod read;
mod write;

pub use write::StlSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, SinkOption, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "stl",
    title: "STL",
    extensions: &["stl"],
    precisions: &[Precision::Single],
    unit: Unit::Metre,
    vertices: Vertices::OfEachTriangle,
    header: HeaderKept::Frame,
    // Those of walls and floors are to be counted, too.
    limits: Limits { vertices: u64::MAX, triangles: u32::MAX as u64 },
    attributes: Attributes::None,
    options: &[SinkOption::Base],
    bytes: Bytes { vertex: 0.0, triangle: 50.0, attribute: 0.0 },
    sink: |staged, setup| Ok(Box::new(StlSink::new(staged, setup))),
    reader: |path, options| Ok(Box::new(read::StlReader::open(path, options)?)),
    recognise: read::recognise,
};
