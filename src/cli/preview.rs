//! `preview`: a picture of a mesh above its raster.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};

use super::importance::ImportanceArgs;
use super::input::InputArgs;
use super::progress::Bars;
use super::values::Size;
use super::{Failure, GDAL_CACHE, output_format, print, values, warnings};
use crate::base::features::Feature;
use crate::preview::{Degree, Mode, PreviewOptions, VerticalScale};
use crate::raster::{View, bound_gdal_cache};

/// Draw a mesh above its raster
///
/// The picture has the raster's orientation: row 0 is at the top. It is for looking; what a mesh is worth is told by
/// `terrabite verify`.
#[derive(Debug, Args)]
pub(crate) struct PreviewArgs {
    /// The raster
    raster: PathBuf,
    /// The mesh made from it, in any of the formats that simplify writes
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// The picture to make
    #[arg(value_name = "OUT.png")]
    output: PathBuf,
    /// The format of the picture, whatever it is called [default: what its extension says]
    #[arg(long, value_parser = output_format::names(output_format::PICTURES))]
    format: Option<String>,
    /// What to draw
    #[arg(long, value_enum, default_value_t = ModeArg::Hillshade)]
    mode: ModeArg,
    /// The largest picture, in pixels; the legend is added to it
    #[arg(long, value_name = "WxH", default_value = "1024x1024", value_parser = values::size)]
    size: Size,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    importance: ImportanceArgs,
    /// The raster is an image without heights: they are 0
    #[arg(long, alias = "planar")]
    image: bool,
    /// The tolerance: the end of the colour scale of `--mode error`
    #[arg(long, value_name = "E", value_parser = values::max_error, allow_hyphen_values = true)]
    max_error: Option<f64>,
    /// Multiply heights by this for shading; 1 shows true proportions, a degree as long as it is in the middle of the raster
    /// [default: such that 19 of 20 slopes are shaded no steeper than 35°; at least 1, where the CRS says how long its unit is]
    #[arg(long, value_name = "FACTOR")]
    vertical_exaggeration: Option<f64>,
    /// Replace an existing picture
    #[arg(long)]
    overwrite: bool,
    /// Print nothing
    #[arg(long, short)]
    pub(super) quiet: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ModeArg {
    /// The triangles, each shaded flat
    Hillshade,
    /// Shaded triangles and their edges
    Wireframe,
    /// Distance of the surface from the samples, in colours
    Error,
    /// The raster to the left, triangles and edges to the right
    SideBySide,
    /// The colours of the vertices, blended across the triangles
    Colour,
}

pub(crate) fn run(args: &PreviewArgs) -> Result<ExitCode, Failure> {
    output_format::of(&args.output, args.format.as_deref(), output_format::PICTURES)?;
    let mut asked = args.input.asked();
    args.importance.ask(&mut asked);
    asked.add(Feature::Image, args.image);
    asked.check_samples()?;
    bound_gdal_cache(GDAL_CACHE);
    let options = PreviewOptions {
        mode: match args.mode {
            ModeArg::Hillshade => Mode::Hillshade,
            ModeArg::Wireframe => Mode::Wireframe,
            ModeArg::Error => Mode::Error,
            ModeArg::SideBySide => Mode::SideBySide,
            ModeArg::Colour => Mode::Colour,
        },
        // The colours of a mesh may be all that there is.
        view: View { accept_pictures: args.image || matches!(args.mode, ModeArg::Colour), ..args.input.view() },
        importance: args.importance.source(),
        image: args.image,
        size: (args.size.width, args.size.height),
        max_error: args.max_error,
        exaggeration: args.vertical_exaggeration,
        overwrite: args.overwrite,
    };
    let bars = Bars::new(args.quiet);
    let report = crate::preview::preview(&args.raster, &args.mesh, &args.output, &options, &bars.control())?;
    drop(bars);
    warnings::collect(report.warnings);
    if !args.quiet {
        warnings::print(&warnings::take());
        let largest = report.largest_error.map(|e| format!(", largest error {e:.6}")).unwrap_or_default();
        let size = format!("{} × {} pixels", report.width, report.height);
        let largest =
            if report.triangles == 0 { ": none lies over this part of the raster".to_string() } else { largest };
        print::report(&format!("{}: {size}, {} triangles{largest}", args.output.display(), report.triangles))?;
        if let Some(scale) = &report.vertical_scale {
            print::report(&in_words(scale))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn in_words(scale: &VerticalScale) -> String {
    let chosen = if scale.chosen { " (chosen)" } else { "" };
    let place = match scale.degree {
        Some(Degree { latitude, of_longitude, of_latitude }) => {
            let side = if latitude < 0.0 { "S" } else { "N" };
            let (x, y) = (of_longitude / 1000.0, of_latitude / 1000.0);
            format!(", 1° = {x:.1} km × {y:.1} km at {:.1}° {side}", latitude.abs())
        }
        None if scale.to_scale => String::new(),
        None => ", with the unit of heights for x and y, whose own is not known".to_string(),
    };
    format!("vertical scale {}{chosen}{place}", scale.factor)
}
