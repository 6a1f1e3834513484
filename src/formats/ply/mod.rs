//! PLY: reader and writer know nothing of each other.

pub mod read;
mod write;

pub use write::PlySink;
