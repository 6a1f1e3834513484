//! What is done when, for every effort. The figures are from measurements, see docs/quality.md.

use super::judge::Judge;
use super::net::Net;
use super::order::Order;
use super::repair::{Patience, Repair};
use super::{Effort, Scratch};
use crate::control::Cancelled;

/// Sweeps of removal before and after vertices move: a sweep costs a third of the one before, as few vertices are due.
const FAST_SWEEPS: usize = 2;

/// The caps of the passes of remove-and-repair, and how far each attempt goes. 72 % of the successes need at most two
/// rounds.
const BALANCED_CAPS: [f32; 3] = [1.0, 1.0, 1.0];
const BALANCED: Patience = Patience { cap: 0.0, rounds: 3, shrink: 0.8, steps: 2 };
/// With fitted heights a move is a step towards a minimum: one at a time, and more rounds.
const FITTED_CAPS: [f32; 3] = [1.0, 2.0, 2.0];
const FITTED: Patience = Patience { cap: 0.0, rounds: 12, shrink: 0.85, steps: 1 };

/// The caps of the first passes, cheap removals first; the last one is the rest's. Other than with balanced effort,
/// vertices that have been tried with a lower cap are tried again.
const BEST_CAPS: [f32; 5] = [0.3, 1.0, 3.0, 6.0, 10.0];
const BEST_PASSES: usize = 10;
const BEST: Patience = Patience { cap: 0.0, rounds: 8, shrink: 0.9, steps: 3 };
const BEST_FITTED_CAPS: [f32; 4] = [1.0, 2.0, 5.0, 10.0];
const BEST_FITTED: Patience = Patience { cap: 0.0, rounds: 12, shrink: 0.85, steps: 2 };
/// The last passes end when fewer than one in so many vertices go.
const BEST_YIELD: usize = 500;
const BEST_FITTED_YIELD: usize = 1000;

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
    /// Does what an effort asks for, on a net that has been loaded.
    pub(super) fn work(&mut self, effort: Effort, visit: Visit<'_>, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        visit.make_due(&self.net, &mut self.order);
        if !judge.meter.is_of_use() {
            // At tolerance 0 there is nothing to lean on: either a triangle fits or it does not.
            self.removal.sweeps(usize::MAX, &mut self.net, &mut self.order, judge)?;
            return Ok(());
        }
        match effort {
            Effort::Fast => self.fast(judge),
            Effort::Balanced => self.balanced(visit, judge),
            Effort::Best => self.best(visit, judge),
        }
    }

    /// Removal; then vertices move to where their triangles fit better, which lets others go.
    fn fast(&mut self, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        let Scratch { net, order, removal, repair } = self;
        removal.sweeps(FAST_SWEEPS, net, order, judge)?;
        Repair::measure(net, judge);
        repair.relax(net, order, judge, 1)?;
        removal.sweeps(FAST_SWEEPS, net, order, judge)?;
        Ok(())
    }

    fn balanced(&mut self, visit: Visit<'_>, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        let Scratch { net, order, removal, repair } = self;
        removal.sweeps(usize::MAX, net, order, judge)?;
        Repair::measure(net, judge);
        visit.make_due(net, order);
        let fitted = judge.fitting.is_some();
        let (caps, patience) = if fitted { (FITTED_CAPS, FITTED) } else { (BALANCED_CAPS, BALANCED) };
        for cap in caps {
            repair.sweep(net, order, judge, Patience { cap, ..patience })?;
            repair.relax(net, order, judge, 1)?;
        }
        Ok(())
    }

    fn best(&mut self, visit: Visit<'_>, judge: &mut Judge<'_>) -> Result<(), Cancelled> {
        let Scratch { net, order, removal, repair } = self;
        removal.sweeps(usize::MAX, net, order, judge)?;
        Repair::measure(net, judge);
        let fitted = judge.fitting.is_some();
        let (caps, patience, least) = if fitted {
            (&BEST_FITTED_CAPS[..], BEST_FITTED, BEST_FITTED_YIELD)
        } else {
            (&BEST_CAPS[..], BEST, BEST_YIELD)
        };
        for pass in 0..BEST_PASSES {
            let cap = caps[pass.min(caps.len() - 1)];
            visit.make_due(net, order);
            let gone = repair.sweep(net, order, judge, Patience { cap, ..patience })?;
            repair.relax(net, order, judge, patience.steps)?;
            if pass >= caps.len() && gone * least < order.raster.len() {
                break;
            }
        }
        Ok(())
    }
}
