//! A run as a library: file in, file out, as the command does it; what a program or another language calls.
//!
//! In comes a [`Request`]; out comes a mesh in a file, and a [`Report`] of what became of it. [`plan`] says beforehand what
//! it takes. Nothing here knows of options or prints anything, installs a handler of signals or of GDAL's errors, or ends
//! the process. Warnings are told to [`crate::base::control::Progress::warn`] as they come up and stand in the report.
//!
//! A run works on threads of its own, as many as its memory is for; it may be called from any thread.

mod attributes;
pub mod checkpoints;
mod convert;
mod coordinates;
mod error;
mod extras;
#[cfg(all(test, feature = "gdal"))]
mod format_tests;
#[cfg(test)]
mod in_memory_tests;
#[cfg(feature = "gdal")]
mod info;
mod inputs;
mod judge;
mod lakes;
mod lines;
mod look;
mod make;
mod prepare;
mod provenance;
pub mod report;
mod request;
mod resume;
pub mod scene;
mod shards;
pub mod survey;
mod threads;

pub use convert::{ConvertReport, ConvertRequest, convert, convert_mesh};
pub use error::{Fate, RunError};
pub use extras::Extras;
#[cfg(feature = "gdal")]
pub use info::{Description, Info, describe};
pub use judge::{VerifyReport, VerifyRequest, verify, verify_mesh};
pub use lakes::LakeHeight;
pub use lines::{HeightSource, LineInput, LineTypes, Lines, UnusableLines};
pub use look::{Found, Look, LookError, look};
pub use report::{Needs, Report};
#[cfg(feature = "gdal")]
pub use request::TextureInput;
pub use request::{AttributeBands, Attributes, Coordinates, Guard, Input, PointInput, Request};
pub use shards::{Layout, PassLayout, PassShare, ShardReport, lay_out, merge, work};

use std::sync::{Mutex, PoisonError};

use crate::base::control::{Control, Progress};
use crate::base::warning::{Warning, Warnings};
use crate::formats::{Arrays, Header};

/// Makes the mesh that is asked for, writes it and gives it its name.
///
/// # Errors
/// [`RunError`]; nothing is left under the output's name then, and of finished tiles only what the work dir keeps.
pub fn simplify(request: &Request<'_>, control: &Control<'_>) -> Result<Report, RunError> {
    make::simplify(request, control)
}

/// What reports call the format of a mesh in arrays.
const IN_MEMORY: &str = "arrays";

/// A mesh in arrays, and what came of making it.
#[derive(Debug)]
pub struct InMemory {
    /// The mesh, in map coordinates and heights.
    pub arrays: Arrays,
    /// What a file with it says of itself.
    pub header: Header,
    /// What came of the run.
    pub report: Report,
}

/// Makes the mesh that is asked for, in arrays. Output, format and coordinates of the request are not looked at: arrays have
/// coordinates as they are. Normals become attributes; no other option of a format may be asked for. A work dir keeps finished tiles until the arrays are there. The
/// memory of the arrays comes on top of that of the run.
///
/// # Errors
/// [`RunError`]; [`RunError::FormatOption`] for an option of a format.
pub fn simplify_in_memory(request: &Request<'_>, control: &Control<'_>) -> Result<InMemory, RunError> {
    make::simplify_in_memory(request, control)
}

/// Finds out what a run will need: of a few tiles, or of its budget; and what its work dir has of it already. Writes
/// nothing.
///
/// # Errors
/// [`RunError`], as for the run.
pub fn plan(request: &Request<'_>, control: &Control<'_>) -> Result<Needs, RunError> {
    make::plan(request, control)
}

/// The warnings of a run: told as they come up, and kept.
struct Warned<'a> {
    progress: &'a dyn Progress,
    kept: Mutex<Warnings>,
}

impl<'a> Warned<'a> {
    fn new(control: &Control<'a>) -> Warned<'a> {
        Warned { progress: control.progress, kept: Mutex::default() }
    }

    fn tell(&self, warning: Warning) {
        self.progress.warn(&warning);
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).extend([warning]);
    }

    fn tell_all(&self, warnings: &[Warning]) {
        warnings.iter().cloned().for_each(|warning| self.tell(warning));
    }

    fn take(&self) -> Warnings {
        std::mem::take(&mut self.kept.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
