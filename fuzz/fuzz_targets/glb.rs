//! Fuzz target: GLB files.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| terrabite::fuzzing::mesh("glb", bytes));
