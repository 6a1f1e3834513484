//! The manifest of a work dir: which job its chunks belong to.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{Difference, Job, WorkDirError};
use crate::base::durable;
use crate::base::faults::{self, Point};
use crate::base::private_file::PrivateFile;
use crate::base::{Files, SOME_SAMPLES};
use crate::job::Params;

/// The form of the work dir.
const FORMAT: u32 = 1;

/// The parameter that says what a job makes; without it, it is a mesh.
const RESULT: &str = "result";

/// What a work dir is for, as it stands in `manifest.json`. Values are text, so that a difference can be told as it is.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Manifest {
    #[serde(flatten)]
    version: Version,
    parameters: BTreeMap<String, String>,
    raster: BTreeMap<String, String>,
    /// Empty where there is none.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    importance: BTreeMap<String, String>,
    /// When the work dir was made. No part of the rasters' identity.
    pub(super) files: Files,
}

/// What every format of the manifest has.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Version {
    format: u32,
    program: String,
}

impl Manifest {
    pub(super) fn new(job: &Job) -> Manifest {
        let map = |named: &[(&str, String)]| named.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
        Manifest {
            version: Version { format: FORMAT, program: format!("terrabite {}", env!("CARGO_PKG_VERSION")) },
            parameters: map(&job.parameters),
            raster: map(&job.raster),
            importance: map(&job.importance),
            files: job.files.clone(),
        }
    }

    pub(super) fn path(dir: &Path) -> PathBuf {
        dir.join("manifest.json")
    }

    /// Makes it durable, name and all: chunks without their manifest would be nobody's.
    pub(super) fn write(&self, dir: &Path) -> io::Result<()> {
        let text = serde_json::to_string_pretty(self)?;
        let file = PrivateFile::create(&Manifest::path(dir))?;
        file.commit(text.as_bytes(), || faults::reach(Point::ManifestWritten))?;
        durable::sync_dir(dir)
    }

    /// The manifest of any version; where only the version can be read, the rest is empty.
    pub(super) fn parse(path: &Path, text: &str) -> Result<Manifest, WorkDirError> {
        let wrong = |e: serde_json::Error| WorkDirError::Manifest { path: path.to_path_buf(), reason: e.to_string() };
        let version: Version = serde_json::from_str(text).map_err(wrong)?;
        if version.format != FORMAT {
            let (parameters, raster, importance) = Default::default();
            return Ok(Manifest { version, parameters, raster, importance, files: Files::unknown() });
        }
        serde_json::from_str(text).map_err(wrong)
    }

    /// Makes sure that the work dir `dir`, which was made for `kept`, is one for this job.
    pub(super) fn must_continue(&self, dir: &Path, kept: &Manifest) -> Result<(), WorkDirError> {
        let differences = if self.version.format == kept.version.format {
            self.differences(kept)
        } else {
            vec![difference("work dir format", Some(kept.version.format), Some(self.version.format))]
        };
        if differences.is_empty() {
            return Ok(());
        }
        Err(WorkDirError::OtherJob { dir: dir.to_path_buf(), differences })
    }

    /// Makes sure that `old`, the manifest of the work dir `dir`, is of the same job but for the samples of its raster, and for where its
    /// breaklines are.
    pub(super) fn must_be_of_another_state(&self, dir: &Path, old: &Manifest) -> Result<(), WorkDirError> {
        let mut same = self.clone();
        for (mine, theirs, name) in [
            (&mut same.raster, &old.raster, SOME_SAMPLES),
            (&mut same.importance, &old.importance, SOME_SAMPLES),
            (&mut same.parameters, &old.parameters, Params::SEGMENTS),
        ] {
            if let Some((mine, theirs)) = mine.get_mut(name).zip(theirs.get(name)) {
                mine.clone_from(theirs);
            }
        }
        same.must_continue(dir, old)
    }

    fn differences(&self, kept: &Manifest) -> Vec<Difference> {
        let result = |of: &Manifest| of.parameters.get(RESULT).map_or("a mesh", String::as_str).to_string();
        if result(kept) != result(self) {
            // They have hardly a parameter in common.
            return vec![difference(RESULT, Some(result(kept)), Some(result(self)))];
        }
        let mut all = Vec::new();
        if self.version.program != kept.version.program {
            all.push(difference("program", Some(&kept.version.program), Some(&self.version.program)));
        }
        let mut maps = vec![("", &kept.parameters, &self.parameters), ("the raster's ", &kept.raster, &self.raster)];
        match (&kept.importance, &self.importance) {
            (expected, found) if expected.is_empty() == found.is_empty() => {
                maps.push(("the importance raster's ", expected, found));
            }
            (expected, found) => {
                let given = |of: &BTreeMap<_, _>| (!of.is_empty()).then_some("given");
                all.push(difference("importance raster", given(expected), given(found)));
            }
        }
        for (of, expected, found) in maps {
            let names: BTreeSet<&String> = expected.keys().chain(found.keys()).collect();
            for name in names.into_iter().filter(|&name| expected.get(name) != found.get(name)) {
                all.push(difference(&format!("{of}{name}"), expected.get(name), found.get(name)));
            }
        }
        all
    }

    /// A number for everything that decides chunks: it ties them to their manifest.
    pub(super) fn stamp(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        let mut add = |text: &str| {
            hasher.update(&(text.len() as u64).to_le_bytes());
            hasher.update(text.as_bytes());
        };
        add(&self.version.format.to_string());
        add(&self.version.program);
        self.parameters.iter().chain(&self.raster).chain(&self.importance).for_each(|(name, value)| {
            add(name);
            add(value);
        });
        hasher.finalize()
    }
}

fn difference<V: ToString>(what: &str, expected: Option<V>, found: Option<V>) -> Difference {
    let text = |value: Option<V>| value.map(|value| value.to_string());
    Difference { what: what.to_string(), expected: text(expected), found: text(found) }
}
