//! The options of greedy cuts.

use clap::ValueEnum;

use crate::base::features::Feature;
use crate::cli::combinations::Asked;
use crate::kernel::triangulate::cuts::GreedyCuts;

/// What is chosen of greedy cuts.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct CutsArgs {
    /// The order of greedy cuts: the paper's own, or the largest first, which is slower and takes fewer triangles. Polishing
    /// comes to about the same from both [default: plain]
    #[arg(long, hide_short_help = true, value_enum, help_heading = "Options of --engine greedy-cuts")]
    cuts: Option<CutsArg>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum CutsArg {
    /// Ears and bites in the order in which they appear
    Plain,
    /// The largest ears and bites first, bites searched along rays
    Improved,
}

impl CutsArgs {
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::CutOrder, self.cuts.is_some());
    }

    /// The engine with these options.
    pub(super) fn engine(&self) -> GreedyCuts {
        match self.cuts {
            Some(CutsArg::Improved) => GreedyCuts::IMPROVED,
            // Polishing ends at the same counts, and sooner from here.
            Some(CutsArg::Plain) | None => GreedyCuts::PLAIN,
        }
    }
}
