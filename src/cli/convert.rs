//! `convert`: a mesh in another format.

use std::path::PathBuf;
use std::process::ExitCode;

use super::coordinates::ConvertedArgs;
use super::format_options::FormatArgs;
use super::progress::Bars;
use super::{Failure, GDAL_CACHE, output_format, print, warnings};
use crate::formats;
use crate::raster::bound_gdal_cache;
use crate::run::{ConvertReport, ConvertRequest, convert};

/// Write a mesh in another format, without the raster
///
/// Coordinates stay as they are, bit for bit, unless the format holds only single precision or metres, or others are asked for; what
/// heights lose then is added to the tolerance that the mesh names. What the format does not keep is told.
#[derive(Debug, clap::Args)]
pub(crate) struct ConvertArgs {
    /// The mesh, in any of the formats
    input: PathBuf,
    /// The mesh to be made, in the format that its extension names
    output: PathBuf,
    #[command(flatten)]
    format: FormatArgs,
    #[command(flatten)]
    coordinates: ConvertedArgs,
    /// The folder of temporary files [default: the system's]
    #[arg(long, help_heading = "Run", value_name = "DIR")]
    temp_dir: Option<PathBuf>,
    /// Replace an existing output
    #[arg(long, help_heading = "Run")]
    overwrite: bool,
    /// Print nothing but errors
    #[arg(long, help_heading = "Run", short, conflicts_with = "json")]
    pub(super) quiet: bool,
    /// Print the report as JSON
    #[arg(long, help_heading = "Run")]
    json: bool,
}

pub(crate) fn run(args: &ConvertArgs) -> Result<ExitCode, Failure> {
    let named = output_format::of(&args.output, args.format.name(), output_format::MESHES)?.name;
    let format = formats::by_name(named);
    let coordinates = args.coordinates.coordinates(format)?;
    bound_gdal_cache(GDAL_CACHE);
    let bars = Bars::new(args.quiet);
    let request = ConvertRequest {
        format,
        sink: args.format.sink(),
        coordinates,
        overwrite: args.overwrite,
        temp_dir: args.temp_dir.clone(),
        ..ConvertRequest::new(&args.input, &args.output)
    };
    let report = convert(&request, &bars.control())?;
    drop(bars);
    let report = ConvertReport { warnings: warnings::take(), ..report };
    if args.json {
        print::json(&report)?;
    } else if !args.quiet {
        warnings::print(&report.warnings);
        print::report(&print::aligned(&report.lines()))?;
    }
    Ok(ExitCode::SUCCESS)
}
