//! How much of a machine a run takes: the options that `simplify`, `plan`, `run` and `merge` share.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::{signals, values};
use crate::field::Choice;
use crate::run::{Guard, Request};

/// How a process works, whatever it makes.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct MachineArgs {
    /// The folder of temporary files [default: the system's]
    #[arg(long, help_heading = "Run", hide_short_help = true, value_name = "DIR")]
    pub(super) temp_dir: Option<PathBuf>,
    /// How samples are read: from the mapped file, in windows through GDAL, or decoded into a temporary file first
    /// [default: what suits the raster]
    #[arg(long, help_heading = "Run", hide_short_help = true, value_enum)]
    access: Option<AccessArg>,
    /// The most memory to use, such as 256MiB [default: a quarter of the machine's, at most 2 GiB]
    #[arg(long, help_heading = "Run", value_name = "BYTES", value_parser = values::bytes)]
    memory: Option<u64>,
    /// Threads to work with, fewer if the memory is for fewer [default: as many as the machine has cores]
    #[arg(long, help_heading = "Run", hide_short_help = true, value_name = "N", value_parser = values::threads)]
    threads: Option<NonZeroUsize>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AccessArg {
    /// What suits the raster
    Auto,
    /// The raster's own file, mapped
    InPlace,
    /// Windows, read through GDAL when they are wanted
    Windows,
    /// A temporary file, decoded beforehand
    Decode,
}

impl From<AccessArg> for Choice {
    fn from(argument: AccessArg) -> Choice {
        match argument {
            AccessArg::Auto => Choice::Auto,
            AccessArg::InPlace => Choice::InPlace,
            AccessArg::Windows => Choice::Windows,
            AccessArg::Decode => Choice::Decode,
        }
    }
}

impl MachineArgs {
    /// Threads, if they say how many.
    pub(super) fn threads(&self) -> Option<NonZeroUsize> {
        self.threads
    }

    /// The budget of memory, if they say one.
    pub(super) fn memory(&self) -> Option<u64> {
        self.memory
    }

    /// The first that is about reading samples of a raster, if there is one.
    pub(super) fn of_samples(&self) -> Option<&'static str> {
        let access = self.access.map(|_| "--access");
        access.or(self.temp_dir.as_ref().map(|_| "--temp-dir"))
    }

    /// Has a request do as these say; what they do not say stays as it is.
    pub(super) fn apply(&self, request: &mut Request<'_>) {
        if let Some(access) = self.access {
            request.access = access.into();
        }
        if let Some(dir) = &self.temp_dir {
            request.params.temp_dir.clone_from(dir);
        }
        request.memory = self.memory.or(request.memory);
        request.threads = self.threads.or(request.threads);
    }
}

/// Ends the process with a message where a mapped file is truncated.
pub(super) const GUARD: &Guard<'static> = &|mapped: &[PathBuf], partial: &Path| {
    let mapped: Vec<String> = mapped.iter().map(|file| file.display().to_string()).collect();
    let message = format!("error: {}: the file was truncated while it was in use", mapped.join(" or "));
    signals::exit_on_truncation(&message, partial)
};
