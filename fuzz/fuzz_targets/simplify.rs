//! Fuzz target: whole runs.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| terrabite::fuzzing::simplify(bytes));
