//! How a command ends that does not get through: one message, with the option that mends it, and the exit code.

mod layers;
mod work_dir;

use std::io::ErrorKind;
use std::process::ExitCode;

use crate::base::RasterError;
use crate::base::control::Cancelled;
use crate::base::decimal::Decimal;
use crate::base::external::ScratchError;
use crate::base::staged::OutputError;
use crate::field::FieldError;
use crate::formats::{ReadError, SinkError, SinkOption};
use crate::job::Error;
use crate::job::rules::NotInShards;
use crate::job::spool::SpoolError;
use crate::page::PageError;
use crate::preview::PreviewError;
use crate::raster::{DrapeError, ViewError, WriteError};
use crate::run::checkpoints::CheckpointError;
use crate::run::{LookError, RunError};
use crate::synth::SynthError;
use crate::verify::VerifyError;

pub(super) use layers::of_shapes;
pub(super) use work_dir::kept;

use super::{breaklines, print, shards, signals};

/// How a subcommand ends when it does not get through: one message for the user, and the exit code.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Failure {
    message: String,
    code: u8,
}

/// Exit code: the memory budget is too small.
const BUDGET_TOO_SMALL: u8 = 3;
/// Exit code: a disk is too small.
const DISK_TOO_SMALL: u8 = 4;

/// What mends a table of x, y, z that GDAL refuses.
const IN_ORDER: &str = "its lines must be in the order of rows or columns: sort -k2,2gr -k1,1g brings them into it (with -t, \
                        where commas separate columns, and without a header line); points that lie on no grid become a raster \
                        by gdal_grid";

/// What mends a raster whose rows or columns are not evenly spaced.
const ONTO_AN_EVEN_GRID: &str = "cdo remapbil,GRID brings it onto an even grid; docs/rasters.md describes GRID";

impl Failure {
    /// Exit code 1: the job could not be done.
    pub(crate) fn new(message: impl ToString) -> Failure {
        Failure { message: message.to_string(), code: 1 }
    }

    /// Exit code 2: the options contradict each other or the input, so no run of this command line can succeed.
    pub(crate) fn usage(message: impl ToString) -> Failure {
        Failure { message: message.to_string(), code: 2 }
    }

    /// The same failure, with a sentence on how to mend it after the message.
    pub(crate) fn hint(mut self, hint: &str) -> Failure {
        self.message = format!("{}; {hint}", self.message);
        self
    }

    /// The same failure, where it came of a disk that may be full.
    pub(super) fn on_disk(self, source: &std::io::Error) -> Failure {
        match code_of(source) {
            DISK_TOO_SMALL => {
                Failure { code: DISK_TOO_SMALL, ..self }.hint("free some space, or write to another disk")
            }
            _ => self,
        }
    }

    /// The same failure, with the exit code that says that others have to work first.
    pub(super) fn waiting(self) -> Failure {
        Failure { code: shards::WAITING, ..self }
    }

    /// The same failure, with the exit code of a memory budget that is too small.
    pub(super) fn over_budget(self) -> Failure {
        Failure { code: BUDGET_TOO_SMALL, ..self }
    }

    /// The same failure, with one word for another.
    pub(super) fn with_words(self, word: &str, other: &str) -> Failure {
        Failure { message: self.message.replace(word, other), ..self }
    }

    /// What the user is told, without "error:".
    pub(super) fn message(&self) -> &str {
        &self.message
    }

    /// Tells the user, and gives the code to exit with.
    pub(super) fn report(self) -> ExitCode {
        print::error(&format!("error: {}", self.message));
        ExitCode::from(self.code)
    }
}

/// A full disk has an exit code of its own.
fn code_of(error: &std::io::Error) -> u8 {
    if error.kind() == ErrorKind::StorageFull { DISK_TOO_SMALL } else { 1 }
}

impl From<RasterError> for Failure {
    fn from(error: RasterError) -> Failure {
        let failure = Failure::new(&error);
        match error {
            RasterError::NoSuchBand { .. } => failure.hint("choose one with --band"),
            RasterError::SampleType { .. } => failure.hint("choose another band with --band"),
            RasterError::Window { .. } => failure.hint("choose another --window"),
            RasterError::Picture { band, ref found, other, encoded, .. } => {
                failure.hint(&of_picture(band, found, other, encoded))
            }
            RasterError::NotEncoded { .. } => {
                failure.hint("remove --encoding, or expand a table of colours with gdal_translate -expand rgb")
            }
            RasterError::Wide { .. } => failure.hint("choose a part of it with --window"),
            RasterError::NotAffine { .. } => {
                failure.hint("gdalwarp -t_srs CRS brings it onto a map; gdal_translate -a_ullr gives it a geotransform")
            }
            RasterError::Open { ref reason, .. } if reason.starts_with("Ungridded dataset") => failure.hint(IN_ORDER),
            RasterError::AxisElsewhere { .. } => failure.hint(ONTO_AN_EVEN_GRID),
            RasterError::UnusedAxes { swapped: true, ref columns, ref rows, .. } => {
                failure.hint(&format!("ncpdq -a {columns},{rows} brings rows and columns in order"))
            }
            RasterError::UnusedAxes { corners: Some(corners), .. } => {
                let corners = corners.map(|corner| corner.to_string()).join(" ");
                failure.hint(&format!("gdal_translate -a_ullr {corners} makes a raster of it that is in its place"))
            }
            RasterError::UnusedAxes { .. } => failure.hint(ONTO_AN_EVEN_GRID),
            RasterError::BoxCrs { .. } => failure.hint("choose another CRS with --bbox-crs"),
            RasterError::EmptyBox { .. } => failure.hint("choose another --bbox, or name its CRS with --bbox-crs"),
            RasterError::GeoTransform { .. } => failure.hint("gdal_edit.py -a_gt or gdalwarp can set another one"),
            RasterError::OtherGrid { .. } => failure
                .hint("gdalwarp -te … -ts WIDTH HEIGHT resamples it to that grid; gdal_edit.py -a_ullr corrects its geotransform"),
            RasterError::NodataValue { .. } => {
                Failure::usage(&error).hint("--nodata takes a number that samples can have, inf, -inf, nan, tag or none")
            }
            RasterError::Scaling { .. } => failure.hint("gdal_edit.py -scale and -offset can set them"),
            ref silent if silent.is_silent() => failure.hint(
                "gdalinfo -checksum shows whether GDAL can read the file; of a VRT, check sources and pixel functions",
            ),
            _ => failure,
        }
    }
}

/// Where the heights of a picture may be.
fn of_picture(band: usize, found: &str, other: Option<usize>, encoded: bool) -> String {
    let other = other.map(|n| format!("choose --band {n}, the first that is no colour"));
    let encoded = encoded.then(|| "choose --encoding where colours stand for heights".to_string());
    let table = found.contains("table").then(|| "gdal_translate -expand rgb makes colours of them".to_string());
    let after_all = format!("use --band {band} if they are heights after all");
    let ways = other.into_iter().chain(encoded).chain(table).chain([after_all]);
    ways.collect::<Vec<_>>().join("; ")
}

impl From<LookError> for Failure {
    fn from(error: LookError) -> Failure {
        match error {
            LookError::Raster(error) => error.into(),
            LookError::Cancelled(stopped) => stopped.into(),
        }
    }
}

impl From<ViewError> for Failure {
    fn from(error: ViewError) -> Failure {
        match error {
            ViewError::Raster(error) => error.into(),
            ViewError::Cutline(error) => of_shapes(error, "--cutline"),
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Failure {
        let failure = Failure::new(&error);
        match error {
            RunError::Incompatible(conflicts) => conflicts.into(),
            RunError::View(error) => error.into(),
            RunError::Attribute(RasterError::NoSuchBand { .. } | RasterError::SampleType { .. }) => {
                failure.hint("choose bands with --attributes")
            }
            RunError::Attribute(error) => error.into(),
            RunError::ColourTable(_) => failure.hint(
                "name the bands with --attributes if their numbers are values; gdal_translate -expand rgb makes colours of them",
            ),
            RunError::Importance(RasterError::NoSuchBand { .. }) => failure.hint("choose one with --importance-band"),
            RunError::Importance(RasterError::SampleType { .. }) => {
                failure.hint("choose another band with --importance-band")
            }
            RunError::Importance(error) => error.into(),
            RunError::Points(error) => error.into(),
            RunError::Shapes { kind, error } => breaklines::of_layer(kind, error),
            RunError::Lines(error) => breaklines::of_lines(&error, failure),
            RunError::Texture(DrapeError::Place { .. }) => failure.hint("gdal_translate -a_srs -a_ullr gives it one"),
            RunError::Texture(DrapeError::Elsewhere { .. }) => failure.hint("gdalinfo shows where it lies"),
            RunError::Texture(_) => failure,
            RunError::Indistinct { .. } => failure.hint("choose --precision double"),
            RunError::Loss { single: true, .. } => failure.hint("--precision double loses less, in a format that has it: PLY, OBJ, VTP, UGRID"),
            RunError::Loss { .. } => failure.hint("--z-scale 1 loses nothing"),
            RunError::NotInShards(NotInShards(feature)) => shards::refused(feature, Failure { code: 2, ..failure }),
            RunError::NoWorkDir => failure,
            RunError::NoSuchPass { .. } => Failure { code: 2, ..failure }.hint("choose another --pass"),
            RunError::Threads { .. } => failure.hint("choose fewer with --threads"),
            RunError::Scratch(ScratchError::Cancelled(stopped)) | RunError::Mesh(ReadError::Cancelled(stopped)) => stopped.into(),
            RunError::Scratch(ref scratch) | RunError::Mesh(ReadError::Scratch(ref scratch)) => of_scratch(scratch, &error),
            RunError::Mesh(_) | RunError::NotFinite { .. } => failure,
            RunError::Placed { .. } => failure.hint("leave out --local and --z-scale, or have simplify write the mesh so"),
            RunError::Verify(error) => error.into(),
            RunError::ErrorRaster(error) => error.into(),
            RunError::Checkpoints(CheckpointError::Crs { .. }) => failure.hint("choose another CRS with --checkpoints-crs"),
            RunError::Checkpoints(_) => failure.hint("choose another table with --checkpoints"),
            RunError::Job(error) => (*error).into(),
            RunError::Kept { error, dir, fate } => {
                let is_there = matches!(*error, Error::Output(OutputError::Exists { .. }) | Error::Sink(SinkError::Output(OutputError::Exists { .. })));
                Failure::from(*error).hint(&kept(&dir, &fate, if is_there { " with --overwrite" } else { "" }))
            }
            RunError::FormatOption { path, format, option, formats } => {
                let (option, path) = (options_of(option), path.display());
                Failure::usage(format!("{path}: {option} is for {formats}, and this is {format}"))
                    .hint("choose another format, or remove the option")
            }
            RunError::Format { .. } => failure.hint("use --format"),
        }
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        match error {
            WriteError::Output(error) => error.into(),
            WriteError::Gdal { .. } => Failure::new(error).hint("choose another file with --error-raster"),
        }
    }
}

/// The options by which formats are asked for something.
fn options_of(option: SinkOption) -> &'static str {
    match option {
        SinkOption::Ascii => "--ascii",
        SinkOption::Base => "--base-height or --base-depth",
        SinkOption::Compression => "--mesh-compression",
        SinkOption::OgrDriver => "--format OGR:…",
        SinkOption::OgrGeometry => "--ogr-geometry",
        SinkOption::Normals => "--normals",
        SinkOption::Texture => "--texture",
    }
}

/// Temporary files: a full disk has an exit code of its own.
fn of_scratch(scratch: &ScratchError, error: &dyn std::fmt::Display) -> Failure {
    let failure = Failure::new(error).hint("choose another folder with --temp-dir");
    match scratch {
        ScratchError::File { source, .. } if source.kind() == ErrorKind::StorageFull => {
            Failure { code: DISK_TOO_SMALL, ..failure }
        }
        _ => failure,
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Failure {
        match error {
            Error::Raster(error) => error.into(),
            Error::Output(error) | Error::Sink(SinkError::Output(error)) => error.into(),
            Error::Sink(SinkError::Lossy { .. }) => {
                Failure::new(error).hint("--precision double, or another --z-scale, loses less")
            }
            Error::Sink(SinkError::Scratch(ScratchError::Cancelled(stopped))) => stopped.into(),
            Error::Scratch(ref scratch) | Error::Sink(SinkError::Scratch(ref scratch)) => of_scratch(scratch, &error),
            Error::Sink(SinkError::Library { ref message, .. })
                if message.contains("disk") && message.contains("full") =>
            {
                Failure { code: DISK_TOO_SMALL, ..Failure::new(&error) }
                    .hint("free some space, or write to another disk")
            }
            Error::Sink(SinkError::DoubleAttribute { .. }) => Failure::new(error)
                .hint("PLY, UGRID, VTP and GeoPackage keep them; gdal_translate -ot Float32 makes singles of them"),
            Error::Sink(SinkError::TooLarge { .. }) => {
                Failure::new(error).hint("a larger --max-error needs fewer; OBJ numbers any number of them")
            }
            Error::Cancelled(stopped) | Error::Field(FieldError::Cancelled(stopped)) => stopped.into(),
            Error::Field(FieldError::Raster(error)) => error.into(),
            Error::WorkDir(error) => error.into(),
            Error::Incompatible(conflicts) => conflicts.into(),
            Error::PointOffGround { .. } => Failure::usage(error).hint(
                "remove it from the layer of --points; --cutline, --nodata and --valid-range decide where ground is",
            ),
            Error::LineHeight { .. } => {
                Failure::new(error).hint("choose a larger --max-error, or remove --breaklines and --footprints")
            }
            Error::Missing(_) => Failure::new(error).waiting(),
            Error::Tile { .. } => Failure::new(error).hint("choose a smaller --tile"),
            Error::Goal(_) => {
                Failure::usage(error).hint("choose a larger budget; with a larger --tile there are fewer corners")
            }
            Error::Budget(error) => {
                Failure::new(error).over_budget().hint("choose a larger --memory, or a smaller --tile")
            }
            Error::Field(FieldError::NotAHeight(ref sample)) => {
                let stored = Decimal(sample.stored);
                Failure::new(&error).hint(&format!(
                    "if it marks missing samples, use --nodata {stored}, or --valid-range for the heights that are valid"
                ))
            }
            Error::Field(FieldError::Nodata { .. }) => Failure::new(error).hint("gdal_fillnodata can give it one"),
            Error::Field(FieldError::NotAWeight { .. }) => {
                Failure::new(error).hint("gdal_calc.py, or gdal_fillnodata, can give them a weight")
            }
            Error::Spool(SpoolError::TooLarge { .. }) => Failure::new(error).hint("use a smaller --tile"),
            Error::Field(FieldError::Inexact { found, .. }) => {
                Failure::new(&error).hint(&format!("if it marks missing samples, use --nodata {found}"))
            }
            Error::Field(FieldError::HolesTooLarge { .. }) => {
                Failure::new(error).over_budget().hint("choose a smaller --fill-holes, or a larger --memory")
            }
            Error::Disk(error) => Failure { code: DISK_TOO_SMALL, ..Failure::new(error) }
                .hint("free some space, or choose other folders with --temp-dir and OUTPUT"),
            Error::Field(FieldError::Temporary { ref source, .. } | FieldError::HolesFile { ref source, .. })
            | Error::Spool(SpoolError::File { ref source, .. }) => {
                Failure { code: code_of(source), ..Failure::new(&error) }.hint("choose another folder with --temp-dir")
            }
            Error::Spool(SpoolError::Kept { ref source, .. }) if source.kind() == ErrorKind::StorageFull => {
                Failure::new(error).hint("free some space")
            }
            _ => Failure::new(error),
        }
    }
}

impl From<VerifyError> for Failure {
    fn from(error: VerifyError) -> Failure {
        match error {
            VerifyError::Raster(error) => error.into(),
            VerifyError::Cancelled(stopped) => stopped.into(),
            VerifyError::Incompatible(conflicts) => conflicts.into(),
            VerifyError::InfiniteSample { .. } => {
                Failure::new(error).hint("if it marks missing samples, use --nodata, or --valid-range")
            }
            VerifyError::Observer(error) => match error.downcast::<WriteError>() {
                Ok(error) => (*error).into(),
                Err(error) => Failure::new(error),
            },
            VerifyError::Mesh(ReadError::NoAttribute { .. }) => Failure::new(error).hint(
                "simplify writes it with --attributes or --image, in a format that keeps attributes, such as PLY",
            ),
            VerifyError::Scratch(ref scratch) | VerifyError::Mesh(ReadError::Scratch(ref scratch)) => {
                of_scratch(scratch, &error)
            }
            _ => Failure::new(error),
        }
    }
}

impl From<SynthError> for Failure {
    fn from(error: SynthError) -> Failure {
        match error {
            SynthError::Output(error) => error.into(),
            SynthError::Cancelled(stopped) => stopped.into(),
            SynthError::Option(error) => Failure::usage(error),
            _ => Failure::new(error),
        }
    }
}

impl From<PreviewError> for Failure {
    fn from(error: PreviewError) -> Failure {
        match error {
            PreviewError::View(error) => error.into(),
            PreviewError::Raster(error) => error.into(),
            PreviewError::Output(error) => error.into(),
            PreviewError::Cancelled(stopped) => stopped.into(),
            PreviewError::Option { .. } => Failure::usage(error),
            PreviewError::Mesh(ReadError::NoAttribute { .. }) => Failure::new(error).hint(
                "choose another --mode, or a mesh with colours: simplify writes them with --attributes or --image",
            ),
            _ => Failure::new(error),
        }
    }
}

impl From<PageError> for Failure {
    fn from(error: PageError) -> Failure {
        match error {
            PageError::Output(error) => error.into(),
            PageError::Sink(error) => Error::Sink(error).into(),
            PageError::Temporary(ref source) => {
                Failure { code: code_of(source), ..Failure::new(&error) }.hint("choose another folder with --temp-dir")
            }
        }
    }
}

impl From<OutputError> for Failure {
    fn from(error: OutputError) -> Failure {
        let failure = Failure::new(&error);
        match error {
            OutputError::Exists { .. } => failure.hint("--overwrite replaces it"),
            OutputError::Write { source, .. } if source.kind() == ErrorKind::StorageFull => {
                Failure { code: DISK_TOO_SMALL, ..failure }.hint("free some space, or write to another disk")
            }
            _ => failure,
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(stopped: Cancelled) -> Failure {
        Failure { message: format!("{stopped}; nothing was written"), code: signals::exit_code() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_the_option_that_mends() {
        let error = RasterError::NoSuchBand { path: "dem.tif".into(), band: 3, count: 1 };
        let expected = "dem.tif: expected band 3, found bands 1 to 1; choose one with --band";
        assert_eq!(Failure::from(error), Failure { message: expected.to_string(), code: 1 });
    }

    /// To leave an option is to keep it.
    #[test]
    fn options_are_removed_not_left() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cli");
        let word = concat!("leave ", "--");
        let paths = folder.read_dir().unwrap().map(|entry| entry.unwrap().path());
        for path in paths.filter(|path| path.is_file()) {
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(!text.to_lowercase().contains(word), "{} says {word}", path.display());
        }
    }
}
