//! The command line, as far as it is needed for trying out.

mod preview;
mod size;
mod synth;
mod verify;

use std::error::Error;
use std::process::ExitCode;

use clap::Parser;

use crate::control::Control;

#[derive(Parser)]
#[command(name = "terrabite", version)]
enum Command {
    Preview(preview::PreviewArgs),
    Synth(synth::SynthArgs),
    Verify(verify::VerifyArgs),
}

/// Runs the command line.
pub fn main() -> ExitCode {
    crate::raster::quiet_gdal();
    let control = Control::default();
    let done = |()| ExitCode::SUCCESS;
    let result: Result<ExitCode, Box<dyn Error>> = match Command::parse() {
        Command::Preview(args) => preview::run(args, &control).map(done).map_err(Into::into),
        Command::Synth(args) => synth::run(args, &control).map(done).map_err(Into::into),
        Command::Verify(args) => verify::run(&args, &control).map_err(Into::into),
    };
    result.unwrap_or_else(|error| {
        eprintln!("terrabite: {error}");
        ExitCode::FAILURE
    })
}
