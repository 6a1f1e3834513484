//! `tiles-verify`: judges a pyramid of terrain tiles.

use std::path::PathBuf;
use std::process::ExitCode;

use super::Failure;
use super::progress::Bars;
use super::tiles::CommonArgs;
use crate::tiles_verify::{TilesVerifyRequest, tiles_verify};

/// Judge terrain tiles against their raster: errors, borders, gaps, manifests
///
/// Reads the raster and the folder that tiles has made, by code of its own. What was promised stands in terrabite.json there;
/// options that decide which samples the raster has must be given as they were, and the verdict says in what they differ. How far tiles are from
/// the raster's own samples is told, too; it is a fault only where they were made with --own-samples. Exit code 0: the tiles pass, 1: they fail.
#[derive(Debug, clap::Args)]
pub(crate) struct TilesVerifyArgs {
    /// The raster that the tiles were made from
    raster: PathBuf,
    /// The folder of tiles
    tiles: PathBuf,
    #[command(flatten)]
    pub(super) common: CommonArgs,
}

pub(crate) fn run(args: &TilesVerifyArgs) -> Result<ExitCode, Failure> {
    args.common.input.asked().check_samples()?;
    let bars = Bars::new(args.common.quiet);
    let request = TilesVerifyRequest {
        input: args.raster.clone(),
        view: args.common.input.view(),
        tiles: args.tiles.clone(),
        memory: args.common.memory,
        threads: args.common.threads,
        temp_dir: args.common.temp_dir.clone(),
    };
    let verdict = tiles_verify(&request, &bars.control())?;
    drop(bars);
    args.common.print(&verdict)?;
    Ok(if verdict.passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
