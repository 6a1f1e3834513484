//! What polishing does, number by number: `terrabite.Polishing`.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use terrabite::base::features::Feature;
use terrabite::job::{Quality, VertexHeights};
use terrabite::kernel::polish::{Caps, Schedule, Tuning};

use crate::options::chosen;

/// A number, or the word `all`.
#[derive(FromPyObject)]
enum Count {
    Number(u32),
    Word(String),
}

/// The numbers that are given.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Polishing {
    polish_edges: Option<String>,
    polish_sweeps: Option<Count>,
    polish_moves: Option<u32>,
    polish_last_sweeps: Option<Count>,
    polish_passes: Option<u32>,
    polish_caps: Option<Vec<f32>>,
    polish_retry: Option<bool>,
    polish_yield: Option<u32>,
    polish_rounds: Option<u32>,
    polish_shrink: Option<f32>,
    polish_reach: Option<f32>,
    polish_steps: Option<u32>,
    polish_finer: Option<bool>,
    polish_thorough: Option<bool>,
    polish_steps_between: Option<u32>,
    polish_places: Option<u32>,
    polish_rows: Option<Count>,
    polish_turns: Option<bool>,
    polish_longest_ring: Option<u32>,
    polish_longest_repaired: Option<u32>,
}

impl Polishing {
    /// What of this asks for features, and whether.
    pub(crate) fn wanted(&self) -> [(Feature, bool); 3] {
        let edges = |word: &str| self.polish_edges.as_deref() == Some(word);
        [
            (Feature::WeakPolishEdges, edges("weak")),
            (Feature::StrongPolishEdges, edges("strong")),
            (Feature::PolishingNumbers, self.has_numbers()),
        ]
    }

    fn has_numbers(&self) -> bool {
        let counts = [&self.polish_sweeps, &self.polish_last_sweeps, &self.polish_rows];
        let whole = [
            self.polish_moves,
            self.polish_passes,
            self.polish_yield,
            self.polish_rounds,
            self.polish_steps,
            self.polish_steps_between,
            self.polish_places,
            self.polish_longest_ring,
            self.polish_longest_repaired,
        ];
        let switches = [self.polish_retry, self.polish_finer, self.polish_thorough, self.polish_turns];
        counts.iter().any(|count| count.is_some())
            || whole.iter().any(Option::is_some)
            || switches.iter().any(Option::is_some)
            || [self.polish_shrink, self.polish_reach].iter().any(Option::is_some)
            || self.polish_caps.is_some()
    }

    /// What is asked for beside quality and heights.
    pub(crate) fn tuning(&self, quality: Quality, heights: VertexHeights, min_angle: Option<f64>) -> PyResult<Tuning> {
        let edges = chosen("polish_edges", self.polish_edges.as_ref(), &[("weak", false), ("strong", true)])?;
        Ok(Tuning { schedule: self.schedule(quality, heights)?, min_angle, strong_edges: edges.unwrap_or(false) })
    }

    /// The schedule, if it is not as usual.
    fn schedule(&self, quality: Quality, heights: VertexHeights) -> PyResult<Option<Schedule>> {
        let usual = Schedule::preset(quality.effort().unwrap_or_default(), heights);
        let schedule = Schedule {
            sweeps: count("polish_sweeps", self.polish_sweeps.as_ref())?.unwrap_or(usual.sweeps),
            moves: self.polish_moves.unwrap_or(usual.moves),
            last_sweeps: count("polish_last_sweeps", self.polish_last_sweeps.as_ref())?.unwrap_or(usual.last_sweeps),
            passes: self.polish_passes.unwrap_or(usual.passes),
            caps: self.caps()?.unwrap_or(usual.caps),
            retry: self.polish_retry.unwrap_or(usual.retry),
            yield_of: self.polish_yield.unwrap_or(usual.yield_of),
            rounds: self.polish_rounds.unwrap_or(usual.rounds),
            shrink: self.polish_shrink.unwrap_or(usual.shrink),
            reach: self.polish_reach.unwrap_or(usual.reach),
            steps: self.polish_steps.unwrap_or(usual.steps),
            finer: self.polish_finer.unwrap_or(usual.finer),
            thorough: self.polish_thorough.unwrap_or(usual.thorough),
            steps_between: self.polish_steps_between.unwrap_or(usual.steps_between),
            places: self.polish_places.unwrap_or(usual.places),
            rows: count("polish_rows", self.polish_rows.as_ref())?.unwrap_or(usual.rows),
            turns: self.polish_turns.unwrap_or(usual.turns),
            longest_ring: self.polish_longest_ring.unwrap_or(usual.longest_ring),
            longest_repaired: self.polish_longest_repaired.unwrap_or(usual.longest_repaired),
        };
        schedule.check().map_err(|error| PyValueError::new_err(format!("polish_{error}")))?;
        Ok((schedule != usual).then_some(schedule))
    }

    fn caps(&self) -> PyResult<Option<Caps>> {
        let usable = |caps: &Vec<f32>| {
            let message = format!("polish_caps: expected one to {} finite numbers, none below 0", Caps::MOST);
            Caps::new(caps).ok_or_else(|| PyValueError::new_err(message))
        };
        self.polish_caps.as_ref().map(usable).transpose()
    }
}

fn count(name: &str, count: Option<&Count>) -> PyResult<Option<u32>> {
    match count {
        None => Ok(None),
        Some(Count::Number(number)) => Ok(Some(*number)),
        Some(Count::Word(word)) => chosen(name, Some(word), &[("all", Schedule::ALL)]),
    }
}
