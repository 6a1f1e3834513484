//! The options of hitting sets.

use clap::ValueEnum;

use crate::base::features::Feature;
use crate::cli::combinations::Asked;
use crate::kernel::triangulate::hitting_set::{Corners, HittingSet, HittingSetOptions, Squares, Stitching};

/// What is chosen of hitting sets.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Options of --engine hitting-set")]
pub(super) struct HittingSetArgs {
    /// Which squares of samples are tried [default: nested]
    #[arg(long, hide_short_help = true, value_enum)]
    squares: Option<SquaresArg>,
    /// What heights vertices have where squares meet [default: samples]
    #[arg(long, hide_short_help = true, value_enum)]
    corners: Option<CornersArg>,
    /// How squares become a mesh [default: merged]
    #[arg(long, hide_short_help = true, value_enum)]
    stitching: Option<StitchingArg>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SquaresArg {
    /// The nodes of a quadtree
    Nested,
    /// Squares of any size at any place, chosen greedily: fewer of them, in many times the time
    Sliding,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CornersArg {
    /// Those of samples
    Samples,
    /// Half-way between the planes of the squares, then moved to where the samples around want them
    Free,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StitchingArg {
    /// One vertex where corners of squares meet
    Shared,
    /// The same, then vertices go whose hole triangles within the tolerance fill
    Merged,
}

impl HittingSetArgs {
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::Squares, self.squares.is_some());
        match self.corners {
            Some(CornersArg::Samples) => asked.add(Feature::SampledCorners, true),
            Some(CornersArg::Free) => asked.add(Feature::FreeCorners, true),
            None => {}
        }
        asked.add(Feature::Stitching, self.stitching.is_some());
    }

    /// The engine with these options.
    pub(super) fn engine(&self) -> HittingSet {
        let squares = match self.squares {
            Some(SquaresArg::Sliding) => Squares::Sliding,
            Some(SquaresArg::Nested) | None => Squares::Nested,
        };
        let corners = match self.corners {
            Some(CornersArg::Free) => Corners::Free,
            Some(CornersArg::Samples) | None => Corners::Samples,
        };
        let stitching = match self.stitching {
            Some(StitchingArg::Shared) => Stitching::Shared,
            Some(StitchingArg::Merged) | None => Stitching::Merged,
        };
        HittingSet { options: HittingSetOptions { squares, corners, stitching } }
    }
}
