//! 2DM's reader: meshes of triangles, whoever has written them.

mod error;
mod line;
mod reader;
#[cfg(test)]
mod tests;

pub use error::Sms2dmError;
pub use reader::Sms2dmReader;
