//! UGRID's reader: classic NetCDF files (CDF-1, CDF-2, CDF-5) with a mesh of triangles, whoever has written them.

mod error;
mod head;
mod mesh;
mod reader;
#[cfg(test)]
mod tests;
mod values;

pub use error::UgridError;
pub use reader::UgridReader;
