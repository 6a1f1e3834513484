//! Why a work dir cannot be used.

use std::fmt;
use std::path::PathBuf;

use crate::base::without_bits;

/// Why a work dir cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorkDirError {
    /// It belongs to another job.
    #[error("{}: the work dir belongs to another job: {}", dir.display(), list(differences))]
    OtherJob {
        /// The work dir.
        dir: PathBuf,
        /// In what the jobs differ.
        differences: Vec<Difference>,
    },
    /// Another process has it.
    #[error("{}: another process works in this work dir", dir.display())]
    InUse {
        /// The work dir.
        dir: PathBuf,
    },
    /// A folder with things in it that is no work dir.
    #[error("{}: expected a new folder, an empty one or a work dir, found {} in it", dir.display(), found.display())]
    NotEmpty {
        /// The folder.
        dir: PathBuf,
        /// Something that is in it.
        found: PathBuf,
    },
    /// The manifest makes no sense.
    #[error("{}: expected the manifest of a work dir: {reason}", path.display())]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// No run has been laid out in it for shards.
    #[error("{}: expected a work dir in which a run is laid out, found none", dir.display())]
    NotPlanned {
        /// The folder, which may be missing.
        dir: PathBuf,
    },
    /// There is no work dir of an earlier run.
    #[error("{}: expected the work dir of an earlier run, found none", dir.display())]
    NoEarlier {
        /// The folder, which may be missing.
        dir: PathBuf,
    },
    /// Another version of the program laid out the run.
    #[error("{}: expected a run laid out by {expected}, found one by {found}", path.display())]
    OtherProgram {
        /// The command's file.
        path: PathBuf,
        /// This program.
        expected: String,
        /// The one that laid it out.
        found: String,
    },
    /// The system refuses something.
    #[error("{}: the work dir cannot be used: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// One thing in which two jobs differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// What it is called.
    pub what: String,
    /// What the work dir was made for; `None` where it was made without.
    pub expected: Option<String>,
    /// What this run is about; `None` where it is not given.
    pub found: Option<String>,
}

impl Difference {
    /// The values of the work dir and of this run without the bits of doubles, unless they differ in nothing else, as two
    /// NaNs may.
    pub fn plain(&self) -> [Option<String>; 2] {
        let both = [&self.expected, &self.found];
        let plain = both.map(|value| value.as_deref().map(without_bits));
        if plain[0] == plain[1] { both.map(Clone::clone) } else { plain }
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let said = |value: Option<String>| match value {
            None => "not given".to_string(),
            Some(value) if value.is_empty() => "none".to_string(),
            Some(value) => value,
        };
        let [expected, found] = self.plain().map(said);
        write!(f, "{}: {expected} in the work dir, {found} now", self.what)
    }
}

fn list(differences: &[Difference]) -> String {
    differences.iter().map(Difference::to_string).collect::<Vec<_>>().join("; ")
}
