//! `simplify`: what polishing does, number by number.

use clap::ValueEnum;

use super::combinations::Asked;
use super::values;
use crate::base::features::Feature;
use crate::job::{Quality, VertexHeights};
use crate::kernel::polish::{Caps, Schedule, Tuning};

#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Polishing, for experts: each is as --quality says unless given")]
pub(super) struct PolishArgs {
    /// Edges that polishing makes: tested at samples alone (weak), or as --feasibility strong does (strong) [default: as
    /// --feasibility says]
    #[arg(long, hide_short_help = true, value_enum, value_name = "TEST")]
    polish_edges: Option<EdgesArg>,
    /// Sweeps of removal in the beginning, or all: until nothing goes
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = values::sweeps)]
    polish_sweeps: Option<u32>,
    /// Rounds of moves after those
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    polish_moves: Option<u32>,
    /// Sweeps of removal in the end, or all
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = values::sweeps)]
    polish_last_sweeps: Option<u32>,
    /// Passes of remove-and-repair, at most
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=1000))]
    polish_passes: Option<u32>,
    /// By how much the energy may rise when a vertex goes: for the first passes, the last is the rest's
    #[arg(long, hide_short_help = true, value_name = "CAP,…", value_parser = values::caps)]
    polish_caps: Option<Caps>,
    /// Whether every pass tries all vertices, or only those at which something has changed
    #[arg(long, hide_short_help = true, value_name = "BOOL")]
    polish_retry: Option<bool>,
    /// Passes beyond the caps end when fewer than one vertex in N is removed; 0 means never
    #[arg(long, hide_short_help = true, value_name = "N")]
    polish_yield: Option<u32>,
    /// Rounds of repair after a vertex has gone, at most
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    polish_rounds: Option<u32>,
    /// To what share a round must bring down the energy of violating triangles for another to follow
    #[arg(long, hide_short_help = true, value_name = "SHARE", value_parser = values::shrink)]
    polish_shrink: Option<f32>,
    /// What energy violating triangles may have for the last round of repair to follow, and five times as much for each
    /// round before it (fitted heights: 2.5 times, and any for the first), or any
    #[arg(long, hide_short_help = true, value_name = "ENERGY", value_parser = values::reach)]
    polish_reach: Option<f32>,
    /// Steps of a vertex that moves in a round of repair
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    polish_steps: Option<u32>,
    /// Whether the first of these is half as long from one round to the next
    #[arg(long, hide_short_help = true, value_name = "BOOL")]
    polish_finer: Option<bool>,
    /// Whether a round also moves vertices around which it has left no violation; fitted heights: whether shorter steps are
    /// tried, too
    #[arg(long, hide_short_help = true, value_name = "BOOL")]
    polish_thorough: Option<bool>,
    /// Steps of a vertex that moves between passes
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    polish_steps_between: Option<u32>,
    /// Places looked at around a vertex that stands on a sample
    #[arg(long, hide_short_help = true, value_enum, value_name = "N")]
    polish_places: Option<PlacesArg>,
    /// In how many rows, about, these are compared first where triangles are large, or all
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = values::rows)]
    polish_rows: Option<u32>,
    /// Whether edges turn between passes, too
    #[arg(long, hide_short_help = true, value_name = "BOOL")]
    polish_turns: Option<bool>,
    /// Removal fills holes with up to N corners by dynamic programming, longer ones ear by ear
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=128))]
    polish_longest_ring: Option<u32>,
    /// Remove-and-repair leaves vertices with more neighbours alone
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u32).range(3..=64))]
    polish_longest_repaired: Option<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum EdgesArg {
    Weak,
    Strong,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PlacesArg {
    #[value(name = "4")]
    Four,
    #[value(name = "8")]
    Eight,
}

impl PolishArgs {
    /// What of this asks for features.
    pub(super) fn ask(&self, asked: &mut Asked) {
        asked.add(Feature::WeakPolishEdges, self.polish_edges == Some(EdgesArg::Weak));
        asked.add(Feature::StrongPolishEdges, self.polish_edges == Some(EdgesArg::Strong));
        self.given().for_each(|option| asked.add_by(Feature::PolishingNumbers, option));
    }

    /// What is asked for beside quality and heights.
    pub(super) fn tuning(&self, quality: Quality, heights: VertexHeights, min_angle: Option<f64>) -> Tuning {
        let strong_edges = self.polish_edges == Some(EdgesArg::Strong);
        Tuning { schedule: self.schedule(quality, heights), min_angle, strong_edges }
    }

    /// The schedule, if it is not as usual.
    fn schedule(&self, quality: Quality, heights: VertexHeights) -> Option<Schedule> {
        let usual = Schedule::preset(quality.effort().unwrap_or_default(), heights);
        let schedule = Schedule {
            sweeps: self.polish_sweeps.unwrap_or(usual.sweeps),
            moves: self.polish_moves.unwrap_or(usual.moves),
            last_sweeps: self.polish_last_sweeps.unwrap_or(usual.last_sweeps),
            passes: self.polish_passes.unwrap_or(usual.passes),
            caps: self.polish_caps.unwrap_or(usual.caps),
            retry: self.polish_retry.unwrap_or(usual.retry),
            yield_of: self.polish_yield.unwrap_or(usual.yield_of),
            rounds: self.polish_rounds.unwrap_or(usual.rounds),
            shrink: self.polish_shrink.unwrap_or(usual.shrink),
            reach: self.polish_reach.unwrap_or(usual.reach),
            steps: self.polish_steps.unwrap_or(usual.steps),
            finer: self.polish_finer.unwrap_or(usual.finer),
            thorough: self.polish_thorough.unwrap_or(usual.thorough),
            steps_between: self.polish_steps_between.unwrap_or(usual.steps_between),
            places: match self.polish_places {
                None => usual.places,
                Some(PlacesArg::Four) => 4,
                Some(PlacesArg::Eight) => 8,
            },
            rows: self.polish_rows.unwrap_or(usual.rows),
            turns: self.polish_turns.unwrap_or(usual.turns),
            longest_ring: self.polish_longest_ring.unwrap_or(usual.longest_ring),
            longest_repaired: self.polish_longest_repaired.unwrap_or(usual.longest_repaired),
        };
        (schedule != usual).then_some(schedule)
    }

    /// The options whose numbers are given.
    fn given(&self) -> impl Iterator<Item = &'static str> {
        let all = [
            ("--polish-sweeps", self.polish_sweeps.is_some()),
            ("--polish-moves", self.polish_moves.is_some()),
            ("--polish-last-sweeps", self.polish_last_sweeps.is_some()),
            ("--polish-passes", self.polish_passes.is_some()),
            ("--polish-caps", self.polish_caps.is_some()),
            ("--polish-retry", self.polish_retry.is_some()),
            ("--polish-yield", self.polish_yield.is_some()),
            ("--polish-rounds", self.polish_rounds.is_some()),
            ("--polish-shrink", self.polish_shrink.is_some()),
            ("--polish-reach", self.polish_reach.is_some()),
            ("--polish-steps", self.polish_steps.is_some()),
            ("--polish-finer", self.polish_finer.is_some()),
            ("--polish-thorough", self.polish_thorough.is_some()),
            ("--polish-steps-between", self.polish_steps_between.is_some()),
            ("--polish-places", self.polish_places.is_some()),
            ("--polish-rows", self.polish_rows.is_some()),
            ("--polish-turns", self.polish_turns.is_some()),
            ("--polish-longest-ring", self.polish_longest_ring.is_some()),
            ("--polish-longest-repaired", self.polish_longest_repaired.is_some()),
        ];
        all.into_iter().filter(|(_, is_given)| *is_given).map(|(option, _)| option)
    }
}
