//! `tiles-plan`, and `run` and `merge` of tiles: a pyramid that many processes make, on one machine or on many.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::Failure;
use super::machine::MachineArgs;
use super::progress::Bars;
use super::shards::of_shards;
use super::tiles::{CommonArgs, TilesOptions, tell};
use crate::job::shards::Shard;
use crate::job::work_dir::PlannedCommand;
use crate::pyramid::{PyramidError, TilesRequest, lay_out_tiles, merge_tiles, work_on_tiles};

/// Lay out terrain tiles that many processes make
///
/// Takes the options of tiles, and brings the raster's samples to the grid. WORK is a folder that all machines share. Then each process
/// makes a part (`terrabite run WORK --shard 3/64`), and one writes the set (`terrabite merge WORK OUT`): the bytes that tiles writes.
/// From then on the raster is not needed.
#[derive(Debug, clap::Args)]
pub(crate) struct TilesPlanArgs {
    /// The raster; its CRS is geographic or projected
    raster: PathBuf,
    /// The folder of the run: new, empty, or that of an earlier run with the same options
    #[arg(value_name = "WORK")]
    work: PathBuf,
    #[command(flatten)]
    options: TilesOptions,
    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// Does `tiles-plan`.
pub(crate) fn plan(args: &TilesPlanArgs) -> Result<ExitCode, Failure> {
    let words = super::shards::said()?;
    let bars = Bars::new(args.common.quiet);
    let layout =
        lay_out_tiles(&args.request(&args.work, Path::new("tiles"))?, words, &bars.control()).map_err(of_work)?;
    drop(bars);
    args.common.print(&layout)?;
    Ok(ExitCode::SUCCESS)
}

impl TilesPlanArgs {
    fn request(&self, work: &Path, output: &Path) -> Result<TilesRequest, Failure> {
        let work_dir = Some(work.to_path_buf());
        Ok(TilesRequest { work_dir, ..self.options.request(&self.raster, output, &self.common)? })
    }
}

/// A process of a run of tiles that has been laid out.
pub(super) struct TilesProcess {
    args: TilesPlanArgs,
    work: PathBuf,
    quiet: bool,
    json: bool,
}

impl TilesProcess {
    /// That of a work dir; `None` if a mesh is laid out there.
    pub(super) fn of(work: &Path, quiet: bool, json: bool) -> Result<Option<TilesProcess>, Failure> {
        let command = PlannedCommand::of(work).map_err(|error| of_shards(error.into()))?;
        let process = |args| TilesProcess { args, work: work.to_path_buf(), quiet, json };
        Ok(super::planned_tiles(&command.words).map(process))
    }

    /// The request of this process, on so much of this machine.
    fn request(&self, machine: &MachineArgs, raster: Option<&Path>, output: &Path) -> Result<TilesRequest, Failure> {
        if let Some(option) = raster.map(|_| "--raster").or(machine.of_samples()) {
            let message =
                format!("{}: {option} is for meshes, and terrain tiles are laid out here", self.work.display());
            return Err(Failure::usage(message).hint(&format!("remove {option}")));
        }
        let request = self.args.request(&self.work, output)?;
        let memory = machine.memory().or(request.memory);
        Ok(TilesRequest { memory, threads: machine.threads().or(request.threads), ..request })
    }

    /// Does `run`.
    pub(super) fn run(
        &self,
        machine: &MachineArgs,
        raster: Option<&Path>,
        shard: Shard,
        pass: Option<usize>,
    ) -> Result<ExitCode, Failure> {
        if let Some(pass) = pass.filter(|pass| *pass > 1) {
            let message =
                format!("{}: expected pass 1, as terrain tiles have no other, found {pass}", self.work.display());
            return Err(Failure::usage(message).hint("choose another --pass"));
        }
        let request = self.request(machine, raster, Path::new("tiles"))?;
        let bars = Bars::new(self.quiet);
        let share = work_on_tiles(&request, shard, &bars.control()).map_err(of_work)?;
        drop(bars);
        tell(&share, self.json, self.quiet)?;
        Ok(ExitCode::SUCCESS)
    }

    /// Does `merge`.
    pub(super) fn merge(
        &self,
        machine: &MachineArgs,
        raster: Option<&Path>,
        output: &Path,
        (overwrite, keep_work_dir): (bool, bool),
    ) -> Result<ExitCode, Failure> {
        let request = self.request(machine, raster, output)?;
        let bars = Bars::new(self.quiet);
        let request = TilesRequest { overwrite, keep_work_dir, ..request };
        let report = merge_tiles(&request, &bars.control()).map_err(of_work)?;
        drop(bars);
        tell(&report, self.json, self.quiet)?;
        Ok(ExitCode::SUCCESS)
    }
}

fn of_work(error: PyramidError) -> Failure {
    of_shards(error.into())
}
