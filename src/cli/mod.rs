//! The command line: one file per subcommand, and what they share.
//!
//! In come the words the user typed; each subcommand checks them (`values`), calls the library, prints a report on
//! standard output and ends in an exit code. Nothing below this folder prints, exits or knows of options.

mod attributes;
mod breaklines;
mod clip;
mod combinations;
mod convert;
mod coordinates;
mod cutline;
mod engine;
mod failure;
mod format_options;
mod goal;
mod heap;
mod importance;
mod info;
mod input;
mod machine;
mod mesh;
#[cfg(test)]
mod options_page;
mod output_format;
mod polish;
mod preview;
mod print;
mod progress;
mod qa;
mod shards;
mod shell;
mod signals;
mod simplify;
mod synth;
mod tiles;
mod tiles_plan;
mod tiles_verify;
mod values;
mod verify;
mod view;
mod warnings;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

pub(crate) use failure::Failure;

/// Bites terrains of any size into triangles.
///
/// A raster of heights goes in; a triangulated irregular network comes out whose surface lies within a stated vertical
/// distance of every sample.
#[derive(Debug, Parser)]
#[command(name = "terrabite", version, arg_required_else_help = true, disable_help_subcommand = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

/// Each variant's help is the documentation of its arguments.
#[derive(Debug, Subcommand)]
enum Command {
    Simplify(Box<simplify::SimplifyArgs>),
    Plan(Box<shards::PlanArgs>),
    Run(shards::RunArgs),
    Merge(shards::MergeArgs),
    Verify(Box<verify::VerifyArgs>),
    Tiles(tiles::TilesArgs),
    TilesPlan(tiles_plan::TilesPlanArgs),
    TilesVerify(tiles_verify::TilesVerifyArgs),
    Convert(convert::ConvertArgs),
    Info(info::InfoArgs),
    Synth(synth::SynthArgs),
    Preview(preview::PreviewArgs),
    View(view::ViewArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

impl Command {
    fn run(&self) -> Result<ExitCode, Failure> {
        match self {
            Command::Simplify(args) => simplify::run(args),
            Command::Plan(args) => shards::plan(args),
            Command::Run(args) => shards::run(args),
            Command::Merge(args) => shards::merge_all(args),
            Command::Verify(args) => verify::run(args),
            Command::Tiles(args) => tiles::run(args),
            Command::TilesPlan(args) => tiles_plan::plan(args),
            Command::TilesVerify(args) => tiles_verify::run(args),
            Command::Convert(args) => convert::run(args),
            Command::Info(args) => info::run(args),
            Command::Synth(args) => synth::run(args),
            Command::Preview(args) => preview::run(args),
            Command::View(args) => view::run(args),
            Command::Completions(args) => shell::completions(args),
            Command::Man(args) => shell::man(args),
        }
    }

    fn is_quiet(&self) -> bool {
        match self {
            Command::Simplify(args) => args.mesh.quiet,
            Command::Plan(args) => args.mesh.quiet,
            Command::Run(args) => args.process.quiet,
            Command::Merge(args) => args.process.quiet,
            Command::Verify(args) => args.quiet,
            Command::Tiles(args) => args.common.quiet,
            Command::TilesPlan(args) => args.common.quiet,
            Command::TilesVerify(args) => args.common.quiet,
            Command::Convert(args) => args.quiet,
            Command::Preview(args) => args.quiet,
            Command::View(args) => args.quiet,
            Command::Synth(_) | Command::Info(_) | Command::Completions(_) | Command::Man(_) => false,
        }
    }
}

/// GDAL's block cache for commands without a memory budget, in bytes.
const GDAL_CACHE: u64 = 64 << 20;

const EXIT_CODES: &str = "\
Exit codes:
  0    done; for a check: passed
  1    failed, with the reason on standard error; for a check: not passed
  2    the command line cannot be understood, or combines what cannot be combined
  3    the memory budget is too small
  4    a disk is too small
  5    done, but a budget ended the refinement before the quality that was asked for
  6    run, merge: tiles have to be made by other processes, or in another pass, first
  130  stopped by an interrupt (Ctrl-C), 143 by a termination signal
A closed pipe on standard output is no failure.";

/// Runs the command line of this process to its end. Called once, from `main`.
pub fn main() -> ExitCode {
    heap::give_back_large_blocks();
    crate::raster::keep_gdal_warnings();
    crate::raster::own_gdal_cache();
    let cli = match parse() {
        Ok(cli) => cli,
        Err(usage) => {
            // Help goes to standard output and may meet a closed pipe; nobody is left to be told.
            let _ = usage.print();
            return ExitCode::from(usage.exit_code() as u8);
        }
    };
    if let Err(failure) =
        crate::base::faults::arm(signals::act).map_err(Failure::usage).and_then(|()| signals::listen())
    {
        return failure.report();
    }
    cli.command.run().unwrap_or_else(|failure| {
        if !cli.command.is_quiet() {
            warnings::print(&warnings::take());
        }
        failure.report()
    })
}

fn parse() -> Result<Cli, clap::Error> {
    let mut command = command();
    // GDAL is not asked for its drivers otherwise.
    if std::env::args_os().any(|word| word == "--version") {
        command = command.long_version(version());
    }
    let matches = command.try_get_matches_from_mut(words(std::env::args_os()))?;
    Cli::from_arg_matches(&matches).map_err(|e| e.format(&mut command))
}

/// What `--version` says: of the libraries, too, on which formats and transformations depend.
fn version() -> String {
    let crate::raster::Libraries { gdal, proj, drivers } = crate::raster::Libraries::here();
    let proj = if proj.is_empty() { "not said".to_string() } else { proj };
    let (version, count) = (env!("CARGO_PKG_VERSION"), drivers.len());
    format!("{version}\nGDAL {gdal}, PROJ {proj}\n{count} raster drivers: {}", drivers.join(", "))
}

/// The mesh that the words of a `plan` ask for.
fn planned_mesh(words: &[String]) -> Option<mesh::MeshArgs> {
    match of_words(words)? {
        Command::Plan(args) => Some(args.mesh),
        _ => None,
    }
}

/// What the words of a `tiles-plan` ask for.
fn planned_tiles(words: &[String]) -> Option<tiles_plan::TilesPlanArgs> {
    match of_words(words)? {
        Command::TilesPlan(args) => Some(args),
        _ => None,
    }
}

/// The command that words after the program's name are.
fn of_words(words: &[String]) -> Option<Command> {
    let words = std::iter::once("terrabite").chain(words.iter().map(String::as_str));
    Some(Cli::from_arg_matches(&command().try_get_matches_from(words).ok()?).ok()?.command)
}

/// GDAL's programs take open options as `-oo`; here that would be two short options.
fn words(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut escaped = false;
    let word = |argument: OsString| {
        escaped |= argument == "--";
        if argument == "-oo" && !escaped { OsString::from("--oo") } else { argument }
    };
    arguments.map(word).collect()
}

/// The exit codes stand under every subcommand's long help, too.
fn command() -> clap::Command {
    Cli::command().after_help(EXIT_CODES).mut_subcommands(|c| c.after_long_help(EXIT_CODES))
}

#[cfg(test)]
mod tests {
    #[test]
    fn options_are_consistent() {
        super::command().debug_assert();
    }
}
