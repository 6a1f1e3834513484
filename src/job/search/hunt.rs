//! Looking for a tolerance: guesses by cheap measurements first, whole runs then.

use super::curve::{Curve, within_reason};
use super::decimals::{next_above, next_below, tidy};
use super::figures::{Figures, Quantity, SHARE};
use crate::job::{Budget, Error, Goal, GoalTooSmall};

/// What meshes are made by, to see what they come to.
pub(super) trait Bench {
    /// Cheaper ways than a run to guess what it comes to, the cheapest first; perhaps none.
    fn previews(&self) -> &[Preview];

    /// What a preview of a run comes to, scaled to the whole raster.
    fn preview(&mut self, number: usize, tolerance: f64) -> Result<Figures, Error>;

    /// What a whole run comes to.
    fn run(&mut self, tolerance: f64) -> Result<Figures, Error>;

    /// Of all runs so far, the mesh of this one alone may be asked for; of none, where there is none.
    fn keep(&mut self, best: Option<f64>) -> Result<(), Error>;

    /// A tolerance to begin with, where nothing is known.
    fn start(&self) -> f64;

    /// From the least height to the greatest, about.
    fn span(&self) -> f64;

    /// What heights are multiples of, if they are: counts jump where the tolerance is a multiple, too.
    fn step(&self) -> Option<f64>;
}

/// A cheaper way than a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct Preview {
    /// How near to a tolerance it has to have been tried to speak of it, as a share.
    pub(super) near: f64,
    /// How many times the triangles of this preview are expected of the next finer way, before both are known.
    pub(super) bias: f64,
}

/// What is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub(super) goal: Goal,
    /// The tolerance that is asked for beside the goal; infinite where there is none.
    pub(super) coarsest: f64,
    /// The least tolerance that can be kept.
    pub(super) finest: f64,
}

/// What a search has come to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Found {
    pub(super) tolerance: f64,
    pub(super) figures: Figures,
    pub(super) runs: usize,
    pub(super) ended_by: Option<Budget>,
    /// The largest tolerance that was tried below, if its mesh exceeds a budget.
    pub(super) beyond: Option<(f64, Figures)>,
}

/// What a run's mesh is to the goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    TooFine,
    TooCoarse,
    Meets,
}

/// Brackets that are halved are closed by then.
const MOST_RUNS: usize = 20;

/// How often a preview is tried for one guess, and in all.
const MOST_PREVIEWS: usize = 8;
const MOST_PREVIEWS_IN_ALL: usize = 12;

/// Errors are not larger than from the least height to the greatest; weights may make them so, or heights that nobody has seen.
const BEYOND: f64 = 4.0;

/// How far steps go at the least, by how many runs in a row have been on the same side.
const STEPS: [f64; 7] = [1.05, 1.05, 1.05, 1.2, 1.6, 2.5, 4.0];

/// At so many steps of the heights counts jump.
const LARGE_STEPS: f64 = 3.0;

/// Tolerances closer than this are the same, as a share.
const CLOSE: f64 = 1e-3;

impl Aim {
    fn verdict(&self, tolerance: f64, figures: &Figures) -> Verdict {
        let times = Quantity::budget(&self.goal).map(|budget| budget.of(figures));
        if times.is_some_and(|times| times < 1.0) {
            return Verdict::TooFine;
        }
        if self.asks_for_quality() && self.is_reached(tolerance, figures) {
            let rms = self.rms().map(|rms| rms.of(figures));
            let is_coarse = tolerance >= self.coarsest || rms.is_some_and(|share| share >= SHARE);
            return if is_coarse { Verdict::Meets } else { Verdict::TooFine };
        }
        let is_spent = times.is_some_and(|times| times * SHARE <= 1.0);
        if is_spent || tolerance <= self.finest { Verdict::Meets } else { Verdict::TooCoarse }
    }

    /// A root mean square to come to; one of 0 is a matter of [`Aim::coarsest`].
    fn rms(&self) -> Option<Quantity> {
        self.goal.max_rms.filter(|rms| *rms > 0.0).map(Quantity::Rms)
    }

    fn asks_for_quality(&self) -> bool {
        self.goal.max_rms.is_some() || self.coarsest.is_finite()
    }

    /// Whether all qualities are reached that are asked for.
    fn is_reached(&self, tolerance: f64, figures: &Figures) -> bool {
        tolerance <= self.coarsest && self.goal.max_rms.is_none_or(|rms| figures.rms <= rms)
    }

    /// The budget that is spent the most, where one ends a run.
    fn ended_by(&self, tolerance: f64, figures: &Figures) -> Option<Budget> {
        let is_reached = self.asks_for_quality() && self.is_reached(tolerance, figures);
        if is_reached || tolerance <= self.finest {
            return None;
        }
        let share = |most: Option<u64>, count: u64| most.map_or(0.0, |most| count as f64 / most as f64);
        let Goal { max_points, max_triangles, .. } = self.goal;
        let by_points = share(max_points, figures.vertices) > share(max_triangles, figures.triangles);
        Some(if by_points { Budget::MaxPoints } else { Budget::MaxTriangles })
    }

    fn is_within(&self, figures: &Figures) -> bool {
        Quantity::budget(&self.goal).is_none_or(|budget| budget.of(figures) >= 1.0)
    }

    /// What to say of a budget that no mesh keeps to.
    fn too_small(&self, figures: &Figures) -> GoalTooSmall {
        let Goal { max_points, max_triangles, .. } = self.goal;
        match max_points.filter(|&most| figures.vertices > most) {
            Some(found) => GoalTooSmall { what: "vertices", smallest: figures.vertices, found },
            None => {
                let found = max_triangles.unwrap_or(u64::MAX);
                GoalTooSmall { what: "triangles", smallest: figures.triangles, found }
            }
        }
    }
}

/// A search under way.
pub(super) struct Hunt<'a> {
    bench: &'a mut dyn Bench,
    aim: Aim,
    /// Of every preview, and of whole runs.
    curves: Vec<Curve>,
    /// The largest tolerance whose mesh is too fine, and the least whose mesh is too coarse.
    low: Option<f64>,
    high: Option<f64>,
    /// How many runs in a row have been on the same side.
    streak: usize,
    last: Option<f64>,
    best: Option<(f64, Figures)>,
}

impl<'a> Hunt<'a> {
    pub(super) fn new(bench: &'a mut dyn Bench, aim: Aim) -> Hunt<'a> {
        let curves = (0..=bench.previews().len()).map(|_| Curve::default()).collect();
        Hunt { bench, aim, curves, low: None, high: None, streak: 0, last: None, best: None }
    }

    /// The tolerance of the first run, and what is known of one close to it.
    pub(super) fn foretell(&mut self) -> Result<(f64, Option<Figures>), Error> {
        let tolerance = self.next()?;
        let tried = self.curves.iter().rev().find_map(|curve| curve.estimate(tolerance));
        Ok((tolerance, tried))
    }

    /// Runs until a mesh meets the goal: within the budgets, and with [`SHARE`] of one spent or with all qualities only just
    /// reached. Where two tolerances next to each other lie on either side of that, or after [`MOST_RUNS`], the best of
    /// those within the budgets.
    ///
    /// # Errors
    /// [`Error`]; [`Error::Goal`] where the coarsest mesh there is exceeds a budget.
    pub(super) fn finish(mut self) -> Result<Found, Error> {
        let mut runs = 0;
        loop {
            let tolerance = self.next()?;
            let figures = self.bench.run(tolerance)?;
            self.curves.last_mut().expect("a curve of runs").add(tolerance, figures);
            runs += 1;
            let verdict = self.aim.verdict(tolerance, &figures);
            self.consider(tolerance, figures);
            self.bench.keep(self.best.map(|(best, _)| best))?;
            match verdict {
                Verdict::Meets => break,
                // A larger tolerance changes nothing.
                Verdict::TooFine if self.is_coarsest(tolerance, &figures) => match self.best {
                    Some(_) => break,
                    None => return Err(self.aim.too_small(&figures).into()),
                },
                Verdict::TooFine => self.narrow(tolerance, true),
                Verdict::TooCoarse => self.narrow(tolerance, false),
            }
            let is_close = |(low, high)| high - low <= CLOSE * high || next_above(low) >= high;
            let is_closed = self.low.zip(self.high).is_some_and(is_close);
            if self.best.is_some() && (is_closed || runs >= MOST_RUNS) {
                break;
            }
        }
        Ok(self.found(runs))
    }

    /// Takes a run into account that does not meet the goal.
    fn narrow(&mut self, tolerance: f64, is_too_fine: bool) {
        let side = if is_too_fine { &mut self.low } else { &mut self.high };
        let was_before = *side == self.last;
        *side = Some(tolerance);
        self.streak = if was_before && self.last.is_some() { self.streak + 1 } else { 1 };
        self.last = Some(tolerance);
    }

    /// Whether a larger tolerance changes nothing: this one exceeds all errors there can be.
    fn is_coarsest(&self, tolerance: f64, figures: &Figures) -> bool {
        figures.largest <= tolerance / 2.0 && tolerance >= tidy(BEYOND * self.bench.span())
    }

    /// A tolerance that exceeds all errors there can be, as far as is known.
    fn largest_of_use(&self) -> f64 {
        let largest = self.runs().largest().max(self.bench.span());
        if largest > 0.0 { BEYOND * largest } else { f64::INFINITY }
    }

    fn found(&self, runs: usize) -> Found {
        let (tolerance, figures) = self.best.expect("a mesh within the budgets");
        let ended_by = self.aim.ended_by(tolerance, &figures);
        let low = self.low.filter(|low| *low < tolerance && ended_by.is_some());
        let beyond = low.and_then(|low| self.runs().at(low).map(|figures| (low, *figures)));
        Found { tolerance, figures, runs, ended_by, beyond }
    }

    fn runs(&self) -> &Curve {
        &self.curves[self.curves.len() - 1]
    }

    /// Keeps a run's mesh in mind if it is the best so far: one that reaches all qualities with the fewest triangles, else the
    /// one with the least tolerance.
    fn consider(&mut self, tolerance: f64, figures: Figures) {
        if !self.aim.is_within(&figures) {
            return;
        }
        let reaches =
            |tolerance, figures: &Figures| self.aim.asks_for_quality() && self.aim.is_reached(tolerance, figures);
        let is_better = |(other, before): &(f64, Figures)| match (reaches(tolerance, &figures), reaches(*other, before))
        {
            (true, true) => figures.triangles < before.triangles,
            (false, false) => tolerance < *other,
            (reaches, _) => reaches,
        };
        if self.best.as_ref().is_none_or(is_better) {
            self.best = Some((tolerance, figures));
        }
    }

    /// The tolerance to try next.
    fn next(&mut self) -> Result<f64, Error> {
        let last = self.curves.len() - 1;
        let guess = match Quantity::budget(&self.aim.goal) {
            Some(budget) => Some(self.guess(last, budget, budget.aim())?),
            None => None,
        };
        let quality = match self.aim.rms() {
            Some(rms) => self.guess(last, rms, rms.aim())?.min(self.aim.coarsest),
            None => self.aim.coarsest,
        };
        let guess = match guess {
            Some(budget) if quality.is_finite() => budget.max(quality),
            Some(budget) => budget,
            None => quality,
        };
        let guess = if guess == self.aim.coarsest { guess } else { tidy(guess.min(self.largest_of_use())) };
        Ok(self.untried(guess.max(self.aim.finest)))
    }

    /// A tolerance near a guess that can bring something new. Where one run after the other ends on the same side, guesses are
    /// not trusted any more: steps grow, and brackets are halved.
    fn untried(&self, guess: f64) -> f64 {
        let factor = STEPS[self.streak.min(STEPS.len() - 1)];
        match (self.low, self.high) {
            (Some(low), Some(high)) => {
                let middle = if high > 4.0 * low { (low * high).sqrt().max(high / 16.0) } else { (low + high) / 2.0 };
                let guess = if self.streak > 2 { tidy(middle) } else { guess };
                guess.max(next_above(low)).min(next_below(high))
            }
            // Nothing is in proportion to 0.
            (Some(0.0), None) => {
                if guess > 0.0 {
                    guess
                } else {
                    self.bench.start()
                }
            }
            (Some(low), None) => {
                let least = tidy(factor * low).max(next_above(low));
                if guess <= low || self.streak > 2 { guess.max(least) } else { guess }
            }
            // A jump is all there is between, perhaps.
            (None, Some(high)) if guess >= 0.97 * high && self.is_large_step(high) => next_below(high),
            (None, Some(_)) if self.streak > 3 => self.aim.finest,
            (None, Some(high)) => {
                let most = tidy(high / factor).min(next_below(high)).max(self.aim.finest);
                if guess >= high || self.streak > 2 { guess.min(most) } else { guess }
            }
            (None, None) => guess,
        }
    }

    /// Where a quantity may come to a target, by what is known of a way and of cheaper ones. Those are tried as needed.
    fn guess(&mut self, way: usize, quantity: Quantity, target: f64) -> Result<f64, Error> {
        if let Some(tolerance) = self.step_around(way, quantity, target) {
            return Ok(tolerance);
        }
        let curve = &self.curves[way];
        if way == 0 || curve.leads_to(quantity, target) {
            let guess = curve.guess(quantity, target).unwrap_or_else(|| self.bench.start());
            let near = curve.nearest(quantity, target).map_or(guess, |(near, _)| near);
            return Ok(self.step_between(near, guess).filter(|&step| curve.at(step).is_none()).unwrap_or(guess));
        }
        let cheaper = &self.curves[way - 1];
        let expected = match curve.nearest(quantity, target) {
            Some((tolerance, found)) if found > 0.0 => {
                let there = cheaper.estimate(tolerance);
                there.map_or(target, |there| target / found * quantity.of(&there))
            }
            _ => match quantity {
                Quantity::Budget { .. } => target * self.bench.previews()[way - 1].bias,
                Quantity::Rms(_) => target,
            },
        };
        let nearest = curve.nearest(quantity, target);
        let guess = self.settle(way - 1, quantity, expected)?;
        // Cheaper ways know steps of heights, but of a small difference they know little.
        let is_smooth = |near: f64| self.bench.step().is_none_or(|step| near > LARGE_STEPS * step);
        Ok(match nearest {
            Some((near, value)) if way + 1 == self.curves.len() && near > 0.0 && value > 0.0 && is_smooth(near) => {
                near + within_reason(guess - near, near * (target / value - 1.0))
            }
            _ => guess,
        })
    }

    /// Tries a preview until it has been tried near where the quantity comes to a target.
    fn settle(&mut self, way: usize, quantity: Quantity, target: f64) -> Result<f64, Error> {
        let near = self.bench.previews()[way].near;
        let mut tolerance = self.aim.finest;
        for tries in 0..MOST_PREVIEWS {
            let guess = self.guess(way, quantity, target)?.min(self.largest_of_use());
            let least = self.curves[way].least();
            // Smaller tolerances lead nowhere, or not soon.
            let is_endless = tries >= 3 && least.is_some_and(|least| guess < 0.6 * least);
            tolerance = if is_endless { self.aim.finest } else { tidy(guess).max(self.aim.finest) };
            let has_step = self.step_around(way, quantity, target).is_some();
            if !has_step && self.curves[way].has_near(tolerance, near) {
                break;
            }
            if self.curves[way].at(tolerance).is_some() || self.curves[way].len() >= MOST_PREVIEWS_IN_ALL {
                break;
            }
            let figures = self.bench.preview(way, tolerance)?;
            self.curves[way].add(tolerance, figures);
        }
        Ok(tolerance)
    }

    /// The least multiple of the step of heights after a tolerance, up to a larger one: no line leads beyond it, if it is one of
    /// the first, where jumps are large.
    fn step_between(&self, after: f64, up_to: f64) -> Option<f64> {
        let step = self.bench.step()?;
        let multiple = ((after / step).floor() + 1.0) * step;
        (multiple <= up_to && multiple <= LARGE_STEPS * step).then_some(multiple)
    }

    /// Whether a tolerance is one of the first multiples of the step of heights.
    fn is_large_step(&self, tolerance: f64) -> bool {
        self.bench.step().is_some_and(|step| tolerance % step == 0.0 && tolerance <= LARGE_STEPS * step)
    }

    /// A tolerance where a jump is likely, between two that lie on either side of the target, farther from each other than
    /// tolerances so close would have them: a multiple of the step of heights, or the next below it.
    fn step_around(&self, way: usize, quantity: Quantity, target: f64) -> Option<f64> {
        let step = self.bench.step()?;
        let [low, high] = self.curves[way].around(quantity, target)?;
        let is_steep = high.1 > low.1 * (1.02 + 2.0 * (high.0 / low.0 - 1.0));
        if !is_steep || high.0 - low.0 > 2.0 * step || high.0 - low.0 <= CLOSE * high.0 {
            return None;
        }
        let multiple = (high.0 / step).floor() * step;
        let candidates = [multiple, next_below(multiple)];
        candidates.into_iter().find(|&t| low.0 < t && t < high.0 && self.curves[way].at(t).is_none())
    }
}
