//! `simplify`: a run from its options to the report.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::mesh::MeshArgs;
use super::progress::Bars;
use super::{Failure, print, qa, warnings};
use crate::base::staged::StagedFile;
use crate::base::warning::Warnings;
use crate::run::scene::Most;
use crate::run::{Needs, Report, Request, plan, simplify};

/// Turn a raster into a mesh that is within a tolerance of every sample
#[derive(Debug, clap::Args)]
pub(crate) struct SimplifyArgs {
    /// The mesh, in the format that its extension says: .ply, .obj, .glb, .stl, .xml (LandXML), .nc (UGRID), .vtp, .2dm, .gpkg or
    /// .fgb
    #[arg(value_name = "OUTPUT", index = 2)]
    output: PathBuf,
    /// Keep finished tiles in this folder: after an interrupt, a crash or a power cut the same command continues there. With
    /// --dry-run: print how many tiles are left to be made
    #[arg(long, help_heading = "Run", value_name = "DIR")]
    work_dir: Option<PathBuf>,
    /// Keep the work dir, with all its tiles, when the mesh is there
    #[arg(long, help_heading = "Run", hide_short_help = true, requires = "work_dir")]
    keep_work_dir: bool,
    /// Print what the run would need, from a few tiles, and stop
    #[arg(long, help_heading = "Run", hide_short_help = true)]
    dry_run: bool,
    /// Replace an existing output, and the page that --report names
    #[arg(long, help_heading = "Run")]
    overwrite: bool,
    /// Write what the run measured, and a view of the mesh, as a page for a browser, in one file
    #[arg(long, help_heading = "Run", value_name = "HTML", conflicts_with = "dry_run")]
    report: Option<PathBuf>,
    #[command(flatten)]
    pub(super) mesh: MeshArgs,
}

pub(crate) fn run(args: &SimplifyArgs) -> Result<ExitCode, Failure> {
    let mesh = &args.mesh;
    let format = mesh.format(Some(&args.output))?;
    let asked = mesh.asked(format);
    asked.check()?;
    let bars = Bars::new(mesh.quiet);
    let request = Request {
        overwrite: args.overwrite,
        work_dir: args.work_dir.clone(),
        keep_work_dir: args.keep_work_dir,
        scene: args.report.as_ref().map(|_| Most::OF_A_PAGE),
        ..mesh.request(asked.features(), format, &args.output)
    };
    if args.dry_run {
        let needs = plan(&request, &bars.control()).map_err(|error| mesh.explain(error, &asked, format))?;
        drop(bars);
        let needs = Needs { warnings: warnings::take(), ..needs };
        let none = Warnings::default();
        let warned = if mesh.quiet { &none } else { &needs.warnings };
        print::told(&needs, warned, || needs.lines(), mesh.json, false)?;
        return Ok(ExitCode::SUCCESS);
    }
    if let Some(page) = &args.report {
        check_page(page, &request)?;
    }
    let report = simplify(&request, &bars.control()).map_err(|error| mesh.explain(error, &asked, format))?;
    drop(bars);
    let report = Report { warnings: warnings::take(), ..report };
    if let Some(page) = &args.report {
        let temp_dir = Some(request.params.temp_dir.as_path());
        let made = crate::page::of_run(&report, &qa::origin(request.input.path(), &args.output, temp_dir))?;
        crate::page::write(&made, page, args.overwrite, &kept(&request))?;
    }
    tell(report, mesh.json, mesh.quiet)
}

/// Finds what is wrong with the path of a page before the work begins.
fn check_page(page: &Path, request: &Request<'_>) -> Result<(), Failure> {
    if page == request.output {
        return Err(Failure::usage(format!("{}: --report and the mesh are the same file", page.display())));
    }
    Ok(StagedFile::check(page, request.overwrite, &kept(request))?)
}

/// What a page may not replace: what the run reads, and what it writes.
fn kept<'r>(request: &'r Request<'_>) -> Vec<&'r Path> {
    request.inputs().into_iter().chain([request.output.as_path()]).collect()
}

/// Prints the report of a mesh that was made, and gives the exit code.
pub(super) fn tell(report: Report, is_json: bool, is_quiet: bool) -> Result<ExitCode, Failure> {
    print::told(&report, &report.warnings, || report.lines(), is_json, is_quiet)?;
    Ok(if report.fell_short() { ExitCode::from(FELL_SHORT) } else { ExitCode::SUCCESS })
}

/// Exit code: a budget ended the refinement before the quality that was asked for was reached.
const FELL_SHORT: u8 = 5;
