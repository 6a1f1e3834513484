//! The built binary from outside, as users meet it: one test program, one module per subject.

mod budget;
mod channels;
mod clip;
mod cutline;
mod formats;
mod gdal_errors;
mod holes;
mod hostile;
mod importance;
mod info;
mod insertion;
mod map;
mod nodata;
mod output_names;
mod points;
mod preview_bad_input;
mod readers;
mod resume;
mod simplify_bad_input;
mod simplify_files;
mod synth_bad_input;
mod trim;
mod usage;
mod util;
mod verify;
mod verify_bad_input;
