//! Meshes as files: a table of formats, and one folder for each with its writer and its reader.
//!
//! [`FORMATS`] is the table. A writer is a [`Sink`]; it is given a staged file and a [`Header`], which it words as its format
//! can. A reader is a [`MeshReader`]: [`open`] finds the right one for a file. Reader and writer of a format know nothing of
//! each other, so that `verify` judges what was written, and not what was meant; what they share is data. A new format is a
//! folder, and a row in the table; `conformance.rs` holds every row to its promises. A mesh in memory is no format of files:
//! [`ArraySink`] and [`ArrayReader`] have it in arrays.

#[cfg(test)]
mod any_mesh;
mod arrays;
mod columns;
#[cfg(test)]
mod conformance;
mod ends;
mod error;
mod format;
pub mod glb;
mod header;
mod joiner;
pub mod landxml;
mod lines;
pub mod obj;
#[cfg(feature = "gdal")]
pub mod ogr;
mod open;
mod output;
pub mod ply;
mod reader;
mod sink;
mod sink_options;
pub mod sms_2dm;
pub mod stl;
mod text;
pub mod ugrid;
pub mod vtp;
mod weld;
mod wording;

pub use arrays::{ArrayReader, ArraySink, Arrays};
pub use error::{ReadError, SinkError};
pub use format::{
    Attributes, BEGINNING, Bytes, Format, HeaderKept, Limits, OpenReader, OpenSink, Precision, ReadOptions, Recognised,
    Setup, Unit, Vertices,
};
pub use header::{Crs, Header, Heights, OptionName, RunOption};
pub use open::{by_extension, by_name, open, recognised};
pub use ply::PlySink;
pub use reader::{EdgeVisitor, FaceVisitor, MeshReader, VertexVisitor};
pub use sink::{Bounds, Contents, Marks, Needs, Sink};
pub use sink_options::{Base, Compression, OgrGeometry, SinkOption, SinkOptions};
pub use text::TextError;

/// Every format that is written and read; the first is the usual one.
pub const FORMATS: &[&Format] = &[
    &ply::FORMAT,
    &obj::FORMAT,
    &glb::FORMAT,
    &stl::FORMAT,
    &landxml::FORMAT,
    &ugrid::FORMAT,
    &vtp::FORMAT,
    &sms_2dm::FORMAT,
    #[cfg(feature = "gdal")]
    &ogr::FORMAT,
];
