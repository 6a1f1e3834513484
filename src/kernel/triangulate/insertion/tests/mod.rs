//! Greedy insertion against its oracles.

mod oracles;
mod search;
mod seeded;

use proptest::prelude::*;

use super::*;
use crate::base::control::CancelToken;
use crate::base::exact::MAX_TOLERANCE;
use crate::base::lattice::in_circle;
use crate::base::{Heights, Tile};
use crate::kernel::triangulate::conformance::{check, conformance, rim, tile, tolerances, triangulate};

fn variant(swap: Swap, selection: Selection) -> GreedyInsertion {
    GreedyInsertion { options: InsertionOptions { swap, selection, ..InsertionOptions::default() } }
}

fn measured(measure: Measure) -> GreedyInsertion {
    GreedyInsertion { options: InsertionOptions { measure, ..InsertionOptions::default() } }
}

fn data_dependent(fit: Fit, shape: Shape, quality_threshold: f64) -> GreedyInsertion {
    variant(Swap::DataDependent(DataDependent { fit, shape, quality_threshold }), Selection::Sequential)
}

conformance!(delaunay, GreedyInsertion::default());
conformance!(fractional, variant(Swap::Delaunay, Selection::Fractional(0.5)));
conformance!(constant, variant(Swap::Delaunay, Selection::Constant));
conformance!(curvature, measured(Measure::Curvature(1.0)));
conformance!(global_error, measured(Measure::GlobalError));
conformance!(product, measured(Measure::Product(2.0)));
conformance!(data_dependent_max_sum, data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.5));
conformance!(data_dependent_l2, data_dependent(Fit::L2, Shape::SmallestAngle, 0.0));
conformance!(data_dependent_l_infinity, data_dependent(Fit::LInfinity, Shape::SmallestAngle, 1.0));

/// Heights rounded to 1/1024: with them errors are exact, so errors that tie do so in every algorithm. (Where errors are
/// rounded, which of two that tie is the larger depends on the order of additions.)
fn in_thousandths(tile: &Tile) -> Tile {
    let samples = (0..tile.width() * tile.height()).map(|i| tile.at(i % tile.width(), i / tile.width()));
    let heights = samples.map(|h| (h * 1024.0).round() / 1024.0).collect();
    Tile::from_heights(tile.width(), tile.height(), Heights::F64(heights))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// The paper's algorithms I, II and III insert the same samples in the same order.
    #[test]
    fn all_three_algorithms_agree(
        size in (2usize..24, 2usize..24), seed in any::<u64>(), kind in 0u8..4, tolerance in tolerances(),
    ) {
        let tile = in_thousandths(&tile(size.0, size.1, seed, kind));
        let rim = rim(&tile, tolerance);
        let third = triangulate(&GreedyInsertion::default(), &tile, &rim.domain, tolerance, Feasibility::Weak);
        prop_assert_eq!(&oracles::algorithm_ii(&tile, &rim.domain, tolerance), &third);
        prop_assert_eq!(&oracles::algorithm_i(&tile, &rim.domain, tolerance), &third);
    }

    /// Franklin's rounds, from two triangles, against the same without anything kept.
    #[test]
    fn rounds_by_turns_agree(
        size in (2usize..20, 2usize..20), seed in any::<u64>(), kind in 0u8..4, tolerance in tolerances(),
    ) {
        let tile = in_thousandths(&tile(size.0, size.1, seed, kind));
        let corners = rim(&tile, MAX_TOLERANCE).domain;
        let (cancel, mut mesh) = (CancelToken::default(), TileMesh::default());
        let task = Task {
            tile: &tile, domain: &corners, tolerance, feasibility: Feasibility::Weak, max_stray: f64::INFINITY,
            cancel: &cancel,
        };
        GreedyInsertion::default().triangulate_by_turns(&task, &mut Scratch::default(), &mut mesh).unwrap();
        prop_assert_eq!(&oracles::by_turns(&tile, &corners, tolerance), &mesh);
    }

    /// Delaunay but for the locked edges: no vertex is strictly inside a circle, unless a locked edge hides it. On a
    /// rectangle nothing is hidden.
    #[test]
    fn the_mesh_is_delaunay(size in (2usize..24, 2usize..24), seed in any::<u64>(), kind in 0u8..4, tolerance in tolerances()) {
        let tile = tile(size.0, size.1, seed, kind);
        let rim = rim(&tile, tolerance);
        let shape = data_dependent(Fit::L2, Shape::SmallestAngle, 1.0);
        for engine in [GreedyInsertion::default(), shape] {
            let mesh = triangulate(&engine, &tile, &rim.domain, tolerance, Feasibility::Weak);
            for &t in &mesh.triangles {
                let [a, b, c] = mesh.corners(t).map(|v| v.at);
                prop_assert!(mesh.vertices.iter().all(|v| !in_circle(a, b, c, v.at)));
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// A rim that was made for a larger tolerance stays; everything else is within the tolerance asked for.
    #[test]
    fn a_looser_rim_stays(
        size in (2usize..24, 2usize..24), seed in any::<u64>(), kind in 0u8..4, tolerance in tolerances(),
        strong in any::<bool>(),
    ) {
        let tile = tile(size.0, size.1, seed, kind);
        let domain = rim(&tile, 2.0 * tolerance).domain;
        let feasibility = if strong { Feasibility::Strong } else { Feasibility::Weak };
        // Samples on the rim are held to its own tolerance, those inside to the engine's.
        let on_rim = |i: usize| {
            let (column, row) = (i % size.0, i / size.0);
            row == 0 || row + 1 == size.1 || column == 0 || column + 1 == size.0
        };
        let weights = (0..size.0 * size.1).map(|i| if on_rim(i) { 1.0 } else { 2.0 }).collect();
        let held = tile.clone().with_weights(weights);
        for engine in [
            GreedyInsertion::default(),
            variant(Swap::Delaunay, Selection::Constant),
            measured(Measure::GlobalError),
            data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.5),
        ] {
            let mesh = triangulate(&engine, &tile, &domain, tolerance, feasibility);
            check(&held, &domain, &mesh, 2.0 * tolerance);
        }
    }
}
