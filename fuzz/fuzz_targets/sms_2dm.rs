//! Fuzz target: 2DM files.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| terrabite::fuzzing::mesh("2dm", bytes));
