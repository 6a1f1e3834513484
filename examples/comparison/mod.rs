//! Ways to triangulate a window, compared: which window of a raster (`window`), by which method (`methods`), and what it
//! takes (`measured`).

mod measured;
mod methods;
mod window;

pub(crate) use measured::measure;
pub(crate) use methods::{METHODS, franklin, stitched};
pub(crate) use window::{Window, tolerance_of};
