//! `simplify`: which engine, and its own options, a file for each.

mod greedy_cuts;
mod greedy_insertion;
mod hitting_set;

use clap::ValueEnum;

use self::greedy_cuts::CutsArgs;
use self::greedy_insertion::InsertionArgs;
use self::hitting_set::HittingSetArgs;
use super::combinations::Asked;
use crate::job::EngineChoice;

#[derive(Debug, Clone, clap::Args)]
pub(super) struct EngineArgs {
    /// How tiles are triangulated [default: greedy-insertion; greedy-cuts with --quality none]
    #[arg(long, hide_short_help = true, value_enum)]
    engine: Option<EngineArg>,
    #[command(flatten)]
    cuts: CutsArgs,
    #[command(flatten)]
    insertion: InsertionArgs,
    #[command(flatten)]
    hitting_set: HittingSetArgs,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EngineArg {
    /// Eats the ground from its rim inward, triangle by triangle
    GreedyCuts,
    /// Inserts the farthest sample, again and again
    GreedyInsertion,
    /// Divides the samples into squares that a plane fits, and stitches these
    HittingSet,
}

impl EngineArgs {
    /// What of this asks for features, but for the engine itself.
    pub(super) fn ask(&self, asked: &mut Asked) {
        self.cuts.ask(asked);
        self.insertion.ask(asked);
        self.hitting_set.ask(asked);
    }

    /// The engine with what its options say: the one that is asked for, or else `usual`.
    pub(super) fn choice(&self, usual: impl FnOnce() -> EngineChoice) -> EngineChoice {
        let engine = self.engine.unwrap_or_else(|| match usual() {
            EngineChoice::GreedyCuts(_) => EngineArg::GreedyCuts,
            EngineChoice::GreedyInsertion(_) => EngineArg::GreedyInsertion,
            EngineChoice::HittingSet(_) => EngineArg::HittingSet,
        });
        match engine {
            EngineArg::GreedyCuts => self.cuts.engine().into(),
            EngineArg::GreedyInsertion => self.insertion.engine().into(),
            EngineArg::HittingSet => self.hitting_set.engine().into(),
        }
    }
}
