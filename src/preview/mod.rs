//! Pictures of a mesh above its raster: shaded triangles, their edges or colours, and how far the surface is from the
//! samples.
//!
//! In come a raster, a mesh in PLY and a window; out goes a PNG in the raster's own orientation, row 0 at the top.
//! The mesh is read in two passes, vertices into a temporary file and then faces, each drawn at once and forgotten:
//! memory is the picture, at most 4096² samples and a fixed cache, whatever the mesh's size.
//! How well seams and the raster's rim are hidden is measured by shades alike (`looks`).
//! Nothing here certifies: errors are computed in plain doubles, to be looked at.

mod canvas;
mod colours;
mod deviation;
mod edges;
mod error;
mod gouraud;
mod legend;
mod looks;
mod mesh;
mod options;
mod relief;
mod render;
mod samples;
mod scan;
mod text;
mod vertical;
mod view;

#[cfg(test)]
mod tests;

pub use error::PreviewError;
pub use looks::{Looks, Strip, looks};
pub use options::{Mode, PreviewOptions};
pub(crate) use relief::Light;
pub use render::{PreviewReport, preview};
pub(crate) use vertical::percentile;
pub use vertical::{Degree, VerticalScale};
