//! The built binary from outside, as users meet it: one test program, one module per subject.

mod info;
mod readers;
mod resume;
mod simplify_bad_input;
mod simplify_files;
mod usage;
mod util;
mod verify_bad_input;

// These come with the subcommands they run.
#[cfg(any())]
mod preview_bad_input;
#[cfg(any())]
mod synth_bad_input;
