//! VTP's reader: VTK's XML for polygons with arrays that are not compressed, as bytes, base64 or text, whoever has written them.

mod document;
mod error;
mod numbers;
mod reader;
mod tags;
#[cfg(test)]
mod tests;

pub use error::VtpError;
pub use reader::VtpReader;
