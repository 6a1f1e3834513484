//! Fuzz target: PLY files.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| terrabite::fuzzing::mesh("ply", bytes));
