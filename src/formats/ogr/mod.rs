//! OGR: vector formats that GDAL writes, GeoPackage first: a polygon or a TIN with heights for each triangle, with the CRS, in
//! files that every GIS opens. Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::{OgrSink, named};

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Recognised, Setup, SinkOption, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "ogr",
    title: "OGR",
    extensions: &["gpkg", "fgb"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::OfEachTriangle,
    header: HeaderKept::All,
    // Rows are numbered in 63 bits.
    limits: Limits { vertices: u64::MAX, triangles: i64::MAX as u64 },
    attributes: Attributes::All,
    options: &[SinkOption::OgrDriver, SinkOption::OgrGeometry],
    bytes: Bytes { vertex: 0.0, triangle: 200.0, attribute: 60.0 },
    sink: |staged, setup: Setup| Ok(Box::new(OgrSink::new(staged, setup)?)),
    reader: |path, options| Ok(Box::new(read::OgrReader::open(path, options)?)),
    recognise,
};

/// SQLite with the mark of a GeoPackage, or FlatGeobuf. All else that OGR opens is known by its extension, or not at all.
fn recognise(beginning: &[u8]) -> Recognised {
    let is_package = beginning.starts_with(b"SQLite format 3\0")
        && beginning.get(68..72).is_some_and(|id| [b"GPKG", b"GP10", b"GP11"].iter().any(|mark| id == *mark));
    let is_flat = beginning.starts_with(b"fgb") && beginning.get(4..7) == Some(b"fgb");
    if is_package || is_flat { Recognised::Surely } else { Recognised::No }
}

#[cfg(test)]
mod tests;
