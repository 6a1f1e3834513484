//! Where all insertions of a raster end: the last key within the budgets.

use std::io;

use super::{Budget, Cost, Curves, Goal, GoalTooSmall, Outcome, Told};
use crate::kernel::triangulate::progressive::Key;

/// Vertices, triangles and squared errors, added up.
#[derive(Debug, Clone, Copy, Default)]
struct Sum {
    points: u64,
    triangles: u64,
    squares: f64,
    insertions: u64,
}

impl Sum {
    fn add(&mut self, told: &Told) {
        self.insertions += 1;
        self.points += told.cost.points;
        self.triangles += told.cost.triangles;
        self.squares += told.squares;
    }

    fn plus(self, other: Sum) -> Sum {
        Sum {
            points: self.points + other.points,
            triangles: self.triangles + other.triangles,
            squares: self.squares + other.squares,
            insertions: self.insertions + other.insertions,
        }
    }
}

/// Bits of a rank that are looked at in one reading.
const DIGIT: u32 = 16;

/// The share of the mean square that rounding of its sums is allowed: the goal is held to a little less.
const ROUNDING: f64 = 1e-9;

/// Finds the last key that may be inserted, and what ended it there: of all insertions in the order of their keys, as
/// many as the budgets allow, and no more than the root mean square needs. `error_needs` is the last key that the
/// tolerance needs.
///
/// Radix selection: four readings of the curves, each settling 16 bits of the rank, and two more where insertions of
/// equal error have to be told apart. Memory: 2 MiB. `samples` is how many there are, for the mean.
pub(in crate::job) fn find_cut(
    curves: &Curves,
    goal: &Goal,
    samples: u64,
    error_needs: Option<Key>,
) -> io::Result<Result<(Key, Outcome), GoalTooSmall>> {
    let limits = Limits { goal: *goal, samples, error_needs };
    let mut before = Sum::default();
    // What is there from the start.
    curves.for_each(|t| {
        if t.key == Key::FIRST {
            before.add(t);
        }
        true
    })?;
    if let Err(too_small) = goal.check(Cost { points: before.points, triangles: before.triangles }) {
        return Ok(Err(too_small));
    }
    if limits.reached(before, Key::FIRST) {
        return Ok(Ok((Key::FIRST, outcome(None, f64::INFINITY))));
    }
    let mut prefix = 0u64;
    for level in 0..64 / DIGIT {
        let shift = 64 - DIGIT * (level + 1);
        let bins = sums(curves, prefix, shift)?;
        let mut there: Vec<(usize, Sum)> = bins.into_iter().enumerate().filter(|(_, b)| b.insertions > 0).collect();
        let mut stop = None;
        let mut sum = before;
        for (i, (digit, bin)) in there.iter().enumerate() {
            let after = sum.plus(*bin);
            let last = Key::last_of_rank((prefix << DIGIT | *digit as u64) << shift | low_bits(shift));
            if limits.stop_at(after, last) {
                stop = Some(i);
                break;
            }
            sum = after;
        }
        match stop {
            Some(i) => there.truncate(i + 1),
            // No limit is met by all there is.
            None if level == 0 => return Ok(Ok((Key::last_of_rank(u64::MAX), outcome(None, last_error(curves)?)))),
            // The reading before says that it is met here; only its sums were rounded differently. It is met at the end.
            None => {}
        }
        let Some((digit, _)) = there.pop() else { break };
        before = there.iter().fold(before, |sum, (_, bin)| sum.plus(*bin));
        prefix = prefix << DIGIT | digit as u64;
    }
    limits.within_rank(curves, prefix, before).map(Ok)
}

fn low_bits(shift: u32) -> u64 {
    if shift == 0 { 0 } else { u64::MAX >> (64 - shift) }
}

fn outcome(ended_by: Option<Budget>, threshold: f64) -> Outcome {
    Outcome { ended_by, threshold, search: None }
}

/// The sums of all insertions whose rank begins with `prefix`, by its next digit.
fn sums(curves: &Curves, prefix: u64, shift: u32) -> io::Result<Vec<Sum>> {
    let mut bins = vec![Sum::default(); 1 << DIGIT];
    curves.for_each(|t| {
        let rank = t.key.rank();
        let upper = rank.checked_shr(shift + DIGIT).unwrap_or(0);
        if t.key != Key::FIRST && upper == prefix {
            bins[(rank >> shift & ((1 << DIGIT) - 1)) as usize].add(t);
        }
        true
    })?;
    Ok(bins)
}

fn last_error(curves: &Curves) -> io::Result<f64> {
    let mut last = Key::FIRST;
    curves.for_each(|t| {
        last = last.max(t.key);
        true
    })?;
    Ok(if last == Key::FIRST { f64::INFINITY } else { last.error() })
}

struct Limits {
    goal: Goal,
    samples: u64,
    error_needs: Option<Key>,
}

impl Limits {
    /// The budget that so much would exceed.
    fn exceeded(&self, sum: Sum) -> Option<Budget> {
        let beyond = |most: Option<u64>, found: u64| most.is_some_and(|most| found > most);
        if beyond(self.goal.max_points, sum.points) {
            return Some(Budget::MaxPoints);
        }
        beyond(self.goal.max_triangles, sum.triangles).then_some(Budget::MaxTriangles)
    }

    /// Whether all qualities are reached once everything up to `last` is inserted. The tolerance alone is reached when
    /// there is nothing more to insert.
    fn reached(&self, sum: Sum, last: Key) -> bool {
        let Some(rms) = self.goal.max_rms else { return false };
        let squares = rms * rms * self.samples as f64 * (1.0 - ROUNDING);
        sum.squares <= squares && self.error_needs.is_none_or(|needs| needs <= last)
    }

    fn stop_at(&self, after: Sum, last: Key) -> bool {
        self.exceeded(after).is_some() || self.reached(after, last)
    }

    /// The cut among insertions of one rank: all of them, if they reach what is asked for within the budgets; else as many
    /// as the budgets allow, rims first, then by tile and ordinal, which is the order they are read in.
    fn within_rank(&self, curves: &Curves, rank: u64, before: Sum) -> io::Result<(Key, Outcome)> {
        let mut cut = rank.checked_sub(1).map_or(Key::FIRST, Key::last_of_rank);
        let (mut sum, mut ended_by) = (before, None);
        for interior in [false, true] {
            curves.for_each(|t| {
                // What costs nothing is told by the tile that owns it, too.
                let here = t.key != Key::FIRST && t.key.rank() == rank && t.key.is_interior() == interior;
                if !here || t.cost.points == 0 {
                    return ended_by.is_none();
                }
                let mut after = sum;
                after.add(t);
                ended_by = self.exceeded(after);
                if ended_by.is_none() {
                    (sum, cut) = (after, cut.max(t.key));
                }
                ended_by.is_none()
            })?;
        }
        if ended_by.is_none() {
            cut = Key::last_of_rank(rank);
        }
        Ok((cut, outcome(ended_by, Key::last_of_rank(rank).error())))
    }
}

impl Goal {
    /// Whether the budgets are enough for what is there from the start.
    pub(in crate::job) fn check(&self, first: Cost) -> Result<(), GoalTooSmall> {
        for (what, most, smallest) in
            [("vertices", self.max_points, first.points), ("triangles", self.max_triangles, first.triangles)]
        {
            if let Some(found) = most.filter(|&most| most < smallest) {
                return Err(GoalTooSmall { what, smallest, found });
            }
        }
        Ok(())
    }
}
