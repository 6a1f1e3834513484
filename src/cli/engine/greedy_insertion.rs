//! The options of greedy insertion.

use clap::ValueEnum;

use crate::base::features::Feature;
use crate::cli::combinations::Asked;
use crate::cli::values;
use crate::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Selection, Shape, Swap,
};

/// What is chosen of greedy insertion.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Options of --engine greedy-insertion")]
pub(super) struct InsertionArgs {
    /// By what edges are swapped: the circle test, or how well the surface fits the samples [default: delaunay]
    #[arg(long, hide_short_help = true, value_enum)]
    swap: Option<SwapArg>,
    /// Data-dependent: shape decides where one is at most so large a share of the other; 0 never, 1 always [default: 0.5]
    #[arg(long, hide_short_help = true, value_name = "Q", value_parser = values::share)]
    quality_threshold: Option<f64>,
    /// Data-dependent: what a good shape is [default: area-over-diameter]
    #[arg(long, hide_short_help = true, value_enum)]
    shape: Option<ShapeArg>,
    /// Data-dependent: the error that a swap is to lower [default: max-sum]
    #[arg(long, hide_short_help = true, value_enum)]
    fit: Option<FitArg>,
    /// How many candidates a pass inserts [default: sequential]
    #[arg(long, hide_short_help = true, value_enum)]
    selection: Option<SelectionArg>,
    /// Fractional: all candidates with at least this share of the largest error [default: 0.9]
    #[arg(long, hide_short_help = true, value_name = "A", value_parser = values::share)]
    fraction: Option<f64>,
    /// What makes a sample that is beyond the tolerance important [default: local-error]
    #[arg(long, hide_short_help = true, value_enum)]
    measure: Option<MeasureArg>,
    /// Curvature and product: the standard deviation of the Gaussian the field is smoothed with, in cells [default: 1]
    #[arg(long, hide_short_help = true, value_name = "CELLS", value_parser = values::smoothing)]
    smoothing: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SwapArg {
    /// Delaunay triangulation
    Delaunay,
    /// Data-dependent triangulation, kept from slivers by shape
    DataDependent,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ShapeArg {
    /// Product of the areas over product of the diameters
    AreaOverDiameter,
    /// The smallest angle
    SmallestAngle,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FitArg {
    /// The largest error of each triangle, added
    MaxSum,
    /// The sum of squared errors
    L2,
    /// The largest error
    LInfinity,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SelectionArg {
    /// The best one
    Sequential,
    /// All near the best one
    Fractional,
    /// All beyond the tolerance
    Constant,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum MeasureArg {
    /// Its error
    LocalError,
    /// The curvature of the smoothed field
    Curvature,
    /// How much it lowers the errors around it
    GlobalError,
    /// Error times curvature
    Product,
}

const SMOOTHING: f64 = 1.0;
const FRACTION: f64 = 0.9;

impl InsertionArgs {
    pub(super) fn ask(&self, asked: &mut Asked) {
        match self.swap {
            Some(SwapArg::Delaunay) => asked.add(Feature::DelaunaySwap, true),
            Some(SwapArg::DataDependent) => asked.add(Feature::DataDependentSwap, true),
            None => {}
        }
        asked.add(Feature::QualityThreshold, self.quality_threshold.is_some());
        asked.add(Feature::Shape, self.shape.is_some());
        asked.add(Feature::Fit, self.fit.is_some());
        match self.selection {
            Some(SelectionArg::Sequential) => asked.add(Feature::SequentialSelection, true),
            Some(SelectionArg::Fractional) => asked.add(Feature::FractionalSelection, true),
            Some(SelectionArg::Constant) => asked.add(Feature::ConstantSelection, true),
            None => {}
        }
        asked.add(Feature::Fraction, self.fraction.is_some());
        match self.measure {
            Some(MeasureArg::LocalError) => asked.add(Feature::LocalErrorMeasure, true),
            Some(MeasureArg::GlobalError) => asked.add(Feature::GlobalErrorMeasure, true),
            Some(MeasureArg::Curvature) => asked.add_by(Feature::SmoothedMeasure, "--measure curvature"),
            Some(MeasureArg::Product) => asked.add_by(Feature::SmoothedMeasure, "--measure product"),
            None => {}
        }
        asked.add(Feature::Smoothing, self.smoothing.is_some());
    }

    /// The engine with these options.
    pub(super) fn engine(&self) -> GreedyInsertion {
        GreedyInsertion { options: self.options() }
    }

    fn options(&self) -> InsertionOptions {
        let swap = match self.swap {
            Some(SwapArg::DataDependent) => Swap::DataDependent(self.data_dependent()),
            Some(SwapArg::Delaunay) | None => Swap::Delaunay,
        };
        let selection = match self.selection {
            Some(SelectionArg::Fractional) => Selection::Fractional(self.fraction.unwrap_or(FRACTION)),
            Some(SelectionArg::Constant) => Selection::Constant,
            Some(SelectionArg::Sequential) | None => Selection::Sequential,
        };
        let smoothing = self.smoothing.unwrap_or(SMOOTHING);
        let measure = match self.measure {
            Some(MeasureArg::Curvature) => Measure::Curvature(smoothing),
            Some(MeasureArg::Product) => Measure::Product(smoothing),
            Some(MeasureArg::GlobalError) => Measure::GlobalError,
            Some(MeasureArg::LocalError) | None => Measure::LocalError,
        };
        InsertionOptions { swap, selection, measure }
    }

    fn data_dependent(&self) -> DataDependent {
        let default = DataDependent::default();
        DataDependent {
            fit: match self.fit {
                Some(FitArg::MaxSum) => Fit::MaxSum,
                Some(FitArg::L2) => Fit::L2,
                Some(FitArg::LInfinity) => Fit::LInfinity,
                None => default.fit,
            },
            shape: match self.shape {
                Some(ShapeArg::AreaOverDiameter) => Shape::AreaOverDiameter,
                Some(ShapeArg::SmallestAngle) => Shape::SmallestAngle,
                None => default.shape,
            },
            quality_threshold: self.quality_threshold.unwrap_or(default.quality_threshold),
        }
    }
}
