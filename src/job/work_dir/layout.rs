//! What a work dir says of a run that is made in shards: the command that all processes follow, and whether its passes have to
//! be made again.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{WorkDirError, failed};
use crate::base::durable;
use crate::base::private_file::PrivateFile;

/// The file with the command.
pub(super) const COMMAND: &str = "plan.json";
/// The file that says that passes with short links have to be made.
pub(super) const AGAIN: &str = "short-links";

/// The file with the tolerance of a search's run that is being made.
pub(super) const TRIAL: &str = "tolerance";

/// The form of the file.
const FORMAT: u32 = 1;

/// The command of a run that is made in shards, as its user gave it. Whoever works on a shard reads it and has the same request.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlannedCommand {
    format: u32,
    /// The program that laid the run out, with its version.
    pub program: String,
    /// The words after the program's name.
    pub words: Vec<String>,
    /// The folder that names of files are relative to.
    pub folder: PathBuf,
    /// How many passes the run has. Those with short links are as many, and come after them.
    pub passes: usize,
}

impl PlannedCommand {
    /// A command of this program, for a run of so many passes.
    pub fn new(words: Vec<String>, folder: PathBuf, passes: usize) -> PlannedCommand {
        PlannedCommand { format: FORMAT, program: program(), words, folder, passes }
    }

    /// The command that the run in a work dir was laid out with.
    ///
    /// # Errors
    /// [`WorkDirError::NotPlanned`] where there is none, [`WorkDirError::OtherProgram`] where another version made it;
    /// [`WorkDirError::Manifest`] if it makes no sense.
    pub fn of(dir: &Path) -> Result<PlannedCommand, WorkDirError> {
        let path = dir.join(COMMAND);
        let text = match std::fs::read_to_string(&path) {
            Err(e) if matches!(e.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                return Err(WorkDirError::NotPlanned { dir: dir.to_path_buf() });
            }
            other => other.map_err(failed(&path))?,
        };
        let wrong = |reason: String| WorkDirError::Manifest { path: path.clone(), reason };
        let command: PlannedCommand = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
        let (expected, found) = (program(), command.program.clone());
        if command.format != FORMAT || expected != found {
            return Err(WorkDirError::OtherProgram { path, expected, found });
        }
        Ok(command)
    }

    /// Makes it durable.
    pub(super) fn write(&self, dir: &Path) -> io::Result<()> {
        PrivateFile::create(&dir.join(COMMAND))?.commit(serde_json::to_string_pretty(self)?.as_bytes(), || {})?;
        durable::sync_dir(dir)
    }
}

fn program() -> String {
    format!("terrabite {}", env!("CARGO_PKG_VERSION"))
}

/// Notes that passes with short links have to be made.
pub(super) fn note_again(dir: &Path) -> io::Result<()> {
    PrivateFile::create(&dir.join(AGAIN))?.commit(b"edges stray too far beside long links\n", || {})?;
    durable::sync_dir(dir)
}

/// Whether that is noted.
pub(super) fn is_again(dir: &Path) -> bool {
    dir.join(AGAIN).exists()
}

/// Notes at which tolerance shards are made from now on.
pub(super) fn note_trial(dir: &Path, tolerance: f64) -> io::Result<()> {
    // What strays at one tolerance need not at another.
    durable::remove_if_there(&dir.join(AGAIN))?;
    PrivateFile::create(&dir.join(TRIAL))?.commit(format!("{tolerance:e}\n").as_bytes(), || {})?;
    durable::sync_dir(dir)
}

/// The tolerance that is noted.
pub(super) fn trial(dir: &Path) -> io::Result<Option<f64>> {
    match std::fs::read_to_string(dir.join(TRIAL)) {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e),
        // The shortest decimal that is read as the same number.
        Ok(text) => Ok(text.trim().parse().ok().filter(|tolerance: &f64| *tolerance >= 0.0)),
    }
}
