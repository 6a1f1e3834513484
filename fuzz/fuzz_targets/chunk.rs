//! Fuzz target: chunks.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| terrabite::fuzzing::chunk(bytes));
