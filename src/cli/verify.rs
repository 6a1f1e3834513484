use std::path::PathBuf;
use std::process::ExitCode;

use crate::control::Control;
use crate::raster::Raster;
use crate::verify::{Verdict, VerifyError, VerifyOptions, verify};

/// Judge a mesh against its raster: vertical errors, coverage, cracks, folds.
///
/// Reads the raster and the written file, and nothing else. Exit code 0: the mesh passes, 1: it fails.
#[derive(Debug, clap::Args)]
pub(crate) struct VerifyArgs {
    /// The raster the mesh was made from
    raster: PathBuf,
    /// The mesh, a PLY file
    mesh: PathBuf,
    /// Vertical distance allowed at every sample, in the raster's unit
    #[arg(long, value_name = "E", value_parser = max_error, allow_negative_numbers = true)]
    max_error: f64,
    /// Raster band, from 1
    #[arg(long, value_name = "N", default_value_t = 1)]
    band: usize,
    /// Where temporary files go (about 200 bytes per triangle)
    #[arg(long, value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Print the verdict as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing; the exit code tells
    #[arg(long, short, conflicts_with = "json")]
    quiet: bool,
}

/// The verdict as it is printed by `--json`.
#[derive(serde::Serialize)]
struct Report<'a> {
    passed: bool,
    failures: Vec<String>,
    #[serde(flatten)]
    verdict: &'a Verdict,
}

/// Runs the command: 0 if the mesh passes, 1 if it fails. Errors are the caller's to print.
pub(crate) fn run(args: &VerifyArgs, control: &Control<'_>) -> Result<ExitCode, VerifyError> {
    let raster = Raster::open(&args.raster, args.band)?;
    let options = VerifyOptions { max_error: args.max_error, temp_dir: args.temp_dir.clone() };
    let verdict = verify(&raster, &args.mesh, &options, control)?;
    if !args.quiet {
        print(&text(&verdict, args.json));
    }
    Ok(if verdict.passes() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn text(verdict: &Verdict, json: bool) -> String {
    if !json {
        return verdict.to_string();
    }
    let report = Report { passed: verdict.passes(), failures: verdict.failures(), verdict };
    serde_json::to_string_pretty(&report).expect("a verdict has nothing that JSON cannot say")
}

/// A pipe that was closed early is no error: the exit code still tells.
fn print(text: &str) {
    use std::io::Write;
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn max_error(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("expected a finite number of 0 or more".to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_are_finite_and_not_negative() {
        assert_eq!((max_error("0"), max_error("0.1")), (Ok(0.0), Ok(0.1)));
        for text in ["-1", "nan", "inf", "1e999", "", "1m"] {
            assert!(max_error(text).is_err(), "{text}");
        }
    }
}
