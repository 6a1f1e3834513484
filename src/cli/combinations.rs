//! Which options ask for which features of a run, and what is said where features do not go together.
//!
//! [`options`] is the one table that maps features to options. What does not go together stands in [`crate::job::rules`]
//! alone; here it gets the names of options.

use super::Failure;
use crate::base::features::{Feature, FeatureSet};
use crate::job::rules::{self, Incompatible, Words, list};

/// How a feature is asked for, and how not.
struct Options {
    /// The options that ask for it, with their values where others do not.
    any: &'static str,
    /// One of them, to be used.
    one: &'static str,
    without: Without,
}

/// How to do without a feature.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Without {
    /// Remove the option.
    Remove,
    /// Use another value.
    Use(&'static str),
    /// Use another option in its place.
    Replace(&'static str),
}

/// The options for a feature.
fn options(feature: Feature) -> Options {
    use Without::{Remove, Replace, Use};
    let (any, without) = match feature {
        Feature::VertexBudget => ("--max-points", Replace("--max-error")),
        Feature::TriangleBudget => ("--max-triangles", Replace("--max-error")),
        Feature::RmsGoal => ("--max-rms", Replace("--max-error")),
        Feature::Attributes => ("--attributes", Remove),
        Feature::Image => ("--image", Remove),
        Feature::AttributeWeight => ("--attribute-weight", Remove),
        Feature::Importance => ("--importance", Remove),
        Feature::Points => ("--points", Remove),
        Feature::Breaklines => ("--breaklines", Remove),
        Feature::Lakes => ("--lake-polygons", Remove),
        Feature::Footprints => ("--footprints", Remove),
        Feature::LineHeights => ("--breakline-z line", Remove),
        Feature::Trim => ("--trim", Remove),
        Feature::FilledVoids => ("--fill-holes", Remove),
        Feature::Band => ("--band", Remove),
        Feature::Encoding => ("--encoding", Remove),
        Feature::NodataMarks => ("--nodata", Remove),
        Feature::ValidRange => ("--valid-range", Remove),
        Feature::Cutline => ("--cutline", Remove),
        Feature::ExactCutline => ("--cutline-exact", Remove),
        Feature::Polishing => ("--quality fast, balanced or best", Use("--quality none")),
        Feature::FittedHeights => ("--heights fitted", Remove),
        Feature::MinAngle => ("--min-angle", Remove),
        Feature::MaxStray => ("--max-stray", Remove),
        Feature::PolishingNumbers => ("--polish-…", Remove),
        Feature::StrongPolishEdges => ("--polish-edges strong", Remove),
        Feature::WeakPolishEdges => ("--polish-edges weak", Remove),
        Feature::StrongFeasibility => ("--feasibility strong", Remove),
        Feature::GreedyCuts => ("--engine greedy-cuts", Use("--engine greedy-insertion")),
        Feature::CutOrder => ("--cuts", Remove),
        Feature::HittingSet => ("--engine hitting-set", Use("--engine greedy-insertion")),
        Feature::Squares => ("--squares", Remove),
        Feature::SampledCorners => ("--corners samples", Remove),
        Feature::FreeCorners => ("--corners free", Remove),
        Feature::Stitching => ("--stitching", Remove),
        Feature::DelaunaySwap => ("--swap delaunay", Remove),
        Feature::DataDependentSwap => ("--swap data-dependent", Remove),
        Feature::QualityThreshold => ("--quality-threshold", Remove),
        Feature::Shape => ("--shape", Remove),
        Feature::Fit => ("--fit", Remove),
        Feature::SequentialSelection => ("--selection sequential", Remove),
        Feature::FractionalSelection => ("--selection fractional", Remove),
        Feature::ConstantSelection => ("--selection constant", Remove),
        Feature::Fraction => ("--fraction", Remove),
        Feature::LocalErrorMeasure => ("--measure local-error", Remove),
        Feature::GlobalErrorMeasure => ("--measure global-error", Remove),
        Feature::SmoothedMeasure => ("--measure curvature or product", Remove),
        Feature::Smoothing => ("--smoothing", Remove),
        Feature::InexactScale => ("--z-scale, if it is no power of two", Use("--z-scale 1 or another power of two")),
        Feature::RoundedToSingle => {
            ("--precision float, if heights need more digits than it has", Use("--precision double"))
        }
    };
    let one = match feature {
        Feature::Polishing => "--quality balanced",
        Feature::SmoothedMeasure => "--measure curvature",
        _ => any,
    };
    Options { any, one, without }
}

/// One of the options that ask for a feature.
pub(super) fn option(feature: Feature) -> &'static str {
    options(feature).one
}

/// What a feature's option begins with where it is the format of the output that asks for it.
pub(super) const BY_FORMAT: &str = "the format ";

/// What a command line asks for.
#[derive(Debug, Clone, Default)]
pub(super) struct Asked {
    /// Features, and the options by which they are asked for. A feature may be there more than once.
    given: Vec<(Feature, String)>,
    /// Features that it may turn out to have once the raster is open.
    possible: FeatureSet,
}

impl Asked {
    /// The features.
    pub(super) fn features(&self) -> FeatureSet {
        self.given.iter().map(|(feature, _)| *feature).collect()
    }

    /// Adds a feature, if it is wanted.
    pub(super) fn add(&mut self, feature: Feature, is_wanted: bool) {
        if is_wanted {
            self.add_by(feature, options(feature).one);
        }
    }

    /// Adds a feature by an option as it is given.
    pub(super) fn add_by(&mut self, feature: Feature, option: impl Into<String>) {
        self.given.push((feature, option.into()));
    }

    /// Notes a feature that it may turn out to have.
    pub(super) fn foresee(&mut self, feature: Feature) {
        self.possible = self.possible.with(feature);
    }

    /// Makes sure that all of it goes together in a run.
    ///
    /// # Errors
    /// Exit code 2, with all conflicts, one a line.
    pub(super) fn check(&self) -> Result<(), Failure> {
        rules::check_foreseeing(self.features(), self.possible).map_err(|conflicts| self.refuse(&conflicts))
    }

    /// Makes sure that all of it goes together where samples are read and errors judged.
    ///
    /// # Errors
    /// As [`Asked::check`].
    pub(super) fn check_samples(&self) -> Result<(), Failure> {
        rules::check_samples(self.features()).map_err(|conflicts| self.refuse(&conflicts))
    }

    /// All conflicts, one a line, with the options that are given: exit code 2.
    pub(super) fn refuse(&self, incompatible: &Incompatible) -> Failure {
        let lines: Vec<String> = incompatible.conflicts.iter().map(|conflict| conflict.in_words(self)).collect();
        Failure::usage(lines.join("\nerror: "))
    }
}

impl Words for Asked {
    fn names(&self, feature: Feature) -> Vec<String> {
        let mut given: Vec<String> =
            self.given.iter().filter(|(f, _)| *f == feature).map(|(_, option)| option.clone()).collect();
        given.dedup();
        if given.is_empty() { vec![options(feature).any.to_string()] } else { given }
    }

    fn without(&self, features: &[Feature]) -> String {
        let mut ways: Vec<Without> = Vec::new();
        for &feature in features {
            let way = options(feature).without;
            if !ways.contains(&way) {
                ways.push(way);
            }
        }
        let demand = |&way: &Without| {
            let named = features.iter().filter(|&&f| options(f).without == way).flat_map(|&f| self.names(f));
            match way {
                Without::Remove => format!("remove {}", list(named)),
                Without::Use(_) if named.clone().any(|name| name.starts_with(BY_FORMAT)) => {
                    "choose a format that has doubles, such as PLY".to_string()
                }
                Without::Use(other) => format!("use {other}"),
                Without::Replace(other) => format!("use {other} instead of {}", list(named)),
            }
        };
        list(ways.iter().map(demand))
    }

    fn with(&self, feature: Feature) -> String {
        format!("use {}", options(feature).one)
    }
}

impl From<Incompatible> for Failure {
    fn from(incompatible: Incompatible) -> Failure {
        Asked::default().refuse(&incompatible)
    }
}

/// The rule book with the names of options, a row for each rule: the options it is about, how they belong to others,
/// those, why, and what to do instead. Options are code, in backticks.
#[cfg(test)]
pub(super) fn table() -> Vec<[String; 5]> {
    use crate::job::rules::{RULES, Relation};
    let code = |feature: Feature| match options(feature).any.split_once(", if ") {
        Some((option, condition)) => format!("`{option}` (if {condition})"),
        None => format!("`{}`", options(feature).any),
    };
    let names = |features: &[Feature]| features.iter().map(|&feature| code(feature)).collect::<Vec<_>>().join(", ");
    let instead = |others: &[Feature]| {
        let mut ways: Vec<String> = Vec::new();
        for &other in others {
            let way = match options(other).without {
                Without::Remove if others.len() == 1 => "remove it".to_string(),
                Without::Remove if others.iter().all(|&o| options(o).without == Without::Remove) => {
                    "remove them".to_string()
                }
                Without::Remove => "remove the others".to_string(),
                Without::Use(value) => format!("use {}", value_as_code(value)),
                Without::Replace(option) => format!("use `{option}` instead"),
            };
            if !ways.contains(&way) {
                ways.push(way);
            }
        }
        ways.join("; ")
    };
    let row = |rule: &rules::Rule| {
        let (relation, others, instead) = match rule.relation {
            Relation::Excludes(others) => ("not with", names(others), instead(others)),
            Relation::Requires(needed) => {
                ("only with", names(&[needed]), format!("use {}", value_as_code(options(needed).one)))
            }
        };
        [names(rule.features), relation.to_string(), others, rule.why.to_string(), instead]
    };
    RULES.iter().map(row).collect()
}

/// An option and its value as code, and what else is said of it.
#[cfg(test)]
fn value_as_code(text: &str) -> String {
    match text.split_once(" or ") {
        Some((option, others)) => format!("`{option}` or {others}"),
        None => format!("`{text}`"),
    }
}

#[cfg(test)]
mod tests;
