//! OBJ, the format of Wavefront: text that nearly every program reads, with the CRS in a `.prj` file beside it. Coordinates
//! are decimals that stand for the very doubles; vertices have no attributes. Reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::ObjSink;

use super::{Attributes, Bytes, Format, HeaderKept, Limits, Precision, SinkOption, Unit, Vertices};

/// The format's row in the table.
pub const FORMAT: Format = Format {
    name: "obj",
    title: "OBJ",
    extensions: &["obj"],
    precisions: &[Precision::Double, Precision::Single],
    unit: Unit::OfCrs,
    vertices: Vertices::Shared,
    header: HeaderKept::All,
    // Numbers are decimals.
    limits: Limits { vertices: u64::MAX, triangles: u64::MAX },
    // Colours after coordinates (`v x y z r g b`) are no part of the format; meshio 5.3.5 takes them for coordinates.
    attributes: Attributes::None,
    options: &[SinkOption::Normals, SinkOption::Texture],
    bytes: Bytes { vertex: 56.0, triangle: 27.0, attribute: 0.0 },
    sink: |staged, setup| Ok(Box::new(ObjSink::new(staged, setup)?)),
    reader: |path, options| Ok(Box::new(read::ObjReader::open(path, &options.cancel)?)),
    recognise: read::recognise,
};
