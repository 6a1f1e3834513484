//! What the tests share: running the binary, making rasters, looking at folders.
#![allow(dead_code, unused_imports, reason = "each test uses what it needs")]

mod dem;
mod folder;
mod netcdf;
mod ply;
mod run;
mod served;
mod shared;

pub(crate) use dem::{Dem, Kind, hills};
pub(crate) use folder::{Folder, names_that_come_up};
pub(crate) use netcdf::{Axis, Cube};
pub(crate) use ply::{flat, ply, without_comments};
pub(crate) use run::{
    Halted, Run, terrabite, terrabite_disturbed, terrabite_in_environment, terrabite_in_group, terrabite_stopped,
    terrabite_with_fault, terrabite_with_file_limit,
};
pub(crate) use served::Served;
pub(crate) use shared::made_once;

use std::path::{Path, PathBuf};

/// Whether `make test-long` runs: the same tests on rasters of full size.
pub(crate) fn is_long() -> bool {
    std::env::var_os("TERRABITE_LONG_TESTS").is_some_and(|value| value == "1")
}

/// A real terrain from the folder beside the project; `None`, with a message, where it is absent.
pub(crate) fn shared_data(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if !path.is_file() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

/// A flat raster at height 3 and a mesh that fits it.
pub(crate) fn with_both() -> (Folder, String, String) {
    let folder = Folder::new();
    let dem = Dem::new(20, 10).heights(|_, _| 3.0).write(&folder, "dem.tif");
    let tin = folder.with("tin.ply", flat(20, 10, 3.0));
    (folder, dem, tin)
}
