//! A run as a library: what a program or another language calls.

#[cfg(feature = "gdal")]
pub mod info;
pub mod look;
