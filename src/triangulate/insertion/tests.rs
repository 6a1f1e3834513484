use super::*;
use crate::triangulate::conformance::conformance;

fn variant(swap: Swap, selection: Selection) -> GreedyInsertion {
    GreedyInsertion { options: InsertionOptions { swap, selection, ..InsertionOptions::default() } }
}

fn data_dependent(fit: Fit, shape: Shape, quality_threshold: f64) -> GreedyInsertion {
    variant(Swap::DataDependent(DataDependent { fit, shape, quality_threshold }), Selection::Sequential)
}

conformance!(delaunay, GreedyInsertion::default());
conformance!(fractional, variant(Swap::Delaunay, Selection::Fractional(0.5)));
conformance!(constant, variant(Swap::Delaunay, Selection::Constant));
conformance!(data_dependent_max_sum, data_dependent(Fit::MaxSum, Shape::AreaOverDiameter, 0.5));
conformance!(data_dependent_l2, data_dependent(Fit::L2, Shape::SmallestAngle, 0.0));
conformance!(data_dependent_l_infinity, data_dependent(Fit::LInfinity, Shape::SmallestAngle, 1.0));
