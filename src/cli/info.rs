use std::path::PathBuf;
use std::process::ExitCode;

use clap::ValueEnum;

use indicatif::BinaryBytes;
use serde_json::Value;

use super::input::InputArgs;
use super::progress::Bars;
use super::simplify_map::{heights as unit_of_heights, place};
use super::warnings::Shown;
use super::{Failure, GDAL_CACHE, print, warnings};
use crate::base::decimal::Decimal;
use crate::base::warning::{Warning, WarningCode};
use crate::base::{RasterError, Reference};
use crate::job::Plan;
use crate::raster::{Raster, View, bound_gdal_cache};
use crate::run::info::Info;
use crate::run::look::look;

/// Describe a raster, and what simplifying it will need
#[derive(Debug, clap::Args)]
pub(crate) struct InfoArgs {
    /// The raster: a file, or any name GDAL opens
    #[arg(value_name = "RASTER")]
    raster: PathBuf,
    #[command(flatten)]
    input: InputArgs,
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
    warnings: Shown,
}

pub(crate) fn run(args: &InfoArgs) -> Result<ExitCode, Failure> {
    args.input.asked().check_samples()?;
    bound_gdal_cache(GDAL_CACHE);
    let bars = Bars::new(args.json);
    let view = View { accept_pictures: true, ..args.input.view() };
    let raster = view.open(&args.raster, &bars.control().cancel)?;
    if view.band.is_none() {
        warnings::collect(raster.expect_heights().err().map(|error| picture(&raster, error)));
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let info = Info::of(&raster, threads)?;
    let samples = info.width as u64 * info.height as u64;
    let info = if !args.look.is_wanted(samples) {
        info
    } else {
        let band = raster.to_band()?;
        let look = look(&band, &bars.control())?;
        warnings::collect(look.warnings(&band));
        info.with_look(&look)
    };
    drop(bars);
    warnings::collect(raster.warnings().iter().cloned());
    if args.json {
        print::json(&Report { info: &info, warnings: warnings::take() })?;
    } else {
        warnings::take().print();
        print::report(&print::aligned(&lines(&info)))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// That `simplify` refuses the raster, as a warning.
fn picture(raster: &Raster, error: RasterError) -> Warning {
    let (file, name) = (raster.path().to_path_buf(), raster.path().display().to_string());
    let message = Failure::from(error).message().trim_start_matches(&format!("{name}: ")).to_string();
    Warning { code: WarningCode::Picture, file, count: 1, message }
}

fn lines(info: &Info) -> Vec<(&'static str, String)> {
    vec![
        ("file", info.file.clone()),
        ("format", format!("{}, {}", info.driver, print::band(info.band, info.bands, &info.band_description))),
        ("size", size(info)),
        ("type", info.sample_type.to_string()),
        ("heights", heights(info)),
        ("range", range(info)),
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

fn range(info: &Info) -> String {
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
