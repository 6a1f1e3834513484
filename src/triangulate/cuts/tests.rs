use super::GreedyCuts;
use crate::triangulate::conformance::conformance;

conformance!(plain, GreedyCuts);
