//! The command line, as far as `verify` needs it for trying out.
mod verify;

use std::process::ExitCode;

use clap::Parser;

#[derive(Parser)]
#[command(name = "terrabite", version)]
enum Command {
    Verify(verify::VerifyArgs),
}

/// Runs the command line.
pub fn main() -> ExitCode {
    crate::raster::quiet_gdal();
    let Command::Verify(args) = Command::parse();
    verify::run(&args, &crate::control::Control::default()).unwrap_or_else(|error| {
        eprintln!("terrabite: {error}");
        ExitCode::FAILURE
    })
}
