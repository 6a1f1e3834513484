//! What the unit tests of all modules share.

use proptest::prelude::ProptestConfig;

/// Set to 1 by `make test-long`.
const LONG: &str = "TERRABITE_LONG_TESTS";

/// A property is tried `usual` times by `make test` and `long` times by `make test-long`.
pub(crate) fn cases(usual: u32, long: u32) -> ProptestConfig {
    assert!(usual <= long, "{usual} cases are more than {long}");
    ProptestConfig::with_cases(if is_long() { long } else { usual })
}

fn is_long() -> bool {
    std::env::var_os(LONG).is_some_and(|value| value == "1")
}

#[test]
fn the_long_tests_are_asked_for_by_name() {
    assert_eq!(cases(3, 40).cases, if is_long() { 40 } else { 3 });
}
