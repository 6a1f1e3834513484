//! `tiles`: makes a pyramid of terrain tiles.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use super::failure::kept;
use super::input::InputArgs;
use super::progress::Bars;
use super::{Failure, print, values, warnings};
use crate::field::FieldError;
use crate::job::Error;
use crate::pyramid::{BoundBy, EARLIER_SET, PyramidError, TilesRequest, VoidAs, tiles};
use crate::raster::GeodesyError;
use crate::run::Fate;

/// Make a pyramid of terrain tiles (quantized-mesh) for CesiumJS and others
///
/// Every level keeps a stated error against the samples of a fixed grid of longitudes and latitudes that is not coarser than
/// the raster; the largest allowed and the largest found are reported level by level. Tiles of a level share every vertex of
/// their borders. OUT is a folder: nothing, an empty one, or with --overwrite an earlier set of tiles.
#[derive(Debug, clap::Args)]
pub(crate) struct TilesArgs {
    /// The raster; its CRS is geographic or projected
    raster: PathBuf,
    /// The folder to make
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Keep what is finished in this folder: after an interrupt, a crash or a power cut the same command continues there
    #[arg(long, value_name = "DIR")]
    work_dir: Option<PathBuf>,
    /// Keep the work dir, with all its tiles, when the set is there
    #[arg(long, hide_short_help = true, requires = "work_dir")]
    keep_work_dir: bool,
    /// Replace an earlier set of tiles
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    options: TilesOptions,
    #[command(flatten)]
    pub(super) common: CommonArgs,
}

/// What decides tiles, beside the raster and how it is looked at.
#[derive(Debug, clap::Args)]
pub(crate) struct TilesOptions {
    /// The largest error of the finest level, in metres. Levels above it have twice the error of the next finer one, but
    /// never more than the client takes for granted
    #[arg(long, value_name = "METRES", value_parser = error_in_metres)]
    max_error: f64,
    /// The finest level [default: the coarser of the first at which clients expect no more than --max-error, and the first
    /// whose tiles are at most 128 samples wide]
    #[arg(long, value_name = "LEVEL")]
    max_level: Option<u32>,
    /// No level's error is larger than F times what clients expect of it
    #[arg(long, hide_short_help = true, value_name = "F", default_value_t = 1.0, value_parser = error_in_metres)]
    error_factor: f64,
    /// Cells of the grid where the raster's samples ask for one: 1, 2 or 4
    #[arg(long, hide_short_help = true, value_name = "N", default_value = "1", value_parser = ["1", "2", "4"])]
    grid_factor: String,
    /// The vertical CRS of the heights, such as EPSG:5773 (EGM96), in place of the raster's. Without one heights are taken as
    /// ellipsoidal
    #[arg(long, value_name = "CRS")]
    vertical_crs: Option<String>,
    /// The height outside of the raster, and in its voids without --void-as, in metres above the ellipsoid
    #[arg(long, value_name = "METRES", default_value_t = 0.0, value_parser = height, allow_hyphen_values = true)]
    outside: f64,
    /// Where the raster has voids: `hole` leaves triangles out that lie over them, a number is a height in metres above the ellipsoid
    /// [default: the height outside]
    #[arg(long, hide_short_help = true, value_name = "hole|METRES", value_parser = void_as, allow_hyphen_values = true)]
    void_as: Option<VoidAs>,
    /// Have CesiumJS draw heights as they are: it rounds tiles of less than 4,095 m to 12 bits in all directions. Heights get steps
    /// of 1/8 m or more (docs/tiles.md)
    #[arg(long, hide_short_help = true)]
    fine_heights: bool,
    /// How far the surface may stray between samples of the grid: where an edge crosses the side between two neighbouring samples of a row or
    /// column it lies between their heights, give or take F × the level's error. F is a number from 1 on, or inf for no limit
    /// [default: 1.5]. With --own-samples nothing is promised between samples of the grid, and F can only be inf
    #[arg(long, hide_short_help = true, value_name = "F", value_parser = values::max_stray, allow_hyphen_values = true)]
    max_stray: Option<f64>,
    /// Keep every level's error at the raster's own samples, too, not only at those of the grid: those beyond it become vertices
    #[arg(long)]
    own_samples: bool,
    /// Compress the files: the server must send them with Content-Encoding: gzip (docs/tiles.md)
    #[arg(long)]
    gzip: bool,
}

/// What `tiles`, `tiles-plan` and `tiles-verify` share.
#[derive(Debug, clap::Args)]
pub(crate) struct CommonArgs {
    #[command(flatten)]
    pub(super) input: InputArgs,
    /// The most memory to use, such as 256MiB [default: a quarter of the machine's, at most 2 GiB]
    #[arg(long, value_name = "BYTES", value_parser = values::bytes)]
    pub(super) memory: Option<u64>,
    /// Threads to work with, fewer if the memory is for fewer [default: as many as the machine has cores]
    #[arg(long, value_name = "N", value_parser = values::threads)]
    pub(super) threads: Option<NonZeroUsize>,
    /// Where temporary files go: about 8 bytes for each sample of the grid, with --own-samples another 24 for each of the raster
    #[arg(long, value_name = "DIR")]
    pub(super) temp_dir: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
    /// Print nothing
    #[arg(long, short, conflicts_with = "json")]
    pub(super) quiet: bool,
}

impl CommonArgs {
    /// Prints a report, as it is asked for.
    pub(super) fn print(&self, report: &(impl serde::Serialize + std::fmt::Display)) -> Result<(), Failure> {
        tell(report, self.json, self.quiet)
    }
}

/// Prints a report.
pub(super) fn tell(
    report: &(impl serde::Serialize + std::fmt::Display),
    json: bool,
    quiet: bool,
) -> Result<(), Failure> {
    if json {
        return print::json(report);
    }
    if quiet {
        return Ok(());
    }
    warnings::print(&warnings::take());
    print::report(&report.to_string())
}

/// The smallest error that can be told from rounding.
const LEAST: f64 = 0.001;

fn error_in_metres(word: &str) -> Result<f64, String> {
    let number: f64 = word.parse().map_err(|_| "expected a number".to_string())?;
    let most = 1e6;
    if (LEAST..=most).contains(&number) { Ok(number) } else { Err(format!("expected {LEAST} to {most}")) }
}

fn height(word: &str) -> Result<f64, String> {
    let number: f64 = word.parse().map_err(|_| "expected a number".to_string())?;
    if number.abs() <= 20_000.0 { Ok(number) } else { Err("expected -20000 to 20000".to_string()) }
}

fn void_as(word: &str) -> Result<VoidAs, String> {
    match word {
        "hole" => Ok(VoidAs::Hole),
        number => height(number).map(VoidAs::Height).map_err(|error| format!("{error}, or hole")),
    }
}

pub(crate) fn run(args: &TilesArgs) -> Result<ExitCode, Failure> {
    let bars = Bars::new(args.common.quiet);
    let request = TilesRequest {
        overwrite: args.overwrite,
        work_dir: args.work_dir.clone(),
        keep_work_dir: args.keep_work_dir,
        ..args.options.request(&args.raster, &args.output, &args.common)?
    };
    let report = tiles(&request, &bars.control())?;
    drop(bars);
    args.common.print(&report)?;
    Ok(ExitCode::SUCCESS)
}

impl TilesOptions {
    /// The request that they stand for.
    pub(super) fn request(&self, raster: &Path, output: &Path, common: &CommonArgs) -> Result<TilesRequest, Failure> {
        common.input.asked().check_samples()?;
        let max_stray = self.max_stray()?;
        let usual = TilesRequest::new(raster, output, self.max_error);
        Ok(TilesRequest {
            view: common.input.view(),
            max_level: self.max_level,
            error_factor: self.error_factor,
            grid_factor: self.grid_factor.parse().map_err(Failure::usage)?,
            vertical_crs: self.vertical_crs.clone(),
            outside: self.outside,
            void_as: self.void_as.unwrap_or_default(),
            fine_heights: self.fine_heights,
            max_stray: max_stray.unwrap_or(usual.max_stray),
            own_samples: self.own_samples,
            gzip: self.gzip,
            memory: common.memory,
            threads: common.threads,
            temp_dir: common.temp_dir.clone(),
            ..usual
        })
    }

    /// The limit on straying, if one is asked for, or none.
    fn max_stray(&self) -> Result<Option<f64>, Failure> {
        match self.max_stray {
            Some(factor) if self.own_samples && factor.is_finite() => Err(Failure::usage(format!(
                "--max-stray {factor} cannot be combined with --own-samples: nothing is promised between samples of the grid then"
            ))
            .hint("remove one of the two")),
            max_stray => Ok(max_stray),
        }
    }
}

/// Of a level above the finest that is allowed what clients expect already.
const LARGER_FACTOR: &str = "choose a larger --error-factor: the level has all that clients expect of it";

/// What may be wrong with samples that no mesh is found for.
const MARKED: &str =
    "where a value that marks missing samples is taken for a height, --nodata and --valid-range leave it out";

impl From<PyramidError> for Failure {
    fn from(error: PyramidError) -> Failure {
        let failure = Failure::new(&error);
        match error {
            PyramidError::View(error) => error.into(),
            PyramidError::Raster(error) => error.into(),
            PyramidError::Field(FieldError::Cancelled(stopped)) | PyramidError::Cancelled(stopped) => stopped.into(),
            PyramidError::Field(error) => Error::Field(error).into(),
            PyramidError::Budget(_) => failure.over_budget().hint("choose a larger --memory"),
            PyramidError::Geodesy { source, .. } => failure.hint(&of_geodesy(&source)),
            PyramidError::Nothing { .. } => failure.hint("gdalinfo -stats shows whether the raster has heights"),
            PyramidError::Spacing { .. } => failure.hint("gdalwarp -tr resamples it, or choose another --grid-factor"),
            PyramidError::Level { .. } => {
                failure.hint("choose a smaller --max-level, or a larger --grid-factor for a finer grid")
            }
            PyramidError::Curvature { bound_by: BoundBy::ErrorFactor, .. } => {
                failure.hint("choose a larger --error-factor, or a larger --grid-factor (2 or 4)")
            }
            PyramidError::Curvature { .. } => {
                failure.hint("choose a larger --max-error, --max-level or --grid-factor (2 or 4)")
            }
            PyramidError::Step { bound_by, fine_heights, .. } => {
                let hint = match bound_by {
                    BoundBy::MaxError => "choose a larger --max-error, or a larger --max-level for smaller tiles",
                    BoundBy::ErrorFactor => LARGER_FACTOR,
                };
                let failure = failure.hint(hint);
                if fine_heights { failure.hint("without --fine-heights steps are smaller") } else { failure }
            }
            PyramidError::Unreachable { bound_by, worst, .. } => {
                let failure = failure.hint(match bound_by {
                    BoundBy::MaxError => "choose a larger --max-error or --grid-factor",
                    BoundBy::ErrorFactor => LARGER_FACTOR,
                });
                let failure = failure.hint(MARKED);
                match worst {
                    Some(worst) if worst.is_at_rim => failure.hint("the nearer --outside is to the ground's heights there, the lower are the cliffs around it"),
                    Some(_) => failure,
                    None => failure.hint("--max-stray inf takes the limit between samples away"),
                }
            }
            PyramidError::OwnSamples { bound_by, .. } => {
                let failure = failure.hint(match bound_by {
                    BoundBy::MaxError => "remove --own-samples, or choose a larger --max-error or --max-level",
                    BoundBy::ErrorFactor => "remove --own-samples, or choose a larger --error-factor",
                });
                failure.hint(MARKED)
            }
            PyramidError::Vertices { .. } => {
                failure.hint("choose a larger --max-level for smaller tiles, a larger --max-error or --error-factor")
            }
            PyramidError::Occupied { found, .. } if found == EARLIER_SET => {
                failure.hint("--overwrite replaces it")
            }
            PyramidError::Occupied { .. } => failure.hint("choose another folder"),
            PyramidError::Altered { .. } => failure.hint(
                "the run had finished this set, and it was changed since; --overwrite writes it anew from the finished tiles",
            ),
            PyramidError::File { source, .. } => failure.on_disk(&source),
            PyramidError::WorkDir(error) => error.into(),
            PyramidError::NoWorkDir => failure,
            PyramidError::Gone { .. } => failure.hint("terrabite tiles-plan brings them there"),
            PyramidError::Damaged { .. } => {
                failure.hint("the disk is not to be trusted; in a work dir, delete it and begin anew, on another disk")
            }
            PyramidError::Missing { .. } => failure.waiting().hint("terrabite run WORK makes them"),
            PyramidError::Kept { error, dir, outdated } => {
                let fate = outdated.map_or(Fate::Continue, Fate::Outdated);
                let with = match &*error {
                    PyramidError::Occupied { found, .. } if found == EARLIER_SET => " with --overwrite",
                    PyramidError::Occupied { .. } => ", with another folder,",
                    _ => "",
                };
                Failure::from(*error).hint(&kept(&dir, &fate, with))
            }
            PyramidError::NotTiles { .. } => failure.hint("terrabite tiles makes one"),
            PyramidError::Threads { .. } => failure.hint("choose fewer with --threads"),
        }
    }
}

/// What mends a raster that has no place on an ellipsoid.
fn of_geodesy(error: &GeodesyError) -> String {
    match error {
        GeodesyError::Local { .. } => "gdal_translate -a_srs EPSG:… gives it a CRS, and -a_ullr a place".to_string(),
        GeodesyError::NoGrid { from, .. } => {
            let named = grid_of(from).map_or(String::new(), |grid| {
                format!("PROJ's is {grid}, which projsync --file {grid} fetches from cdn.proj.org; ")
            });
            format!(
                "{named}projinfo -s \"{from}\" -t EPSG:4979 --spatial-test intersects names all grids that serve; \
                 --vertical-crs names another vertical CRS"
            )
        }
        GeodesyError::NotVertical { .. } => "choose another with --vertical-crs".to_string(),
        GeodesyError::OtherBody { .. } => {
            "gdal_translate -a_srs gives the raster a CRS without one, and no --vertical-crs".to_string()
        }
        GeodesyError::Unit { .. } => "gdal_edit.py -units m names another".to_string(),
        _ => "gdalwarp -t_srs EPSG:4326 brings it into a CRS that PROJ knows the way from".to_string(),
    }
}

/// The grids that PROJ 9.1 takes for common vertical CRSs, by their codes, as its database has them.
const GRIDS: [(&str, &str); 10] = [
    ("3855", "us_nga_egm08_25.tif"),
    ("5701", "uk_os_OSGM15_GB.tif"),
    ("5703", "us_noaa_g2018u0.tif"),
    ("5709", "nl_nsgi_nlgeo2018.tif"),
    ("5710", "be_ign_hBG18.tif"),
    ("5711", "au_ga_AUSGeoid2020_20180201.tif"),
    ("5720", "fr_ign_RAF20.tif"),
    ("5728", "ch_swisstopo_chgeo2004_ETRS89_LN02.tif"),
    ("5773", "us_nga_egm96_15.tif"),
    ("7839", "nz_linz_nzgeoid2016.tif"),
];

/// The grid for the vertical part of a compound CRS, `EPSG:HORIZONTAL+VERTICAL`, if it is a common one.
fn grid_of(compound: &str) -> Option<&'static str> {
    let (_, vertical) = compound.rsplit_once('+')?;
    GRIDS.iter().find(|(code, _)| *code == vertical).map(|(_, grid)| *grid)
}
