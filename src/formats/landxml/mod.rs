//! LandXML 1.2, the exchange format of surveyors and road builders: a TIN surface as XML, northing before easting, with its CRS
//! as a code of EPSG. Coordinates are decimals that stand for the very doubles; vertices have no attributes. Reader and writer
//! know nothing of each other.

pub mod read;
mod write;

pub use write::LandXmlSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "landxml",
    title: "LandXML",
    extensions: &["xml", "landxml"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::Shared,
    header: HeaderKept::All,
    // Numbers are decimals.
    limits: Limits { vertices: u64::MAX, triangles: u64::MAX },
    attributes: Attributes::None,
    options: &[],
    bytes: Bytes { vertex: 77.0, triangle: 34.0, attribute: 0.0 },
    sink: |staged, setup| Ok(Box::new(LandXmlSink::new(staged, setup))),
    reader: |path, options| Ok(Box::new(read::LandXmlReader::open(path, options)?)),
    recognise: read::recognise,
};
