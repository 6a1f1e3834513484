//! `info`: what is known of a raster, and what simplifying it will need.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::ValueEnum;
use serde_json::Value;

use super::attributes::AttributeArgs;
use super::combinations::Asked;
use super::importance::ImportanceArgs;
use super::input::InputArgs;
use super::progress::Bars;
use super::{Failure, GDAL_CACHE, print, values, warnings};
use crate::base::decimal::Decimal;
use crate::base::features::Feature;
use crate::base::warning::{Warning, WarningCode, Warnings};
use crate::base::{RasterError, Reference};
use crate::job::rules::{default_engine, default_quality};
use crate::job::{DEFAULT_TILE, Params, Plan, Quality};
use crate::raster::bound_gdal_cache;
use crate::run::report::{BinaryBytes, band, heights as unit_of_heights, place};
use crate::run::{Description, Info, Input, Request, describe};

/// Describe a raster, and what simplifying it will need
#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// The raster: a file, or any name GDAL opens
    #[arg(value_name = "RASTER")]
    raster: PathBuf,
    #[command(flatten)]
    input: InputArgs,
    #[command(flatten)]
    attributes: AttributeArgs,
    #[command(flatten)]
    importance: ImportanceArgs,
    /// As simplify has it: the largest voids that are filled, in samples
    #[arg(long, value_name = "SAMPLES", value_parser = values::count, default_value_t = 0)]
    fill_holes: u64,
    /// As simplify has it: the side of the tiles
    #[arg(long, value_name = "CELLS", default_value_t = DEFAULT_TILE)]
    tile: usize,
    /// As simplify has it: the most memory to use [default: a quarter of the machine's, at most 2 GiB]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    memory: Option<u64>,
    /// As simplify has it: threads to work with [default: as many as the machine has cores]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<NonZeroUsize>,
    /// Whether to look at all samples, for the range of heights and for warnings about them
    #[arg(long, value_enum, default_value_t = LookArg::Auto)]
    look: LookArg,
    /// Print the description as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LookArg {
    /// Where there are at most 2^28 (268 million)
    Auto,
    Always,
    Never,
}

impl LookArg {
    /// The most samples that are looked at without being asked: a few seconds' work.
    const MOST: u64 = 1 << 28;

    fn is_wanted(self, samples: u64) -> bool {
        match self {
            LookArg::Auto => samples <= LookArg::MOST,
            LookArg::Always => true,
            LookArg::Never => false,
        }
    }
}

/// The description as it is printed by `--json`.
#[derive(serde::Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    info: &'a Info,
    warnings: Warnings,
}

impl InfoArgs {
    /// What the options ask for.
    fn asked(&self) -> Asked {
        let mut asked = self.input.asked();
        self.attributes.ask(&mut asked);
        self.importance.ask(&mut asked);
        asked
    }

    /// The run that is meant.
    fn request(&self) -> Request<'static> {
        let input = Input::Raster { path: self.raster.clone(), view: self.input.view() };
        let features = self.asked().features();
        let quality = default_quality(features);
        let features = if quality == Quality::None { features } else { features.with(Feature::Polishing) };
        let params = Params { tile: self.tile, quality, engine: default_engine(features), ..Params::new(0.0) };
        Request {
            params,
            attributes: self.attributes.attributes(),
            importance: self.importance.input(),
            fill_voids: self.fill_holes,
            memory: self.memory,
            threads: self.threads,
            ..Request::new(input, "", 0.0)
        }
    }
}

pub(crate) fn run(args: &InfoArgs) -> Result<ExitCode, Failure> {
    args.asked().check_samples()?;
    bound_gdal_cache(GDAL_CACHE);
    let bars = Bars::new(args.json);
    let Description { info, picture, .. } =
        describe(&args.request(), |samples| args.look.is_wanted(samples), &bars.control())?;
    warnings::collect(picture.map(|error| picture_warning(&args.raster, error)));
    drop(bars);
    if args.json {
        print::json(&Report { info: &info, warnings: warnings::take() })?;
    } else {
        warnings::print(&warnings::take());
        print::report(&print::aligned(&lines(&info, args.asked().features().has(Feature::Image))))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// That `simplify` refuses the raster, as a warning.
fn picture_warning(file: &Path, error: RasterError) -> Warning {
    let message = Failure::from(error).message().trim_start_matches(&format!("{}: ", file.display())).to_string();
    Warning { code: WarningCode::Picture, file: file.to_path_buf(), count: 1, message }
}

fn lines(info: &Info, is_image: bool) -> Vec<(&'static str, String)> {
    vec![
        ("file", info.file.clone()),
        ("format", format!("{}, {}", info.driver, band(info.band, info.bands, &info.band_description))),
        ("size", size(info)),
        ("type", info.sample_type.to_string()),
        ("heights", heights(info)),
        ("range", range(info, is_image)),
        ("nodata", nodata(info)),
        ("CRS", info.crs.clone()),
        ("map", place(&info.reference)),
        ("height unit", heights_in(&info.reference)),
        ("pixels", pixels(&info.reference)),
        ("geotransform", geotransform(info)),
        ("blocks", format!("{} × {} samples", info.block.0, info.block.1)),
        ("compression", info.compression.as_deref().unwrap_or("none").to_string()),
        ("in place", in_place(info)),
        ("disk", disk(info)),
        ("output", format!("about {} as PLY, {}", BinaryBytes(info.estimate.output_bytes), density(info))),
        ("memory", memory(info)),
    ]
}

fn heights_in(reference: &Reference) -> String {
    let said = unit_of_heights(reference);
    if said.is_empty() { "not said".to_string() } else { said }
}

fn pixels(reference: &Reference) -> String {
    let said = match reference.pixel_is.as_str() {
        "" => "not said to be areas or points",
        "Point" => "points, for which GDAL moves the geotransform by half a pixel",
        _ => "areas",
    };
    format!("{said}; samples stand at their centres")
}

fn size(info: &Info) -> String {
    let size = format!("{} × {} samples", info.width, info.height);
    match info.window {
        None => size,
        Some([column, row, ..]) => {
            let (width, height) = info.whole_size;
            format!("{size} from column {column}, row {row} on, of {width} × {height}")
        }
    }
}

fn heights(info: &Info) -> String {
    if let Some(encoding) = info.encoding {
        return format!("colours, encoding {}", encoding.name());
    }
    if info.scale == 1.0 && info.offset == 0.0 {
        return "as stored".to_string();
    }
    format!("stored value × {} + {}", info.scale, info.offset)
}

fn range(info: &Info, is_image: bool) -> String {
    if is_image {
        return "an image has no heights".to_string();
    }
    let missing = match info.missing_samples {
        None => return "not looked for; --look always does".to_string(),
        Some(0) => String::new(),
        Some(1) => ", 1 sample is missing".to_string(),
        Some(count) => format!(", {count} samples are missing"),
    };
    match info.height_range {
        Some([min, max]) => format!("{} to {}{missing}", Decimal(min), Decimal(max)),
        None => "no sample has a height".to_string(),
    }
}

fn nodata(info: &Info) -> String {
    let word = |mark: &Value| match mark {
        Value::String(word) => word.clone(),
        // Whole numbers are stored as doubles: -32768, not -32768.0.
        number => number.as_f64().filter(|_| number.is_f64()).map_or(number.to_string(), |v| Decimal(v).to_string()),
    };
    let tag = (!info.marks.is_empty()).then(|| info.marks.iter().map(word).collect::<Vec<_>>().join(", "));
    let tagged_nan = tag.as_deref() == Some("nan");
    let nan = (info.nan_possible && !tagged_nan).then(|| "NaN where it occurs".to_string());
    let mask = info.mask.then(|| "what a mask or alpha band says".to_string());
    let valid = info.valid_range.map(|v| format!("heights beyond {} to {}", Decimal(v.min), Decimal(v.max)));
    let kinds: Vec<String> = [tag, nan, mask, valid].into_iter().flatten().collect();
    if kinds.is_empty() { "none".to_string() } else { kinds.join(", ") }
}

fn geotransform(info: &Info) -> String {
    let numbers = info.geotransform.map(|c| c.to_string()).join(", ");
    let numbers = if info.window.is_some() { format!("{numbers} (of the whole raster)") } else { numbers };
    if info.georeferenced { numbers } else { format!("{numbers} (default: the raster has none)") }
}

fn in_place(info: &Info) -> String {
    match &info.not_in_place_because {
        None => "yes, its samples are mapped where they lie".to_string(),
        Some(reason) if info.read_by_windows => format!("no, it is read by windows: {reason}"),
        Some(reason) => format!("no, it is decoded first: {reason}"),
    }
}

fn disk(info: &Info) -> String {
    let spool = format!("about {} for finished tiles, {}", BinaryBytes(info.estimate.spool_bytes), density(info));
    match info.estimate.field_bytes {
        0 => format!("temporarily {spool}"),
        field => format!("temporarily {} for the decoded samples, {spool}", BinaryBytes(field)),
    }
}

fn density(info: &Info) -> String {
    format!("at {:.0} samples per triangle", info.estimate.samples_per_triangle)
}

fn memory(info: &Info) -> String {
    match info.memory {
        None => "more than the default budget; choose a larger --memory or a smaller --tile".to_string(),
        Some(Plan { threads: 1, needed_bytes, .. }) => format!("up to {} with 1 thread", BinaryBytes(needed_bytes)),
        Some(Plan { threads, needed_bytes, .. }) => {
            format!("up to {} with {threads} threads", BinaryBytes(needed_bytes))
        }
    }
}
