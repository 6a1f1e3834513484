//! VTP, the polygons of VTK (ParaView, PyVista) in XML: arrays of points, triangles and attributes behind a head of text.
//! Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::VtpSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Recognised, SinkOption, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "vtp",
    title: "VTP",
    extensions: &["vtp"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::Shared,
    header: HeaderKept::All,
    // Numbers have 64 bits; no file is long enough for more.
    limits: Limits { vertices: 1 << 48, triangles: 1 << 48 },
    attributes: Attributes::All,
    options: &[SinkOption::Normals],
    bytes: Bytes { vertex: 24.0, triangle: 32.0, attribute: 8.0 },
    sink: |staged, setup| Ok(Box::new(VtpSink::new(staged, setup))),
    reader: |path, options| Ok(Box::new(read::VtpReader::open(path, &options.cancel)?)),
    recognise: |beginning| {
        let says = |words: &[u8]| beginning.windows(words.len()).any(|found| found == words);
        match beginning.trim_ascii_start().starts_with(b"<") && says(b"<VTKFile") {
            true if says(b"\"PolyData\"") || says(b"'PolyData'") => Recognised::Surely,
            true => Recognised::Perhaps,
            false => Recognised::No,
        }
    },
};
