use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use clap::ValueEnum;

use super::progress::Bars;
use super::simplify_kept::Kept;
use super::simplify_report::{Report, Seconds};
use super::{Failure, print, values};
use crate::control::Control;
use crate::field::{Field, FieldOptions};
use crate::raster::{Raster, Watch};
use crate::simplify::{DEFAULT_TILE, Error, Params, triangulate, triangulate_into};
use crate::sink::PlySink;
use crate::staged::StagedFile;
use crate::triangulate::Feasibility;

/// Turn a raster into a mesh that is within a tolerance of every sample
#[derive(Debug, clap::Args)]
pub(crate) struct SimplifyArgs {
    /// The raster: a file, or any name GDAL opens
    #[arg(value_name = "INPUT")]
    pub(super) input: PathBuf,
    /// The mesh: a binary PLY file in map coordinates
    #[arg(value_name = "OUTPUT")]
    pub(super) output: PathBuf,
    /// The largest vertical distance allowed between mesh and samples, in the units of the heights; 0 is exact
    #[arg(long, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    max_error: f64,
    /// Test triangles at the samples under them (weak), or also where their edges cross the grid (strong)
    #[arg(long, value_enum, default_value_t = FeasibilityArg::Weak)]
    feasibility: FeasibilityArg,
    /// The side of the tiles worked on one at a time; 0 makes one of the whole raster
    #[arg(long, value_name = "CELLS", default_value_t = DEFAULT_TILE)]
    tile: usize,
    /// The band, counted from 1
    #[arg(long, value_name = "N", default_value_t = 1)]
    band: usize,
    /// The folder of temporary files [default: the system's]
    #[arg(long, value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Keep finished tiles in this folder: after an interrupt, a crash or a power cut the same command continues there
    #[arg(long, value_name = "DIR")]
    work_dir: Option<PathBuf>,
    /// Threads to work with [default: as many as the machine has cores]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<NonZeroUsize>,
    /// Replace an existing output
    #[arg(long)]
    pub(super) overwrite: bool,
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FeasibilityArg {
    Weak,
    Strong,
}

impl From<FeasibilityArg> for Feasibility {
    fn from(argument: FeasibilityArg) -> Feasibility {
        match argument {
            FeasibilityArg::Weak => Feasibility::Weak,
            FeasibilityArg::Strong => Feasibility::Strong,
        }
    }
}

pub(crate) fn run(args: &SimplifyArgs) -> Result<ExitCode, Failure> {
    let threads = args.threads.map_or(0, NonZeroUsize::get);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| {
        Failure::new(format!("{} threads cannot be started: {e}", threads)).hint("choose fewer with --threads")
    })?;
    let bars = Bars::new(args.quiet);
    let report = pool.install(|| simplify(args, &bars.control()))?;
    drop(bars);
    if args.json {
        print::json(&report)?;
    } else if !args.quiet {
        print::report(&print::aligned(&report.lines()))?;
    }
    Ok(ExitCode::SUCCESS)
}

fn simplify(args: &SimplifyArgs, control: &Control<'_>) -> Result<Report, Failure> {
    let start = Instant::now();
    let raster = Raster::open(&args.input, args.band)?;
    let watch = Watch::new(&raster)?;
    let mut params = Params { feasibility: args.feasibility.into(), tile: args.tile, ..Params::new(args.max_error) };
    if let Some(dir) = &args.temp_dir {
        params.temp_dir.clone_from(dir);
    }
    let kept = args.work_dir.as_ref().map(|dir| Kept::open(dir, &raster, &watch, &params)).transpose()?;
    let staged = match &kept {
        Some(kept) => kept.stage(args)?,
        None => StagedFile::create(&args.output, args.overwrite, &[&args.input])?,
    };
    let run = || -> Result<(Report, u64), Error> {
        let field_options = FieldOptions { temp_dir: params.temp_dir.clone() };
        let field = Field::open(&raster, &field_options, control)?;
        let opened = Instant::now();
        let mesh = match &kept {
            Some(kept) => triangulate_into(kept.spool(params.grid(&field)?)?, &field, &params, control)?,
            None => triangulate(&field, &params, control)?,
        };
        watch.check()?;
        let triangulated = Instant::now();
        let may_finish = || {
            watch.check()?;
            kept.as_ref().map_or(Ok(()), Kept::committing)
        };
        let sink = PlySink::new(staged, &comments(&raster, args));
        let summary = mesh.write_if(Box::new(sink), control, &may_finish)?;
        let seconds = Seconds {
            total: start.elapsed().as_secs_f64(),
            open: (opened - start).as_secs_f64(),
            tiles: (triangulated - opened).as_secs_f64(),
            write: triangulated.elapsed().as_secs_f64(),
            threads: mesh.times(),
        };
        Ok((Report::new(&field, &params, &args.output, &summary, seconds, mesh.spool_bytes()), mesh.tiles_found()))
    };
    match (run(), kept) {
        (Ok((report, found)), Some(kept)) => {
            kept.finish();
            Ok(report.tiles_found(found))
        }
        (Ok((report, _)), None) => Ok(report),
        (Err(error), Some(kept)) => Err(kept.explain(error)),
        (Err(error), None) => Err(Failure::from(error)),
    }
}

/// What the file says of itself. Nothing here depends on the machine or the time.
fn comments(raster: &Raster, args: &SimplifyArgs) -> Vec<String> {
    let source = args.input.file_name().map(Path::new).unwrap_or(&args.input);
    vec![
        format!("made by terrabite {}", env!("CARGO_PKG_VERSION")),
        format!("source {}", source.display()),
        format!("max_error {}", args.max_error),
        format!("crs {}", raster.crs_name()),
    ]
}
