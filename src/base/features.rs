//! What a run may be asked for, as data: [`Feature`] is one such thing, [`FeatureSet`] all that are wanted together.
//!
//! Nothing here knows which of them go together: that stands in [`crate::job::rules`]. Nor does anything know of options:
//! each feature has a name in words, and whoever has options maps features to them.

use std::fmt;

macro_rules! features {
    ($($(#[$more:meta])* $feature:ident = $name:literal,)*) => {
        /// Something that a run may be asked for. Each is called as its documentation says.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum Feature {
            $(#[doc = $name] $(#[$more])* $feature,)*
        }

        impl Feature {
            /// All of them, in the order in which they are listed.
            pub const ALL: &'static [Feature] = &[$(Feature::$feature,)*];

            /// What it is called in messages, such as "polishing".
            pub fn name(self) -> &'static str {
                match self {
                    $(Feature::$feature => $name,)*
                }
            }
        }
    };
}

features! {
    VertexBudget = "a budget of vertices",
    TriangleBudget = "a budget of triangles",
    RmsGoal = "a root mean square error to reach",
    Attributes = "attributes",
    Image = "an image without heights",
    AttributeWeight = "a weight of the attributes",
    Importance = "importance weights",
    Points = "given points",
    Breaklines = "breaklines",
    Lakes = "lakes",
    Footprints = "footprints",
    LineHeights = "heights of breaklines themselves",
    Trim = "trimming",
    FilledVoids = "filled voids",
    Band = "a choice of the band",
    Encoding = "heights stored as colours",
    NodataMarks = "marks of missing samples",
    ValidRange = "a range of valid heights",
    Cutline = "a cutline",
    ExactCutline = "an exact cutline",
    Polishing = "polishing",
    FittedHeights = "fitted heights",
    MinAngle = "a smallest angle",
    MaxStray = "a limit on straying",
    PolishingNumbers = "numbers of the polishing schedule",
    StrongPolishEdges = "strongly feasible edges in polishing",
    WeakPolishEdges = "weakly feasible edges in polishing",
    StrongFeasibility = "strong feasibility",
    GreedyCuts = "greedy cuts",
    CutOrder = "an order of greedy cuts",
    HittingSet = "hitting sets",
    Squares = "a choice of squares",
    SampledCorners = "sampled heights of shared corners",
    FreeCorners = "free heights of shared corners",
    Stitching = "a choice of stitching",
    DelaunaySwap = "swapping by the circle test",
    DataDependentSwap = "data-dependent swapping",
    QualityThreshold = "a quality threshold",
    Shape = "a measure of shape",
    Fit = "a measure of fit",
    SequentialSelection = "sequential selection",
    FractionalSelection = "fractional selection",
    ConstantSelection = "constant selection",
    Fraction = "a fraction for selection",
    LocalErrorMeasure = "insertion by local error",
    GlobalErrorMeasure = "insertion by global error",
    /// By curvature alone, or by error times curvature.
    SmoothedMeasure = "insertion by curvature",
    Smoothing = "smoothing",
    /// A factor for the heights in the output that is no power of two.
    InexactScale = "heights scaled by a factor that rounds them",
    /// Single precision, and heights that it cannot hold.
    RoundedToSingle = "heights rounded to single precision",
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Values of one option, of which a run has one at the most.
const ALTERNATIVES: &[&[Feature]] = &[
    &[Feature::Attributes, Feature::Image],
    &[Feature::StrongPolishEdges, Feature::WeakPolishEdges],
    &[Feature::GreedyCuts, Feature::HittingSet],
    &[Feature::SampledCorners, Feature::FreeCorners],
    &[Feature::DelaunaySwap, Feature::DataDependentSwap],
    &[Feature::SequentialSelection, Feature::FractionalSelection, Feature::ConstantSelection],
    &[Feature::LocalErrorMeasure, Feature::GlobalErrorMeasure, Feature::SmoothedMeasure],
];

/// Features that are wanted together.
#[derive(Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct FeatureSet(u64);

const _: () = assert!(Feature::ALL.len() <= 64, "one bit for each feature");

impl FeatureSet {
    /// The same with another feature, which takes the place of other values of the same option.
    #[must_use]
    pub fn with(self, feature: Feature) -> FeatureSet {
        let others = ALTERNATIVES.iter().filter(|values| values.contains(&feature)).copied().flatten();
        let kept = others.fold(self, |set, &other| set.without(other));
        FeatureSet(kept.0 | bit(feature))
    }

    /// The same without a feature.
    #[must_use]
    pub fn without(self, feature: Feature) -> FeatureSet {
        FeatureSet(self.0 & !bit(feature))
    }

    /// The features of both sets.
    #[must_use]
    pub fn and(self, other: FeatureSet) -> FeatureSet {
        FeatureSet(self.0 | other.0)
    }

    /// Whether a feature is wanted.
    pub fn has(self, feature: Feature) -> bool {
        self.0 & bit(feature) != 0
    }

    /// Those of `features` that are wanted, in their order.
    pub fn among(self, features: &[Feature]) -> Vec<Feature> {
        features.iter().copied().filter(|&feature| self.has(feature)).collect()
    }

    /// What is wanted, in the order of [`Feature::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Feature> {
        Feature::ALL.iter().copied().filter(move |&feature| self.has(feature))
    }
}

fn bit(feature: Feature) -> u64 {
    1 << feature as u32
}

impl FromIterator<Feature> for FeatureSet {
    fn from_iter<I: IntoIterator<Item = Feature>>(features: I) -> FeatureSet {
        features.into_iter().fold(FeatureSet::default(), FeatureSet::with)
    }
}

impl fmt::Debug for FeatureSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_has_one_value_of_an_option() {
        let set = FeatureSet::from_iter([Feature::Shape, Feature::DelaunaySwap]).with(Feature::DataDependentSwap);
        assert_eq!(set.iter().collect::<Vec<_>>(), [Feature::DataDependentSwap, Feature::Shape]);
        assert_eq!(set.without(Feature::Shape).and(set), set);
    }

    #[test]
    fn names_are_different() {
        let mut names: Vec<&str> = Feature::ALL.iter().map(|f| f.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Feature::ALL.len());
    }
}
