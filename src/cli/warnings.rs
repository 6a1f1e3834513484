//! Warnings as the command tells them: `warning: FILE: sentence; the option that mends it`.

use serde::Serialize;

use super::print;
use crate::warning::{Warning, WarningCode, Warnings};

/// What mends it, in the words of the command line; empty where nothing does.
fn mend(code: WarningCode) -> &'static str {
    match code {
        WarningCode::Gdal => "",
    }
}

/// The sentence and what mends it.
fn worded(warning: Warning) -> Warning {
    match mend(warning.code) {
        "" => warning,
        mend => Warning { message: format!("{}; {mend}", warning.message), ..warning },
    }
}

/// Warnings that are ready to be shown.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub(super) struct Shown(Warnings);

impl Shown {
    pub(super) fn new(warnings: Warnings) -> Shown {
        let mut shown = Warnings::default();
        shown.extend(warnings.into_iter().map(worded));
        Shown(shown)
    }

    /// Prints them on standard error, a line each. Not for `--quiet`, and not beside `--json`, where they stand in the JSON.
    pub(super) fn print(&self) {
        for Warning { code, file, count, message } in self.0.iter() {
            // GDAL's messages are events; the others have their count in the sentence.
            let times =
                if *code == WarningCode::Gdal && *count > 1 { format!(" ({count} times)") } else { String::new() };
            print::error(&format!("warning: {}: {message}{times}", file.display()));
        }
    }
}
