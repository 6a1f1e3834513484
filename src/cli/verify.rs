//! `verify`: judges a mesh.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use super::attributes::AttributeArgs;
use super::breaklines::BreaklineArgs;
use super::combinations::Asked;
use super::importance::ImportanceArgs;
use super::input::InputArgs;
use super::progress::Bars;
use super::qa::QaArgs;
use super::{Failure, print, values, warnings};
use crate::base::features::Feature;
use crate::run::{Input, VerifyReport, VerifyRequest, verify};

/// Judge a mesh against its raster: vertical errors, coverage, cracks, folds.
///
/// Reads the raster and the written file, and what options name. Where the raster has samples without a height (its nodata
/// tag, NaN, a mask or alpha band, --cutline), the mesh must cover exactly the cells with four heights and half of those with three.
/// Exit code 0: the mesh passes, 1: it fails.
#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// The raster the mesh was made from
    raster: PathBuf,
    /// The mesh, in any of the formats that simplify writes
    mesh: PathBuf,
    /// Vertical distance allowed at every sample, in the raster's unit
    #[arg(long, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    max_error: f64,
    /// Judge the surface between samples, too. F is a number from 1 on, or inf. On the side between two neighbouring samples of a
    /// row or column the surface must lie between their heights, give or take F × E; inside a cell between the heights of its
    /// corners, give or take the same. inf judges samples alone
    #[arg(long, value_name = "F", value_parser = values::max_stray, allow_hyphen_values = true, default_value = "inf")]
    max_stray: f64,
    #[command(flatten)]
    input: InputArgs,
    /// The mesh must cover voids of at most this many samples, at any height. A void is a group of missing samples, diagonal
    /// neighbours included, with none in the first or last row or column; 0 means that no void is filled
    #[arg(long, value_name = "SAMPLES", value_parser = values::count, default_value_t = 0)]
    fill_holes: u64,
    /// The mesh may end short of the ground within CELLS columns and rows of a missing sample (up to 1000). Cells with such a
    /// sample for a corner may be bare; all others must be covered
    #[arg(long, value_name = "CELLS", value_parser = clap::value_parser!(u32).range(0..=1000), default_value_t = 0)]
    trim: u32,
    #[command(flatten)]
    attributes: AttributeArgs,
    #[command(flatten)]
    importance: ImportanceArgs,
    #[command(flatten)]
    breaklines: BreaklineArgs,
    #[command(flatten)]
    qa: QaArgs,
    /// Threads to work with [default: as many as the machine has cores]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<NonZeroUsize>,
    /// Where temporary files go (about 200 bytes per triangle, and 100 per segment of lines)
    #[arg(long, value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Print the verdict as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing; the exit code tells
    #[arg(long, short, conflicts_with = "json")]
    pub(super) quiet: bool,
}

impl VerifyArgs {
    /// What the options ask for.
    fn asked(&self) -> Asked {
        let mut asked = self.input.asked();
        self.attributes.ask(&mut asked);
        self.importance.ask(&mut asked);
        self.breaklines.ask(&mut asked);
        asked.add(Feature::MaxStray, self.max_stray.is_finite());
        asked.add(Feature::Trim, self.trim > 0);
        asked.add(Feature::FilledVoids, self.fill_holes > 0);
        asked
    }
}

pub(crate) fn run(args: &VerifyArgs) -> Result<ExitCode, Failure> {
    args.asked().check_samples()?;
    let bars = Bars::new(args.quiet);
    let mut view = args.input.view();
    let lines = args.breaklines.inputs(&mut view);
    let request = VerifyRequest {
        max_stray: args.max_stray.is_finite().then_some(args.max_stray),
        attributes: args.attributes.attributes(),
        importance: args.importance.input(),
        fill_voids: args.fill_holes,
        trim: args.trim,
        lines,
        threads: args.threads,
        temp_dir: args.temp_dir.clone(),
        extras: args.qa.extras(),
        ..VerifyRequest::new(Input::Raster { path: args.raster.clone(), view }, &args.mesh, args.max_error)
    };
    args.qa.check(&request)?;
    let report = verify(&request, &bars.control())?;
    drop(bars);
    let report = VerifyReport { warnings: warnings::take(), ..report };
    args.qa.write(&report, &request)?;
    if args.json {
        print::json(&report)?;
    } else if !args.quiet {
        warnings::print(&report.warnings);
        print::report(&report.verdict.to_string())?;
        if let Some(checkpoints) = &report.checkpoints {
            print::report(&checkpoints.to_string())?;
        }
    }
    Ok(if report.passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
