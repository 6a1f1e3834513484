//! `synth`: makes a raster.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::progress::Bars;
use super::values::Size;
use super::{Failure, GDAL_CACHE, output_format, print, values};
use crate::raster::bound_gdal_cache;
use crate::synth::{BlockLayout, Compression, StoredAs, SynthOptions, SynthReport, TerrainOptions};

/// Make a raster of fractal terrain
///
/// Heights depend on the seed, the options of the ground and the place alone: a smaller raster is the upper left
/// corner of a larger one. The ground has the same mixture of landforms at every size.
#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// The GeoTIFF to make
    #[arg(value_name = "OUT.tif")]
    output: PathBuf,
    /// The format of the raster, whatever it is called [default: what its extension says]
    #[arg(long, value_parser = output_format::names(output_format::RASTERS))]
    format: Option<String>,
    /// Samples across and down
    #[arg(long, value_name = "WxH", value_parser = values::size)]
    size: Size,
    /// Every seed is another world
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
    /// Sample type
    #[arg(long = "type", value_enum, ignore_case = true, default_value_t = TypeArg::Float32)]
    sample_type: TypeArg,
    /// Compression; the predictor follows from the sample type
    #[arg(long, value_enum, ignore_case = true, default_value_t = CompressArg::Deflate)]
    compress: CompressArg,
    /// Edge of the tiles in samples, a multiple of 16
    #[arg(long, default_value_t = 256, value_name = "N")]
    block: usize,
    /// Strips of ROWS rows instead of tiles
    #[arg(long, conflicts_with = "block", value_name = "ROWS")]
    strip: Option<usize>,
    /// Distance between samples on the map; heights do not change with it
    #[arg(long, default_value_t = 10.0, value_name = "METRES")]
    cell: f64,
    /// Height of the highest mountains above the lowest plains, about
    #[arg(long, default_value_t = 1500.0, value_name = "METRES")]
    relief: f64,
    /// From rolling (0) to rugged (1)
    #[arg(long, default_value_t = 0.5, value_name = "0..1")]
    roughness: f64,
    /// Share of the area that is lake, each exactly flat
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    lakes: f64,
    /// Share of the area without heights
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    nodata_share: f64,
    /// Cut the ground by faults with vertical steps
    #[arg(long)]
    cliffs: bool,
    /// Write a big-endian file
    #[arg(long)]
    big_endian: bool,
    /// Replace an existing file
    #[arg(long)]
    overwrite: bool,
    /// Print nothing
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum TypeArg {
    Int16,
    Float32,
    Float64,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum CompressArg {
    None,
    Deflate,
    Lzw,
    Zstd,
}

pub(crate) fn run(args: &SynthArgs) -> Result<ExitCode, Failure> {
    output_format::of(&args.output, args.format.as_deref(), output_format::RASTERS)?;
    bound_gdal_cache(GDAL_CACHE);
    let started = std::time::Instant::now();
    let bars = Bars::new(args.quiet);
    let report = crate::synth::synth(&args.output, &args.options(), &bars.control())?;
    drop(bars);
    if !args.quiet {
        print::report(&summary(args, &report, started.elapsed().as_secs_f64()))?;
    }
    Ok(ExitCode::SUCCESS)
}

impl SynthArgs {
    fn options(&self) -> SynthOptions {
        SynthOptions {
            width: self.size.width,
            height: self.size.height,
            terrain: TerrainOptions {
                seed: self.seed,
                relief_m: self.relief,
                roughness: self.roughness,
                lakes: self.lakes,
                nodata_share: self.nodata_share,
                cliffs: self.cliffs,
            },
            stored_as: match self.sample_type {
                TypeArg::Int16 => StoredAs::Int16,
                TypeArg::Float32 => StoredAs::Float32,
                TypeArg::Float64 => StoredAs::Float64,
            },
            layout: self.strip.map_or(BlockLayout::Tiles(self.block), BlockLayout::Strips),
            compression: match self.compress {
                CompressArg::None => Compression::None,
                CompressArg::Deflate => Compression::Deflate,
                CompressArg::Lzw => Compression::Lzw,
                CompressArg::Zstd => Compression::Zstd,
            },
            cell_m: self.cell,
            big_endian: self.big_endian,
            overwrite: self.overwrite,
        }
    }
}

fn summary(args: &SynthArgs, report: &SynthReport, seconds: f64) -> String {
    let nodata = match report.nodata_samples {
        0 => String::new(),
        n => format!(", {:.2} % nodata", 100.0 * n as f64 / report.samples as f64),
    };
    format!(
        "{}: {} × {} samples, heights {:.1} to {:.1} m{nodata}; {seconds:.1} s, {:.1} million samples/s",
        args.output.display(),
        args.size.width,
        args.size.height,
        report.lowest_m,
        report.highest_m,
        report.samples as f64 / seconds / 1e6,
    )
}
