//! The module `terrabite._terrabite`: what Python cannot do by itself. What users call stands in `python/terrabite`.
//!
//! In come arrays, or objects that read windows of a raster ([`band`]); out come meshes in arrays of numpy ([`mesh`]). Work is
//! done on a thread of its own, while the calling thread looks after signals, the cancel flag and progress ([`run`]). Options
//! come as one dictionary ([`options`]), and errors as exceptions ([`errors`]).

mod band;
mod errors;
mod mesh;
mod options;
mod polishing;
mod run;
mod windows;

use pyo3::prelude::*;

#[pymodule]
fn _terrabite(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<band::PyBand>()?;
    module.add_class::<mesh::PyMesh>()?;
    module.add_function(wrap_pyfunction!(mesh::simplify, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::verify, module)?)?;
    errors::add(module)
}
