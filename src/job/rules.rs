//! The rule book: which features of a run do not go together, why, and what to do instead.
//!
//! [`RULES`] is the only place that says so. It is asked once by everyone who starts work ([`super::triangulate_into`],
//! [`super::probe_field`], the command line before it opens anything), [`check`] reports all conflicts at once, and
//! defaults follow from it ([`default_quality`], [`default_engine`]). The table of combinations in `docs/options.md` is
//! printed from it. Doing what all conflicts together suggest leads to no further refusal; a test tries all sets of up to
//! three features, and many larger ones.

use std::fmt;

use super::{EngineChoice, Quality};
use crate::base::features::{Feature, FeatureSet};
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::GreedyInsertion;

/// Features that do not go with others, or not without another.
#[derive(Debug, PartialEq, Eq)]
pub struct Rule {
    /// The features that it is about: it holds for each of them.
    pub features: &'static [Feature],
    /// What they do not go with, or not without.
    pub relation: Relation,
    /// Why, as a clause in words.
    pub why: &'static str,
    /// Who has to keep it.
    pub scope: Scope,
}

/// How the features of a rule and others belong together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// They cannot be combined with any of these; the way out is to give these up.
    Excludes(&'static [Feature]),
    /// They mean nothing without this one; the way out is to take it, too, or to give them up where it does not go with
    /// the rest.
    Requires(Feature),
}

/// Who has to keep a rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// Whoever makes a mesh.
    Run,
    /// Whoever looks at samples or judges errors, too: the rule is about what samples and errors are.
    Samples,
}

/// What ends a run before all samples are within the tolerance.
const GOALS: &[Feature] = &[Feature::VertexBudget, Feature::TriangleBudget, Feature::RmsGoal];

/// Values of vertices beside their height, or instead of it.
const ATTRIBUTES: &[Feature] = &[Feature::Attributes, Feature::Image];

/// Lines that become edges, and what is part of them.
const LINES: &[Feature] =
    &[Feature::Breaklines, Feature::Lakes, Feature::Footprints, Feature::ExactCutline, Feature::LineHeights];

/// Lines that become edges, of any kind.
const EDGES: &[Feature] = &[Feature::Breaklines, Feature::Lakes, Feature::Footprints, Feature::ExactCutline];

/// What is part of polishing, and means nothing without it.
const OF_POLISHING: &[Feature] = &[
    Feature::FittedHeights,
    Feature::MinAngle,
    Feature::PolishingNumbers,
    Feature::StrongPolishEdges,
    Feature::WeakPolishEdges,
];

/// The engine of greedy cuts, and what is part of it.
const CUTS: &[Feature] = &[Feature::GreedyCuts, Feature::CutOrder];

/// The engine of hitting sets, and what is part of it.
const HITTING_SETS: &[Feature] =
    &[Feature::HittingSet, Feature::Squares, Feature::SampledCorners, Feature::FreeCorners, Feature::Stitching];

/// What is part of the engine of greedy insertion.
const OF_INSERTION: &[Feature] = &[
    Feature::DelaunaySwap,
    Feature::DataDependentSwap,
    Feature::QualityThreshold,
    Feature::Shape,
    Feature::Fit,
    Feature::SequentialSelection,
    Feature::FractionalSelection,
    Feature::ConstantSelection,
    Feature::Fraction,
    Feature::LocalErrorMeasure,
    Feature::GlobalErrorMeasure,
    Feature::SmoothedMeasure,
    Feature::Smoothing,
];

/// What keeps greedy insertion from stopping at a goal by itself, one sample after the other in the order of a whole raster:
/// what follows insertion, what comes before it with a tolerance of its own, other engines, other orders, other errors.
const OUT_OF_ORDER: &[&[Feature]] = &[
    CUTS,
    HITTING_SETS,
    ATTRIBUTES,
    EDGES,
    &[
        Feature::Polishing,
        Feature::Trim,
        Feature::FilledVoids,
        Feature::MaxStray,
        Feature::FractionalSelection,
        Feature::ConstantSelection,
        Feature::Fraction,
        Feature::GlobalErrorMeasure,
        Feature::SmoothedMeasure,
        Feature::Smoothing,
    ],
];

/// Whether a goal is met by insertion that stops in order. If not, a tolerance is looked for ([`crate::job::search`]).
pub(super) fn stops_in_order(features: FeatureSet) -> bool {
    OUT_OF_ORDER.iter().all(|some| features.among(some).is_empty())
}

const fn exclude(features: &'static [Feature], others: &'static [Feature], why: &'static str) -> Rule {
    Rule { features, relation: Relation::Excludes(others), why, scope: Scope::Run }
}

const fn require(features: &'static [Feature], needed: Feature, why: &'static str) -> Rule {
    Rule { features, relation: Relation::Requires(needed), why, scope: Scope::Run }
}

const fn everywhere(rule: Rule) -> Rule {
    Rule { scope: Scope::Samples, ..rule }
}

/// All rules. Where a feature is given up, so is what is part of it: each rule says so by itself.
pub const RULES: &[Rule] = &[
    exclude(
        ATTRIBUTES,
        &[Feature::FittedHeights],
        "fitted heights stand between samples, too, where there are no attribute values",
    ),
    exclude(ATTRIBUTES, &[Feature::FilledVoids], "filled voids have no attribute values"),
    exclude(ATTRIBUTES, CUTS, "greedy cuts bound no errors in attributes"),
    exclude(ATTRIBUTES, HITTING_SETS, "hitting sets bound no errors in attributes"),
    everywhere(exclude(
        ATTRIBUTES,
        &[Feature::Importance],
        "the weighted error of attributes knows no weights of samples",
    )),
    everywhere(exclude(&[Feature::Image], &[Feature::ValidRange], "an image has no heights")),
    everywhere(exclude(&[Feature::Image], &[Feature::AttributeWeight], "nothing but attributes counts in an image")),
    everywhere(exclude(&[Feature::Image], &[Feature::Band, Feature::Encoding], "an image has no heights")),
    everywhere(exclude(&[Feature::Encoding], &[Feature::Band], "colours stand for heights in three bands together")),
    exclude(
        &[Feature::Attributes],
        &[Feature::InexactScale, Feature::RoundedToSingle],
        "what rounding loses of heights is taken from the tolerance of heights, not from that of heights and attributes together",
    ),
    exclude(ATTRIBUTES, LINES, "edges of lines end between samples, where attributes have no values"),
    everywhere(exclude(
        EDGES,
        &[Feature::Importance],
        "the surface along lines is held to the tolerance itself, not to a weighted one",
    )),
    everywhere(exclude(EDGES, &[Feature::FilledVoids], "filled voids have no heights that lines could be held to")),
    everywhere(exclude(EDGES, &[Feature::Trim], "trimming may remove the ground that edges of lines lie on")),
    exclude(EDGES, &[Feature::StrongFeasibility], "edges of lines are not held to the diagonals of cells"),
    everywhere(require(
        &[Feature::ExactCutline],
        Feature::Cutline,
        "it is the outlines of its polygons that the mesh ends at",
    )),
    everywhere(require(&[Feature::LineHeights], Feature::Breaklines, "it is the heights of these lines that count")),
    exclude(EDGES, HITTING_SETS, "squares take no given edges"),
    exclude(OF_INSERTION, CUTS, "greedy cuts have no edges to swap and no candidates to select"),
    exclude(CUTS, HITTING_SETS, "a tile is triangulated by one engine"),
    exclude(OF_INSERTION, HITTING_SETS, "squares are repaired by insertion with its usual options"),
    everywhere(require(&[Feature::AttributeWeight], Feature::Attributes, "it is what attributes count beside heights")),
    require(&[Feature::CutOrder], Feature::GreedyCuts, "no other engine makes cuts"),
    require(
        &[Feature::Squares, Feature::SampledCorners, Feature::FreeCorners, Feature::Stitching],
        Feature::HittingSet,
        "no other engine covers samples with squares",
    ),
    require(
        &[Feature::FreeCorners],
        Feature::FittedHeights,
        "heights of vertices that are not those of samples are fitted heights",
    ),
    require(&[Feature::FreeCorners], Feature::Polishing, "heights are fitted where meshes are polished"),
    require(
        &[Feature::QualityThreshold, Feature::Shape, Feature::Fit],
        Feature::DataDependentSwap,
        "only data-dependent swapping weighs shape against fit",
    ),
    require(
        &[Feature::Fraction],
        Feature::FractionalSelection,
        "it is the share of the largest error from which on candidates are selected",
    ),
    require(&[Feature::Smoothing], Feature::SmoothedMeasure, "only heights whose curvature is measured are smoothed"),
    require(OF_POLISHING, Feature::Polishing, "only polishing uses such options"),
    exclude(
        &[Feature::StrongFeasibility],
        &[Feature::WeakPolishEdges],
        "polishing would undo what strong feasibility asks for",
    ),
];

/// A feature that a run made in shards has to do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0} without polishing cannot be had of a run that is made in shards: insertion stops where all tiles together meet it"
)]
pub struct NotInShards(pub Feature);

/// Makes sure that a run with these features can be made in shards.
///
/// # Errors
/// [`NotInShards`].
pub fn check_shards(features: FeatureSet) -> Result<(), NotInShards> {
    match features.among(GOALS).first() {
        Some(&goal) if stops_in_order(features) => Err(NotInShards(goal)),
        _ => Ok(()),
    }
}

impl Rule {
    /// How `features` break this rule, if they do.
    fn broken_by(&'static self, features: FeatureSet) -> Option<Conflict> {
        let these = features.among(self.features);
        let those = match self.relation {
            Relation::Excludes(others) => features.among(others),
            Relation::Requires(needed) if features.has(needed) => Vec::new(),
            Relation::Requires(needed) => vec![needed],
        };
        let way_out = match self.relation {
            Relation::Excludes(_) => WayOut::GiveUpThose,
            Relation::Requires(needed) => WayOut::Add(needed),
        };
        (!these.is_empty() && !those.is_empty()).then_some(Conflict { rule: self, these, those, way_out })
    }
}

/// A rule that is not kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conflict {
    /// The rule.
    pub rule: &'static Rule,
    /// The features it is about that are wanted; at least one.
    pub these: Vec<Feature>,
    /// Those that are wanted although they are excluded, or the one that is required; at least one.
    pub those: Vec<Feature>,
    /// What to do instead.
    pub way_out: WayOut,
}

/// What to do instead of what does not go together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WayOut {
    /// Give up [`Conflict::these`].
    GiveUpThese,
    /// Give up [`Conflict::those`].
    GiveUpThose,
    /// Take another feature, too.
    Add(Feature),
}

/// How features are called, and what is done to have them or not.
pub trait Words {
    /// What a feature is called; it may be asked for in several ways.
    fn names(&self, feature: Feature) -> Vec<String> {
        vec![feature.name().to_string()]
    }

    /// How to do without features, at least one, as a demand.
    fn without(&self, features: &[Feature]) -> String {
        format!("do without {}", list(features.iter().flat_map(|&f| self.names(f))))
    }

    /// How to have a feature, too, as a demand.
    fn with(&self, feature: Feature) -> String {
        format!("add {}", feature.name())
    }
}

/// Features by their names.
#[derive(Debug, Clone, Copy, Default)]
pub struct Names;

impl Words for Names {}

impl Conflict {
    /// The features that the way out gives up.
    fn given_up(&self) -> &[Feature] {
        match self.way_out {
            WayOut::GiveUpThese => &self.these,
            WayOut::GiveUpThose => &self.those,
            WayOut::Add(_) => &[],
        }
    }

    /// The features as they are once the way out was taken.
    #[must_use]
    pub fn resolve(&self, features: FeatureSet) -> FeatureSet {
        let rest = self.given_up().iter().fold(features, |set, &feature| set.without(feature));
        match self.way_out {
            WayOut::Add(needed) => rest.with(needed),
            WayOut::GiveUpThese | WayOut::GiveUpThose => rest,
        }
    }

    /// What does not go together, why, and the way out, in one line.
    pub fn in_words(&self, words: &dyn Words) -> String {
        let named = |features: &[Feature]| list(features.iter().flat_map(|&f| words.names(f)));
        let (these, those, why) = (named(&self.these), named(&self.those), self.rule.why);
        let relation = match self.rule.relation {
            Relation::Excludes(_) => "cannot be combined with",
            Relation::Requires(_) if self.these.iter().map(|&f| words.names(f).len()).sum::<usize>() == 1 => "requires",
            Relation::Requires(_) => "each require",
        };
        let way_out = match self.way_out {
            WayOut::Add(needed) => words.with(needed),
            WayOut::GiveUpThese | WayOut::GiveUpThose => words.without(self.given_up()),
        };
        format!("{these} {relation} {those}: {why}; {way_out}")
    }
}

/// Things in a sentence, each of them once.
pub fn list(things: impl Iterator<Item = String>) -> String {
    let mut all: Vec<String> = Vec::new();
    for thing in things.filter(|thing| !thing.is_empty()) {
        if !all.contains(&thing) {
            all.push(thing);
        }
    }
    match all.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Features that do not go together: every conflict, in the order of [`RULES`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct Incompatible {
    /// At least one.
    pub conflicts: Vec<Conflict>,
}

impl fmt::Display for Incompatible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines: Vec<String> = self.conflicts.iter().map(|c| c.in_words(&Names)).collect();
        f.write_str(&lines.join("\n"))
    }
}

/// Makes sure that features go together in a run.
///
/// # Errors
/// [`Incompatible`], with all conflicts. A feature that is to be given up for one of them is not reported again for what
/// it requires.
pub fn check(features: FeatureSet) -> Result<(), Incompatible> {
    check_foreseeing(features, FeatureSet::default())
}

/// The same before it is known whether a run has some features more: no way out adds what does not go with them.
///
/// # Errors
/// As [`check`].
pub fn check_foreseeing(features: FeatureSet, possible: FeatureSet) -> Result<(), Incompatible> {
    check_for(Scope::Run, features, possible)
}

/// Makes sure that features go together where samples are read and errors judged, but no mesh is made.
///
/// # Errors
/// As [`check`].
pub fn check_samples(features: FeatureSet) -> Result<(), Incompatible> {
    check_for(Scope::Samples, features, FeatureSet::default())
}

fn check_for(scope: Scope, features: FeatureSet, possible: FeatureSet) -> Result<(), Incompatible> {
    let rules = RULES.iter().filter(|rule| scope == Scope::Run || rule.scope == scope);
    let mut conflicts: Vec<Conflict> = rules.filter_map(|rule| rule.broken_by(features)).collect();
    let given_up: FeatureSet = conflicts.iter().flat_map(Conflict::given_up).copied().collect();
    let mut rest = given_up.iter().fold(features, FeatureSet::without);
    conflicts.retain_mut(|conflict| {
        let WayOut::Add(needed) = conflict.way_out else { return true };
        conflict.these.retain(|&feature| !given_up.has(feature));
        match rest.with(needed) {
            more if !more.and(possible).is_contradictory() => rest = more,
            _ => conflict.way_out = WayOut::GiveUpThese,
        }
        !conflict.these.is_empty()
    });
    if conflicts.is_empty() { Ok(()) } else { Err(Incompatible { conflicts }) }
}

impl FeatureSet {
    /// Whether features in it exclude others in it.
    fn is_contradictory(self) -> bool {
        self.iter().any(|feature| excluded(self, feature))
    }
}

/// Whether a feature that is wanted excludes another one.
fn excluded(features: FeatureSet, other: Feature) -> bool {
    let excludes = |rule: &Rule| match rule.relation {
        Relation::Excludes(others) => others.contains(&other) && !features.among(rule.features).is_empty(),
        Relation::Requires(_) => false,
    };
    RULES.iter().any(excludes)
}

/// How much a mesh is polished where nothing is said: as usual, or not at all where a feature excludes it.
pub fn default_quality(features: FeatureSet) -> Quality {
    if excluded(features, Feature::Polishing) { Quality::None } else { Quality::default() }
}

/// How far the surface may stray between samples where nothing is said, in tolerances: nowhere far where meshes are polished
/// with time, anywhere else.
pub fn default_max_stray(features: FeatureSet, quality: Quality) -> f64 {
    match quality {
        Quality::Balanced | Quality::Best if !excluded(features, Feature::MaxStray) => MAX_STRAY,
        _ => f64::INFINITY,
    }
}

/// See [`default_max_stray`]. The price of other limits stands in docs/quality.md.
const MAX_STRAY: f64 = 1.5;

/// The engine where none is named, once it is known whether meshes are polished: greedy cuts with an order of theirs, or
/// alone, where they are the fastest; greedy insertion for polishing, which comes to fewer triangles from there, and
/// sooner; for goals, which it meets exactly; for given points and edges, which it knows from the start; and where a feature
/// excludes greedy cuts.
pub fn default_engine(features: FeatureSet) -> EngineChoice {
    let others = [GOALS, EDGES, &[Feature::Polishing, Feature::Points]];
    let is_alone = others.iter().all(|some| features.among(some).is_empty());
    let by_cuts = features.has(Feature::CutOrder) || is_alone;
    if by_cuts && !excluded(features, Feature::GreedyCuts) {
        return GreedyCuts::PLAIN.into();
    }
    GreedyInsertion::default().into()
}

#[cfg(test)]
mod tests;
