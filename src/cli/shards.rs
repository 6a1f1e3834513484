//! `plan`, `run` and `merge`: a run that many processes make, on one machine or on many.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::combinations::Asked;
use super::machine::MachineArgs;
use super::mesh::MeshArgs;
use super::progress::Bars;
use super::simplify::tell;
use super::tiles_plan::TilesProcess;
use super::{Failure, output_format, print, values, warnings};
use crate::base::decimal::Decimal;
use crate::base::features::Feature;
use crate::formats::{self, Format};
use crate::job::shards::Shard;
use crate::job::update::TakenOver;
use crate::job::work_dir::PlannedCommand;
use crate::run::report::Line;
use crate::run::{Layout, Needs, Report, Request, RunError, ShardReport, lay_out, merge, work};

/// Lay out a run that many processes make, on one machine or on many
///
/// Takes the options of simplify. WORK is a folder that all machines share. Then each process makes a part (`terrabite run WORK
/// --shard 3/64`), and one puts the mesh together (`terrabite merge WORK OUTPUT`): the bytes that simplify writes.
#[derive(Debug, clap::Args)]
pub(crate) struct PlanArgs {
    /// The folder of the run: new, empty, or that of an earlier run with the same options
    #[arg(value_name = "WORK", index = 2)]
    work: PathBuf,
    /// The folder of an earlier run with the same options, when the raster had other samples in places, or lines were others: tiles that
    /// no change concerns are taken over. `merge --keep-work-dir` keeps such a folder
    #[arg(long, help_heading = "Run", value_name = "OLD_WORK")]
    update: Option<PathBuf>,
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
}

/// Make a part of a run that has been laid out
///
/// Any number of processes may do so at once. Tiles that are there are not made again. Without --pass all passes are made in their
/// order, as far as the chunks are there that they need; exit code 6 says that tiles wait for other processes.
#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// Which part of how many, such as 3/64
    #[arg(long, value_name = "N/OF", value_parser = values::shard, default_value = "1/1")]
    shard: Shard,
    /// This pass alone, counted from 1: all processes must be done with the one before
    #[arg(long, value_name = "N", value_parser = values::pass)]
    pass: Option<usize>,
    #[command(flatten)]
    pub(super) process: ProcessArgs,
}

/// Put together the mesh, or the terrain tiles, of a run that is complete
///
/// Where tiles are missing they are listed, and the exit code is 6.
#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// The mesh, in the format that the run was laid out for; the folder of a run of terrain tiles
    #[arg(value_name = "OUTPUT", index = 2)]
    output: PathBuf,
    /// Keep the folder of the run, with all its tiles, when the mesh is there
    #[arg(long)]
    keep_work_dir: bool,
    /// Replace an existing output
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub(super) process: ProcessArgs,
}

/// What every process of a run has that has been laid out.
#[derive(Debug, clap::Args)]
pub(crate) struct ProcessArgs {
    /// The folder of the run
    #[arg(value_name = "WORK", index = 1)]
    work: PathBuf,
    /// The raster, where it is called otherwise on this machine; terrain tiles need none
    #[arg(long, value_name = "PATH")]
    raster: Option<PathBuf>,
    #[command(flatten)]
    machine: MachineArgs,
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "json")]
    pub(super) quiet: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Exit code: tiles have to be made by others, or in another pass, first.
pub(super) const WAITING: u8 = 6;

/// What the format of a run is taken from that has no output yet.
fn without_a_name(format: &Format) -> PathBuf {
    Path::new("mesh").with_extension(format.extensions[0])
}

/// Does `plan`.
pub(crate) fn plan(args: &PlanArgs) -> Result<ExitCode, Failure> {
    let mesh = &args.mesh;
    let format = mesh.format(None)?;
    let asked = mesh.asked(format);
    asked.check()?;
    let words = said()?;
    let bars = Bars::new(mesh.quiet);
    let output = without_a_name(format);
    let request = Request { work_dir: Some(args.work.clone()), ..mesh.request(asked.features(), format, &output) };
    let explain = |error| of_shards(mesh.explain(error, &asked, format));
    let layout = lay_out(&request, words, args.update.as_deref(), &bars.control()).map_err(explain)?;
    drop(bars);
    let layout = Layout { needs: Needs { warnings: warnings::take(), ..layout.needs }, ..layout };
    print::told(&layout, &layout.needs.warnings, || layout.lines(), mesh.json, mesh.quiet)?;
    Ok(ExitCode::SUCCESS)
}

/// Does `run`.
pub(crate) fn run(args: &RunArgs) -> Result<ExitCode, Failure> {
    let process = &args.process;
    if let Some(tiles) = TilesProcess::of(&process.work, process.quiet, process.json)? {
        return tiles.run(&process.machine, process.raster.as_deref(), args.shard, args.pass);
    }
    let planned = Planned::of(process)?;
    let bars = Bars::new(process.quiet);
    let request = planned.request(process, &without_a_name(planned.format));
    let report = work(&request, args.shard, args.pass, &bars.control()).map_err(|error| planned.explain(error))?;
    drop(bars);
    let report = ShardReport { warnings: warnings::take(), ..report };
    print::told(&report, &report.warnings, || report.lines(), process.json, process.quiet)?;
    Ok(if report.waiting() > 0 { ExitCode::from(WAITING) } else { ExitCode::SUCCESS })
}

/// Does `merge`.
pub(crate) fn merge_all(args: &MergeArgs) -> Result<ExitCode, Failure> {
    let process = &args.process;
    if let Some(tiles) = TilesProcess::of(&process.work, process.quiet, process.json)? {
        let asked = (args.overwrite, args.keep_work_dir);
        return tiles.merge(&process.machine, process.raster.as_deref(), &args.output, asked);
    }
    let planned = Planned::of(process)?;
    planned.must_be_format_of(&args.output)?;
    let bars = Bars::new(process.quiet);
    let (overwrite, keep_work_dir) = (args.overwrite, args.keep_work_dir);
    let request = Request { overwrite, keep_work_dir, ..planned.request(process, &args.output) };
    let report = merge(&request, &bars.control()).map_err(|error| planned.explain(error))?;
    drop(bars);
    let report = Report { warnings: warnings::take(), ..report };
    tell(report, process.json, process.quiet)
}

/// The words of this command, after the program's name.
pub(super) fn said() -> Result<Vec<String>, Failure> {
    let word = |word: OsString| {
        let wrong = |word: OsString| {
            let word = word.display();
            Failure::usage(format!("{word}: expected words of UTF-8, found others")).hint("rename the file")
        };
        word.into_string().map_err(wrong)
    };
    super::words(std::env::args_os().skip(1)).into_iter().map(word).collect()
}

/// A run that has been laid out, as its command has it.
struct Planned {
    mesh: MeshArgs,
    format: &'static Format,
    asked: Asked,
}

impl Planned {
    fn of(ProcessArgs { work, raster, .. }: &ProcessArgs) -> Result<Planned, Failure> {
        let command = PlannedCommand::of(work).map_err(|error| of_shards(error.into()))?;
        let mut mesh = super::planned_mesh(&command.words).ok_or_else(|| {
            let message = format!("{}: expected the words of a plan, found others", work.display());
            of_shards(Failure::new(message))
        })?;
        mesh.resolve(&command.folder);
        if let Some(raster) = raster {
            mesh.input.clone_from(raster);
        }
        let format = mesh.format(None)?;
        let asked = mesh.asked(format);
        asked.check()?;
        Ok(Planned { mesh, format, asked })
    }

    fn request(&self, process: &ProcessArgs, output: &Path) -> Request<'static> {
        let mut request = self.mesh.request(self.asked.features(), self.format, output);
        request.work_dir = Some(process.work.clone());
        process.machine.apply(&mut request);
        request
    }

    fn explain(&self, error: RunError) -> Failure {
        of_shards(self.mesh.explain(error, &self.asked, self.format))
    }

    /// What a format loses has been taken from the tolerance of all tiles.
    fn must_be_format_of(&self, output: &Path) -> Result<(), Failure> {
        output_format::of(output, Some(self.format.name), output_format::MESHES)?;
        let (name, ending) = (output.display(), self.format.extensions[0]);
        let expected = format!("the format that the run was laid out for, {}", self.format.title);
        match formats::by_extension(output) {
            Some(of_name) if of_name.name == self.format.name => Ok(()),
            Some(of_name) => Err(Failure::usage(format!("{name}: expected {expected}, found {}", of_name.title))
                .hint(&format!("name the output .{ending}, or plan another run with --format {}", of_name.name))),
            None => Err(Failure::usage(format!("{name}: expected a name of {expected}, found no such extension"))
                .hint(&format!("name the output .{ending}"))),
        }
    }
}

/// What mends a failure, where the work dir is an argument.
pub(super) fn of_shards(failure: Failure) -> Failure {
    failure.with_words("--work-dir", "WORK")
}

impl Layout {
    /// The layout as names and values.
    fn lines(&self) -> Vec<Line> {
        let mut lines = vec![("work dir", self.work_dir.clone())];
        lines.extend(self.passes.iter().map(|pass| {
            let tiles = pass.columns * pass.rows;
            ("pass", format!("{}, {}: {} × {} = {tiles} tiles", pass.pass, pass.name, pass.columns, pass.rows))
        }));
        if let Some(tolerance) = self.tolerance {
            lines.push((
                "tolerance",
                format!("{} at first; merge says whether another one is needed", Decimal(tolerance)),
            ));
        }
        if let Some(TakenOver { tiles, taken }) = self.taken_over {
            lines.push(("update", format!("{taken} of {tiles} tiles taken over, {} left to be made", tiles - taken)));
        }
        lines.extend(self.needs.lines());
        lines
    }
}

impl ShardReport {
    /// The report as names and values.
    fn lines(&self) -> Vec<Line> {
        let mut lines = vec![("shard", self.shard.clone())];
        lines.extend(self.tolerance.map(|tolerance| ("tolerance", Decimal(tolerance).to_string())));
        lines.extend(self.passes.iter().map(|pass| {
            let share = pass.share;
            let mut line = format!("{}: {} tiles made, {} found", pass.pass, share.made, share.found);
            if share.waiting > 0 {
                line += &format!(", {} wait for others", share.waiting);
            }
            ("pass", line)
        }));
        lines.push(("time", format!("{:.1} s", self.seconds)));
        lines
    }
}

/// A feature that a run in shards has to do without.
pub(super) fn refused(feature: Feature, failure: Failure) -> Failure {
    let option = super::combinations::option(feature);
    failure.hint(&format!("use simplify, a --quality that polishes, or --max-error instead of {option}"))
}
