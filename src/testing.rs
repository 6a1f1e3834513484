//! What the unit tests of all modules share.

use proptest::prelude::ProptestConfig;
use tempfile::TempDir;

use crate::fuzzing::temp_dir;
use crate::job::Params;

/// Set to 1 by `make test-long`.
const LONG: &str = "TERRABITE_LONG_TESTS";

/// A property is tried `usual` times by `make test` and `long` times by `make test-long`.
pub(crate) fn cases(usual: u32, long: u32) -> ProptestConfig {
    assert!(usual <= long, "{usual} cases are more than {long}");
    ProptestConfig::with_cases(if is_long() { long } else { usual })
}

/// Whether `make test-long` runs.
pub(crate) fn is_long() -> bool {
    std::env::var_os(LONG).is_some_and(|value| value == "1")
}

/// A folder for small files, in memory where there is such a place: a finished mesh is synced, and for a disk that takes
/// longer than all else a small mesh needs.
pub(crate) fn folder() -> TempDir {
    tempfile::tempdir_in(temp_dir()).expect("a folder")
}

/// The same parameters, with temporary files in memory.
pub(crate) fn in_memory(params: &Params) -> Params {
    Params { temp_dir: temp_dir(), ..params.clone() }
}

#[test]
fn the_long_tests_are_asked_for_by_name() {
    assert_eq!(cases(3, 40).cases, if is_long() { 40 } else { 3 });
}

/// A band of a raster, from 1.
///
/// # Panics
/// If it cannot be opened.
pub(crate) fn band(path: &std::path::Path, number: usize) -> crate::base::Band {
    crate::raster::Raster::open(path, number).and_then(|raster| raster.to_band()).expect("a raster")
}
