//! Fuzz target: GeoTIFFs.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| terrabite::fuzzing::tiff(bytes));
