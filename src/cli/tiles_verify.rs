//! `tiles-verify`: judges a pyramid of terrain tiles.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use super::input::InputArgs;
use super::progress::Bars;
use super::{Failure, GDAL_CACHE, print, values, warnings};
use crate::raster::bound_gdal_cache;
use crate::tiles_verify::{TilesVerifyRequest, tiles_verify};

/// Judge a pyramid of terrain tiles against its raster: errors, borders, gaps between levels, manifests
///
/// Reads the raster and the folder that tiles has made, by code of its own. What was promised stands in terrabite.json there;
/// options that decide which samples the raster has must be given as they were. Exit code 0: the tiles pass, 1: they fail.
#[derive(Debug, clap::Args)]
pub(crate) struct TilesVerifyArgs {
    /// The raster that the tiles were made from
    raster: PathBuf,
    /// The folder of tiles
    tiles: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    /// Threads to work with [default: as many as the machine has cores]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<NonZeroUsize>,
    /// Where temporary files go: about 8 bytes for each sample of the grid
    #[arg(long, value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Print the verdict as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing; the exit code tells
    #[arg(long, short, conflicts_with = "json")]
    pub(super) quiet: bool,
}

pub(crate) fn run(args: &TilesVerifyArgs) -> Result<ExitCode, Failure> {
    args.input.asked().check_samples()?;
    bound_gdal_cache(GDAL_CACHE);
    let bars = Bars::new(args.quiet);
    let request = TilesVerifyRequest {
        input: args.raster.clone(),
        view: args.input.view(),
        tiles: args.tiles.clone(),
        threads: args.threads,
        temp_dir: args.temp_dir.clone(),
    };
    let verdict = tiles_verify(&request, &bars.control())?;
    drop(bars);
    if args.json {
        print::json(&verdict)?;
    } else if !args.quiet {
        warnings::print(&warnings::take());
        print::report(&verdict.to_string())?;
    }
    Ok(if verdict.passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
