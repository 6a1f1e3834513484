//! What a run will need.

use serde::Serialize;

use super::SCHEMA;
use crate::base::warning::Warnings;
use crate::job::plan::{Estimate, Expected, Plan};
use crate::job::work_dir::Finished;

/// What a run will need, before it begins.
#[derive(Debug, Clone, Serialize)]
pub struct Needs {
    /// See [`SCHEMA`].
    pub schema: u32,
    /// How the density was found, in words.
    #[serde(skip)]
    pub found_by: &'static str,
    /// The tolerance that a search for one will begin at; null where none is looked for.
    pub tolerance: Option<f64>,
    /// Seconds of all threads together, as this machine took for the tiles that were tried; null where none were made.
    pub thread_seconds: Option<f64>,
    /// The disk.
    pub estimate: Estimate,
    /// The memory.
    pub memory: Plan,
    /// What is finished in the work dir; null without one.
    pub work_dir: Option<WorkDirState>,
    /// What the user should know of the inputs.
    pub warnings: Warnings,
}

/// What of a job is finished in its work dir.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct WorkDirState {
    /// Tiles of the first pass, in all.
    pub tiles: u64,
    /// Tiles of the second pass, over the seams, in all; 0 where there is none.
    pub seams: u64,
    /// Tiles of the last two passes, over crossings with seams, in all; 0 where there are none.
    pub crossings: u64,
    /// What is finished of them.
    pub finished: Finished,
}

impl Needs {
    pub(in crate::run) fn new(found_by: &'static str, expected: &Expected, estimate: Estimate, memory: Plan) -> Needs {
        let Expected { tolerance, thread_seconds, .. } = *expected;
        let warnings = Warnings::default();
        Needs { schema: SCHEMA, found_by, tolerance, thread_seconds, estimate, memory, work_dir: None, warnings }
    }
}
