//! Warnings as the command tells them: `warning: FILE: sentence; the option that mends it`.
//!
//! Whoever finds one hands it to [`collect`]; at its end a command takes all of them and prints them, or puts them into its
//! JSON. What a command that fails has not taken is printed by `main`, beside the error.

use std::sync::{Mutex, PoisonError};

use super::print;
use crate::base::warning::{Warning, WarningCode, Warnings};

/// The warnings of this process so far.
static COLLECTED: Mutex<Vec<Warning>> = Mutex::new(Vec::new());

/// Keeps warnings for the end of the command.
pub(super) fn collect(warnings: impl IntoIterator<Item = Warning>) {
    COLLECTED.lock().unwrap_or_else(PoisonError::into_inner).extend(warnings);
}

/// What has been collected since the last call, with what GDAL has said meanwhile.
pub(super) fn take() -> Warnings {
    let collected = std::mem::take(&mut *COLLECTED.lock().unwrap_or_else(PoisonError::into_inner));
    let mut shown = Warnings::default();
    shown.extend(collected.into_iter().map(worded));
    shown.extend(crate::raster::take_gdal_warnings());
    shown
}

/// What mends it, in the words of the command line; empty where nothing does.
fn mend(code: WarningCode) -> &'static str {
    match code {
        WarningCode::Gdal | WarningCode::Picture | WarningCode::NoGeometry => "",
        WarningCode::UnreachableNodata => "name the value that marks voids with --nodata",
        WarningCode::NearNodata | WarningCode::ZeroNodata => "if they are heights, use --nodata none",
        WarningCode::SwappedAxes => "ncpdq -a brings its dimensions in another order",
        WarningCode::NoGridMapping => "gdal_translate -a_srs CRS names it",
        WarningCode::FillValue => "name the value that marks missing samples with --nodata",
        WarningCode::XyzGaps => "add lines with a value that is no height, and name it with --nodata",
        WarningCode::Misread => "convert it with a newer GDAL",
        WarningCode::Depths => "--oo DEPTH_OR_ELEVATION=ELEVATION makes heights of them",
        WarningCode::FellShort => "choose a larger budget, or a larger --max-error or --max-rms",
        WarningCode::WorkDirLeft => "it is not needed any more and can be deleted",
        WarningCode::HeaderLost => "PLY and OBJ keep it",
        WarningCode::AttributesLost | WarningCode::EdgesLost => "PLY keeps them",
        WarningCode::NearVoids => "if they are no heights, exclude them with --valid-range",
    }
}

/// The sentence and what mends it.
fn worded(warning: Warning) -> Warning {
    match mend(warning.code) {
        "" => warning,
        mend => Warning { message: format!("{}; {mend}", warning.message), ..warning },
    }
}

/// Prints warnings on standard error, a line each. Not for `--quiet`, and not beside `--json`, where they stand in the JSON.
pub(super) fn print(warnings: &Warnings) {
    for Warning { code, file, count, message } in warnings.iter() {
        // GDAL's messages are events; the others have their count in the sentence.
        let times = if *code == WarningCode::Gdal && *count > 1 { format!(" ({count} times)") } else { String::new() };
        print::error(&format!("warning: {}: {message}{times}", file.display()));
    }
}
