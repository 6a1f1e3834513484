//! The command line.

mod preview;
mod size;
mod synth;

use clap::Parser;

use crate::control::Control;

#[derive(Debug, Parser)]
#[command(version, about)]
enum Command {
    Preview(preview::PreviewArgs),
    Synth(synth::SynthArgs),
}

/// Runs the command; returns the exit code.
pub fn main() -> std::process::ExitCode {
    crate::raster::quiet_gdal();
    let result: Result<(), Box<dyn std::error::Error>> = match Command::parse() {
        Command::Preview(args) => preview::run(args, &Control::default()).map_err(Into::into),
        Command::Synth(args) => synth::run(args, &Control::default()).map_err(Into::into),
    };
    match result {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("terrabite: {e}");
            std::process::ExitCode::FAILURE
        }
    }
}
