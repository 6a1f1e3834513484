//! What is done when, for every effort. The figures are from measurements, see docs/quality.md.

use serde::Serialize;

use super::improve::Search;
use super::judge::Judge;
use super::net::Net;
use super::order::Order;
use super::repair::{Patience, Repair};
use super::{Effort, Heights, Scratch};
use crate::base::control::Cancelled;

/// What polishing does, step by step: removal; then vertices move to where their triangles fit better; then passes of
/// remove-and-repair, with such moves between them; removal again. Every number has its share in time and triangles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Schedule {
    /// Sweeps of removal in the beginning, at most; [`Schedule::ALL`] goes on until nothing goes. A sweep takes a third
    /// of the one before, as few vertices are due.
    pub sweeps: u32,
    /// Rounds of moves after that.
    pub moves: u32,
    /// Sweeps of removal in the end.
    pub last_sweeps: u32,
    /// Passes of remove-and-repair, at most.
    pub passes: u32,
    /// By how much the energy may rise when a vertex goes, in each of the first passes; the last one is the rest's.
    pub caps: Caps,
    /// Whether passes try all vertices; else only those at which something has changed.
    pub retry: bool,
    /// Where there are more passes than caps they end when fewer than one vertex in this number is removed; 0 for never.
    pub yield_of: u32,
    /// Rounds of moving and turning after a vertex has gone, at most. 72 % of the successes need two.
    pub rounds: u32,
    /// To what share a round must bring down the energy of violating triangles for another one to follow.
    pub shrink: f32,
    /// What energy violating triangles may have for the last round to follow, and five times as much for every round before
    /// that; where heights are fitted two and a half times as much, and any before the first round. Infinite for any.
    pub reach: f32,
    /// Steps of a vertex that moves in a round of repair.
    pub steps: u32,
    /// Whether the first step of a vertex is half as long from one round of repair to the next.
    pub finer: bool,
    /// Whether vertices move, too, around which earlier moves of the same round have left no violation; where heights are
    /// fitted, whether shorter steps are tried where one leads nowhere.
    pub thorough: bool,
    /// Steps of a vertex that moves between passes.
    pub steps_between: u32,
    /// Places that are looked at around a vertex on samples: four or eight.
    pub places: u32,
    /// In how many rows, about, places around a vertex on samples are compared, if its triangles have twice as many or more;
    /// then the best one is measured in full. [`Schedule::ALL`] compares in all.
    pub rows: u32,
    /// Whether edges turn between passes, too.
    pub turns: bool,
    /// Removal fills holes with up to this number of vertices by dynamic programming; from longer rings it cuts off ears.
    pub longest_ring: u32,
    /// Remove-and-repair leaves vertices with longer rings alone.
    pub longest_repaired: u32,
}

/// One to eight caps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Caps {
    values: [f32; Caps::MOST],
    len: usize,
}

impl Caps {
    /// How many there can be.
    pub const MOST: usize = 8;

    /// These, if there are as many and all are finite and not negative.
    pub const fn new(caps: &[f32]) -> Option<Caps> {
        let (mut values, mut i) = ([0.0; Caps::MOST], 0);
        if caps.is_empty() || caps.len() > Caps::MOST {
            return None;
        }
        while i < caps.len() {
            if !(caps[i] >= 0.0 && caps[i] < f32::INFINITY) {
                return None;
            }
            values[i] = caps[i];
            i += 1;
        }
        Some(Caps { values, len: caps.len() })
    }

    /// The caps.
    pub fn values(&self) -> &[f32] {
        &self.values[..self.len]
    }

    const fn preset(caps: &[f32]) -> Caps {
        match Caps::new(caps) {
            Some(caps) => caps,
            None => panic!("caps of a preset"),
        }
    }
}

/// A number of a [`Schedule`] that it cannot have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{field}: expected {expected}")]
pub struct ScheduleError {
    /// The field's name.
    pub field: &'static str,
    /// What it can be.
    pub expected: &'static str,
}

impl Schedule {
    /// Sweeps until nothing goes; all rows.
    pub const ALL: u32 = u32::MAX;

    /// Removal alone: vertices go whose hole triangles within the tolerance fill.
    pub const REMOVAL: Schedule = Schedule { passes: 0, ..Schedule::BALANCED };

    const FAST: Schedule = Schedule {
        sweeps: 1,
        moves: 1,
        last_sweeps: 1,
        passes: 0,
        places: 4,
        rows: Schedule::ALL,
        // They are worth a third of a per cent, for a sixth of the time.
        turns: false,
        ..Schedule::BALANCED
    };

    const BALANCED: Schedule = Schedule {
        sweeps: Schedule::ALL,
        moves: 0,
        last_sweeps: 0,
        passes: 2,
        caps: Caps::preset(&[2.0]),
        retry: false,
        yield_of: 0,
        rounds: 3,
        shrink: 0.8,
        // 25 times this, which is what the first of three rounds allows, is the cap.
        reach: 0.08,
        steps: 1,
        finer: true,
        thorough: false,
        steps_between: 1,
        places: 8,
        rows: 24,
        turns: true,
        longest_ring: 24,
        longest_repaired: 14,
    };

    /// Nothing is left out for the sake of time.
    const THOROUGH: Schedule = Schedule {
        passes: 3,
        reach: f32::INFINITY,
        finer: false,
        thorough: true,
        rows: Schedule::ALL,
        ..Schedule::BALANCED
    };

    /// With fitted heights a move is a step towards a minimum: one at a time, and more rounds.
    const BALANCED_FITTED: Schedule = Schedule {
        passes: 2,
        caps: Caps::preset(&[2.0, 2.2]),
        rounds: 6,
        shrink: 0.85,
        // 39 times this after the first of six rounds: 0.31.
        reach: 0.008,
        thorough: false,
        ..Schedule::THOROUGH
    };

    /// Other than with balanced effort, vertices that have been tried with a lower cap are tried again.
    const BEST: Schedule = Schedule {
        passes: 10,
        caps: Caps::preset(&[0.3, 1.0, 3.0, 6.0, 10.0]),
        retry: true,
        yield_of: 500,
        rounds: 8,
        shrink: 0.9,
        steps: 3,
        steps_between: 3,
        ..Schedule::THOROUGH
    };

    const BEST_FITTED: Schedule = Schedule {
        caps: Caps::preset(&[1.0, 2.0, 5.0, 10.0]),
        yield_of: 1000,
        rounds: 12,
        shrink: 0.85,
        steps: 2,
        steps_between: 2,
        ..Schedule::BEST
    };

    /// What an effort does.
    pub const fn preset(effort: Effort, heights: Heights) -> Schedule {
        match (effort, heights) {
            (Effort::Fast, _) => Schedule::FAST,
            (Effort::Balanced, Heights::Sampled) => Schedule::BALANCED,
            (Effort::Balanced, Heights::Fitted) => Schedule::BALANCED_FITTED,
            (Effort::Best, Heights::Sampled) => Schedule::BEST,
            (Effort::Best, Heights::Fitted) => Schedule::BEST_FITTED,
        }
    }

    /// Whether polishing can work with these numbers.
    ///
    /// # Errors
    /// The first one that is out of its range.
    pub fn check(&self) -> Result<(), ScheduleError> {
        let checks = [
            ("passes", self.passes <= 1000, "at most 1000"),
            ("moves", self.moves <= 1000, "at most 1000"),
            ("rounds", (1..=1000).contains(&self.rounds), "1 to 1000"),
            ("shrink", self.shrink > 0.0 && self.shrink <= 1.0, "a share above 0, at most 1"),
            ("reach", self.reach > 0.0, "above 0"),
            ("steps", (1..=100).contains(&self.steps), "1 to 100"),
            ("steps_between", (1..=100).contains(&self.steps_between), "1 to 100"),
            ("places", self.places == 4 || self.places == 8, "4 or 8"),
            ("rows", self.rows >= 8, "8 or more"),
            ("longest_ring", (3..=128).contains(&self.longest_ring), "3 to 128"),
            ("longest_repaired", (3..=64).contains(&self.longest_repaired), "3 to 64"),
        ];
        match checks.iter().find(|(_, within, _)| !within) {
            Some(&(field, _, expected)) => Err(ScheduleError { field, expected }),
            None => Ok(()),
        }
    }

    /// All of it as text, equal exactly if the numbers are.
    pub fn named(&self) -> String {
        let Schedule { sweeps, moves, last_sweeps, passes, caps, retry, yield_of, rounds, shrink, reach, .. } = *self;
        let Schedule {
            steps, finer, thorough, steps_between, places, rows, turns, longest_ring, longest_repaired, ..
        } = *self;
        format!(
            "sweeps {sweeps}, moves {moves}, last sweeps {last_sweeps}, passes {passes}, caps {:?}, retry {retry}, \
             yield {yield_of}, rounds {rounds}, shrink {shrink}, reach {reach}, steps {steps}, finer {finer}, \
             thorough {thorough}, steps between {steps_between}, places {places}, rows {rows}, turns {turns}, \
             longest ring {longest_ring}, longest repaired {longest_repaired}",
            caps.values()
        )
    }

    fn patience(&self, pass: usize, fitted: bool) -> Patience {
        let caps = self.caps.values();
        Patience {
            cap: caps[pass.min(caps.len() - 1)],
            rounds: self.rounds as usize,
            shrink: self.shrink,
            last_reach: self.reach,
            search: self.search(self.steps),
            finer: self.finer,
            fitted,
            longest_ring: self.longest_repaired as usize,
        }
    }

    fn search_between(&self) -> Search {
        self.search(self.steps_between)
    }

    fn search(&self, rounds: u32) -> Search {
        Search { rounds, places: self.places as usize, halvings: 0, rows: self.rows, thorough: self.thorough }
    }
}

/// How far from a seam vertices are visited again, in edges: 1, 2, 3 leave 0.13, 0.01, −0.11 % more triangles than one tile.
const RINGS: usize = 2;

/// Which vertices are visited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Visit<'a> {
    /// All.
    All,
    /// Those around these.
    Near(&'a [u32]),
}

impl Visit<'_> {
    fn make_due(self, net: &Net, order: &mut Order) {
        match self {
            Visit::All => order.make_all_due(),
            Visit::Near(centres) => order.make_only_near_due(net, centres, RINGS),
        }
    }
}

impl Scratch {
    /// Does what a schedule says, on a net that has been loaded.
    pub(super) fn work(
        &mut self,
        schedule: &Schedule,
        visit: Visit<'_>,
        judge: &mut Judge<'_>,
    ) -> Result<(), Cancelled> {
        visit.make_due(&self.net, &mut self.order);
        let Scratch { net, order, removal, repair, onto_rim } = self;
        let longest = schedule.longest_ring as usize;
        if !judge.meter.is_of_use() {
            // At tolerance 0 there is nothing to lean on: either a triangle fits or it does not.
            removal.sweeps(Schedule::ALL, longest, net, order, judge)?;
            return Ok(());
        }
        removal.sweeps(schedule.sweeps, longest, net, order, judge)?;
        if schedule.moves > 0 || schedule.passes > 0 {
            Repair::measure(net, judge);
        }
        for _ in 0..schedule.moves {
            repair.relax(net, order, judge, schedule.search_between(), schedule.turns)?;
        }
        if schedule.passes > 0 {
            visit.make_due(net, order);
        }
        for pass in 0..schedule.passes as usize {
            if pass > 0 {
                repair.relax(net, order, judge, schedule.search_between(), schedule.turns)?;
            }
            if schedule.retry {
                visit.make_due(net, order);
            }
            if visit != Visit::All {
                onto_rim.sweep(net, order, judge)?;
            }
            let gone = repair.sweep(net, order, judge, schedule.patience(pass, judge.fitting.is_some()))?;
            let yields_little = gone * (schedule.yield_of as usize) < order.raster.len();
            if schedule.yield_of > 0 && yields_little && pass >= schedule.caps.values().len() {
                break;
            }
        }
        if schedule.passes > 0 && schedule.last_sweeps > 0 {
            repair.relax(net, order, judge, schedule.search_between(), schedule.turns)?;
        }
        removal.sweeps(schedule.last_sweeps, longest, net, order, judge)?;
        Ok(())
    }
}
