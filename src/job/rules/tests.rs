//! The rule book: ways out lead out, and engines are as it says.

use proptest::prelude::*;

use super::*;

/// Doing what all conflicts together suggest must lead to no further refusal.
fn the_way_out_leads_out(features: FeatureSet) {
    let Err(Incompatible { conflicts }) = check(features) else { return };
    let way_out = conflicts.iter().fold(features, |set, conflict| conflict.resolve(set));
    let further = check(way_out);
    assert_eq!(further, Ok(()), "from {features:?} to {way_out:?}");
}

#[test]
fn every_way_out_of_up_to_three_features_leads_out() {
    let all = Feature::ALL;
    for (i, &a) in all.iter().enumerate() {
        for (j, &b) in all.iter().enumerate().skip(i) {
            for &c in &all[j..] {
                the_way_out_leads_out([a, b, c].into_iter().collect());
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn every_way_out_of_many_features_leads_out(wanted in proptest::collection::vec(0..Feature::ALL.len(), 4..12)) {
        the_way_out_leads_out(wanted.into_iter().map(|i| Feature::ALL[i]).collect());
    }
}

#[test]
fn no_rule_is_about_itself_or_said_twice() {
    let mut pairs = Vec::new();
    for rule in RULES {
        let others = match rule.relation {
            Relation::Excludes(others) => others,
            Relation::Requires(_) => &[],
        };
        for &feature in rule.features {
            for &other in others {
                assert_ne!(feature, other);
                pairs.push((feature.min(other), feature.max(other)));
            }
        }
    }
    let said = pairs.len();
    pairs.sort();
    pairs.dedup();
    assert_eq!(pairs.len(), said);
}

#[test]
fn all_conflicts_are_reported_at_once_in_words() {
    let wanted = [Feature::GreedyCuts, Feature::CutOrder, Feature::Shape, Feature::DataDependentSwap];
    let wanted = wanted.into_iter().chain([Feature::AttributeWeight]);
    let Err(incompatible) = check(wanted.collect()) else { panic!("refused") };
    let lines: Vec<String> = incompatible.to_string().lines().map(str::to_string).collect();
    let begins = [
        "data-dependent swapping and a measure of shape cannot be combined with greedy cuts",
        "a weight of the attributes requires attributes: it is",
    ];
    assert_eq!(lines.len(), begins.len(), "{lines:?}");
    for (line, begin) in lines.iter().zip(begins) {
        assert!(line.starts_with(begin), "{line}");
    }
    assert!(lines[0].ends_with("; do without greedy cuts and an order of greedy cuts"), "{}", lines[0]);
    assert!(lines[1].ends_with("; add attributes"));
    assert!(!incompatible.to_string().contains("--"), "{incompatible}");
}

#[test]
fn what_is_given_up_anyway_is_not_asked_to_have_more() {
    let conflicts = |wanted: &[Feature]| check(wanted.iter().copied().collect()).expect_err("refused").conflicts;
    // Fitted heights want polishing; but attributes want no fitted heights.
    let fitted = conflicts(&[Feature::Attributes, Feature::FittedHeights]);
    assert_eq!(fitted.len(), 1);
    assert_eq!(fitted[0].way_out, WayOut::GiveUpThose);
    // Where what is required does not go with the rest, it is not suggested.
    let weight = conflicts(&[Feature::GreedyCuts, Feature::AttributeWeight]);
    assert_eq!(weight.len(), 1);
    assert_eq!(weight[0].way_out, WayOut::GiveUpThese);
}

#[test]
fn defaults_go_with_what_is_asked_for() {
    let quality = |feature: Feature| default_quality(FeatureSet::default().with(feature));
    for feature in [
        Feature::VertexBudget,
        Feature::RmsGoal,
        Feature::Attributes,
        Feature::Image,
        Feature::Importance,
        Feature::FittedHeights,
        Feature::Points,
        Feature::Trim,
    ] {
        assert_eq!(quality(feature), Quality::default(), "{feature}");
    }
    let by_cuts = |features: &[Feature]| {
        matches!(default_engine(features.iter().copied().collect()), EngineChoice::GreedyCuts(_))
    };
    assert!(by_cuts(&[]) && by_cuts(&[Feature::CutOrder]) && by_cuts(&[Feature::CutOrder, Feature::Polishing]));
    assert!(!by_cuts(&[Feature::TriangleBudget]) && by_cuts(&[Feature::TriangleBudget, Feature::CutOrder]));
    assert!(
        !by_cuts(&[Feature::Polishing])
            && !by_cuts(&[Feature::Breaklines])
            && !by_cuts(&[Feature::Points])
            && !by_cuts(&[Feature::Attributes])
    );
    assert!(!by_cuts(&[Feature::Fit, Feature::CutOrder]));
}

#[test]
fn insertion_stops_in_order_where_nothing_is_in_the_way() {
    let stops = |features: &[Feature]| stops_in_order(features.iter().copied().collect());
    assert!(stops(&[Feature::TriangleBudget]) && stops(&[Feature::RmsGoal, Feature::Points, Feature::Importance]));
    for feature in [Feature::Polishing, Feature::Trim, Feature::FilledVoids, Feature::Attributes, Feature::GreedyCuts] {
        assert!(!stops(&[Feature::TriangleBudget, feature]), "{feature}");
    }
}

/// What the rules say of engines is what engines say of themselves.
#[test]
fn engines_are_as_they_say() {
    let cuts = EngineChoice::from(GreedyCuts::PLAIN);
    let insertion = EngineChoice::from(GreedyInsertion::default());
    let goes = |feature: Feature, by_cuts: bool| {
        let set = FeatureSet::default().with(feature);
        check(if by_cuts { set.with(Feature::GreedyCuts) } else { set }).is_ok()
    };
    for (engine, by_cuts) in [(cuts, true), (insertion, false)] {
        assert_eq!(engine.capabilities().points, goes(Feature::Points, by_cuts));
        assert_eq!(engine.capabilities().channels, goes(Feature::Attributes, by_cuts));
        assert_eq!(engine.capabilities().edges, goes(Feature::Breaklines, by_cuts));
    }
}
