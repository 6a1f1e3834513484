//! Meshes as files: one folder per format, with its reader and its writer.

mod error;
pub mod ply;
mod sink;

pub use error::SinkError;
pub use ply::PlySink;
pub use sink::{Contents, Sink};
