//! UGRID: a mesh as variables of a NetCDF file, as hydraulic models and QGIS (MDAL) have them. The file is of the classic kind
//! (64-bit offset, or CDF-5), so no library is needed for it. Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::UgridSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Recognised, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "ugrid",
    title: "UGRID",
    extensions: &["nc"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::Shared,
    header: HeaderKept::All,
    // Numbers have 64 bits; no file is long enough for more.
    limits: Limits { vertices: 1 << 48, triangles: 1 << 48 },
    attributes: Attributes::All,
    options: &[],
    bytes: Bytes { vertex: 24.0, triangle: 12.0, attribute: 8.0 },
    sink: |staged, setup| Ok(Box::new(UgridSink::new(staged, setup))),
    reader: |path, options| Ok(Box::new(read::UgridReader::open(path, &options.cancel)?)),
    recognise: |beginning| match beginning {
        [b'C', b'D', b'F', 1 | 2 | 5, ..] => Recognised::Surely,
        // NetCDF-4 is HDF5, which may hold anything.
        [0x89, b'H', b'D', b'F', b'\r', b'\n', 0x1a, b'\n', ..] => Recognised::Perhaps,
        _ => Recognised::No,
    },
};
