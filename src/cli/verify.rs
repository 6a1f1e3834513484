use std::path::PathBuf;
use std::process::ExitCode;

use super::channels::ChannelArgs;
use super::combinations::Asked;
use super::importance::ImportanceArgs;
use super::input::InputArgs;
use super::progress::Bars;
use super::warnings::Shown;
use super::{Failure, GDAL_CACHE, print, values, warnings};
use crate::job::features::Feature;
use crate::raster::{Raster, bound_gdal_cache};
use crate::run::look::look;
use crate::verify::{GroundOptions, Verdict, VerifyOptions, verify_ground};

/// Judge a mesh against its raster: vertical errors, coverage, cracks, folds.
///
/// Reads the raster and the written file, and what options name. Where the raster has samples without a height (its nodata
/// tag, NaN, a mask or alpha band, --cutline), the mesh must cover exactly the cells with four heights and half of those with three.
/// Exit code 0: the mesh passes, 1: it fails.
#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// The raster the mesh was made from
    raster: PathBuf,
    /// The mesh, a PLY file
    mesh: PathBuf,
    /// Vertical distance allowed at every sample, in the raster's unit
    #[arg(long, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    max_error: f64,
    #[command(flatten)]
    input: InputArgs,
    /// Holes of at most so many samples without a height are to be bridged: covered, at any height. A hole is a group of
    /// such samples, diagonal neighbours included, with none in the first or last row or column; 0 bridges none
    #[arg(long, value_name = "SAMPLES", value_parser = values::count, default_value_t = 0)]
    fill_holes: u64,
    /// The mesh may end short of the ground within CELLS columns and rows of a missing sample (up to 1000). Cells with such a
    /// sample for a corner may be bare; all others must be covered
    #[arg(long, value_name = "CELLS", value_parser = clap::value_parser!(u32).range(0..=1000), default_value_t = 0)]
    trim: u32,
    #[command(flatten)]
    channels: ChannelArgs,
    #[command(flatten)]
    importance: ImportanceArgs,
    /// Where temporary files go (about 200 bytes per triangle)
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
        self.channels.ask(&mut asked);
        self.importance.ask(&mut asked);
        asked.add(Feature::Trim, self.trim > 0);
        asked.add(Feature::FilledVoids, self.fill_holes > 0);
        asked
    }
}

/// The verdict as it is printed by `--json`.
#[derive(serde::Serialize)]
struct Report<'a> {
    passed: bool,
    failures: Vec<String>,
    warnings: Shown,
    #[serde(flatten)]
    verdict: &'a Verdict,
}

pub(crate) fn run(args: &VerifyArgs) -> Result<ExitCode, Failure> {
    args.asked().check_samples()?;
    bound_gdal_cache(GDAL_CACHE);
    let bars = Bars::new(args.quiet);
    let (raster, channels) = args.channels.open(&args.raster, args.input.view(), &bars.control().cancel)?;
    let importance = args.importance.open(&raster)?;
    warnings::collect([Some(&raster), importance.as_ref()].into_iter().flatten().flat_map(Raster::warnings).cloned());
    let band = raster.to_band()?;
    let importance = importance.as_ref().map(Raster::to_band).transpose()?;
    let options =
        VerifyOptions { max_error: args.max_error, importance: importance.as_ref(), temp_dir: args.temp_dir.clone() };
    let ground = GroundOptions { fill_holes: args.fill_holes, trim: args.trim };
    let is_flat = channels.as_ref().is_some_and(|w| w.planar);
    let verdict = verify_ground(&band, &args.mesh, &options, ground, channels.as_ref(), &bars.control())?;
    if verdict.nodata + verdict.bridged > 0 && !is_flat {
        warnings::collect(look(&band, &bars.control())?.warnings(&band));
    }
    drop(bars);
    if args.json {
        let report = Report {
            passed: verdict.passes(),
            failures: verdict.failures(),
            warnings: warnings::take(),
            verdict: &verdict,
        };
        print::json(&report)?;
    } else if !args.quiet {
        warnings::take().print();
        print::report(&verdict.to_string())?;
    }
    Ok(if verdict.passes() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
