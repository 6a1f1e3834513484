//! `simplify`: which engine, and its own options.

use clap::ValueEnum;

use super::{Failure, values};
use crate::job::EngineChoice;
use crate::kernel::triangulate::cuts::GreedyCuts;
use crate::kernel::triangulate::insertion::{
    DataDependent, Fit, GreedyInsertion, InsertionOptions, Measure, Selection, Shape, Swap,
};

#[derive(Debug, Clone, clap::Args)]
pub(super) struct EngineArgs {
    /// How tiles are triangulated [default: greedy-insertion; greedy-cuts with --quality none]
    #[arg(long, value_enum)]
    engine: Option<EngineArg>,
    /// The order of greedy cuts: the paper's own, or the largest first, which is slower and takes fewer triangles. Polishing
    /// comes to about the same from both [default: plain]
    #[arg(long, value_enum, help_heading = "Options of --engine greedy-cuts")]
    cuts: Option<CutsArg>,
    #[command(flatten)]
    insertion: InsertionArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineArg {
    /// Eats the ground from its rim inward, triangle by triangle
    GreedyCuts,
    /// Inserts the farthest sample, again and again
    GreedyInsertion,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CutsArg {
    /// Ears and bites in the order in which they appear
    Plain,
    /// The largest ears and bites first, bites searched along rays
    Improved,
}

#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Options of --engine greedy-insertion")]
struct InsertionArgs {
    /// By what edges are swapped: the circle test, or how well the surface fits the samples [default: delaunay]
    #[arg(long, value_enum)]
    swap: Option<SwapArg>,
    /// Data-dependent: shape decides where one is at most so large a share of the other; 0 never, 1 always [default: 0.5]
    #[arg(long, value_name = "Q", value_parser = values::share)]
    quality_threshold: Option<f64>,
    /// Data-dependent: what a good shape is [default: area-over-diameter]
    #[arg(long, value_enum)]
    shape: Option<ShapeArg>,
    /// Data-dependent: the error that a swap is to lower [default: max-sum]
    #[arg(long, value_enum)]
    fit: Option<FitArg>,
    /// How many candidates a pass inserts [default: sequential]
    #[arg(long, value_enum)]
    selection: Option<SelectionArg>,
    /// Fractional: all candidates with at least this share of the largest error [default: 0.9]
    #[arg(long, value_name = "A", value_parser = values::share)]
    fraction: Option<f64>,
    /// What makes a sample that is beyond the tolerance important [default: local-error]
    #[arg(long, value_enum)]
    measure: Option<MeasureArg>,
    /// Curvature and product: the standard deviation of the Gaussian the field is smoothed with, in cells [default: 1]
    #[arg(long, value_name = "CELLS", value_parser = values::smoothing)]
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

impl EngineArgs {
    /// The engine that is asked for; where none is, the one that an option is for, else `insertion` says which.
    ///
    /// # Errors
    /// Usage: options of an engine, or of a variant, that is not the one asked for.
    pub(super) fn choice(&self, insertion: bool) -> Result<EngineChoice, Failure> {
        let wanted = match (self.cuts.is_some(), self.insertion.first_given().is_some() || insertion) {
            (true, _) | (false, false) => EngineArg::GreedyCuts,
            (false, true) => EngineArg::GreedyInsertion,
        };
        match self.engine.unwrap_or(wanted) {
            EngineArg::GreedyInsertion if self.cuts.is_some() => Err(needs("--cuts", "--engine greedy-cuts")),
            EngineArg::GreedyInsertion => Ok(GreedyInsertion { options: self.insertion.options()? }.into()),
            EngineArg::GreedyCuts => match self.insertion.first_given() {
                None => Ok(EngineChoice::from(match self.cuts {
                    Some(CutsArg::Plain) => GreedyCuts::PLAIN,
                    Some(CutsArg::Improved) => GreedyCuts::IMPROVED,
                    // Polishing ends at the same counts, and sooner from here.
                    None => GreedyCuts::PLAIN,
                })),
                Some(option) => Err(needs(option, "--engine greedy-insertion")),
            },
        }
    }
}

fn needs(option: &str, other: &str) -> Failure {
    Failure::usage(format!("{option} requires {other}"))
}

impl InsertionArgs {
    fn first_given(&self) -> Option<&'static str> {
        let given = [
            ("--swap", self.swap.is_some()),
            ("--quality-threshold", self.quality_threshold.is_some()),
            ("--shape", self.shape.is_some()),
            ("--fit", self.fit.is_some()),
            ("--selection", self.selection.is_some()),
            ("--fraction", self.fraction.is_some()),
            ("--measure", self.measure.is_some()),
            ("--smoothing", self.smoothing.is_some()),
        ];
        given.iter().find(|(_, given)| *given).map(|&(name, _)| name)
    }

    fn options(&self) -> Result<InsertionOptions, Failure> {
        let swap = match self.swap {
            Some(SwapArg::DataDependent) => Swap::DataDependent(self.data_dependent()),
            Some(SwapArg::Delaunay) | None => {
                let given = [self.quality_threshold.is_some(), self.shape.is_some(), self.fit.is_some()];
                let names = ["--quality-threshold", "--shape", "--fit"];
                if let Some((_, name)) = given.iter().zip(names).find(|(given, _)| **given) {
                    return Err(needs(name, "--swap data-dependent"));
                }
                Swap::Delaunay
            }
        };
        let selection = match self.selection {
            Some(SelectionArg::Fractional) => Selection::Fractional(self.fraction.unwrap_or(FRACTION)),
            _ if self.fraction.is_some() => return Err(needs("--fraction", "--selection fractional")),
            Some(SelectionArg::Constant) => Selection::Constant,
            Some(SelectionArg::Sequential) | None => Selection::Sequential,
        };
        let smoothing = self.smoothing.unwrap_or(SMOOTHING);
        let measure = match self.measure {
            Some(MeasureArg::Curvature) => Measure::Curvature(smoothing),
            Some(MeasureArg::Product) => Measure::Product(smoothing),
            _ if self.smoothing.is_some() => {
                return Err(needs("--smoothing", "--measure curvature or --measure product"));
            }
            Some(MeasureArg::GlobalError) => Measure::GlobalError,
            Some(MeasureArg::LocalError) | None => Measure::LocalError,
        };
        Ok(InsertionOptions { swap, selection, measure })
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
