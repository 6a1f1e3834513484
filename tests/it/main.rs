//! The built binary from outside, as users meet it: one test program, one module per subject.

mod info;
mod usage;
mod util;

// These come with the subcommands they run.
#[cfg(any())]
mod preview_bad_input;
#[cfg(any())]
mod readers;
#[cfg(any())]
mod simplify_bad_input;
#[cfg(any())]
mod simplify_files;
#[cfg(any())]
mod synth_bad_input;
#[cfg(any())]
mod verify_bad_input;
