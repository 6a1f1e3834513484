//! What the fuzzers of `fuzz/` run: one function a target, from any bytes to a panic where a promise is broken. The tests
//! run them on the corpus, on seeds that are spoilt a little, and on bytes at random.

mod bytes;
mod chunk;
mod mesh;
mod naive;
mod simplify;
#[cfg(test)]
mod tests;
mod tiff;

pub use chunk::chunk;
pub use mesh::mesh;
pub use simplify::simplify;
pub use tiff::tiff;

use std::path::PathBuf;

/// Where temporary files go: to memory where there is such a place, as disks are slow.
pub(crate) fn temp_dir() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    if memory.is_dir() { memory } else { std::env::temp_dir() }
}
