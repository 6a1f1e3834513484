//! Small holes of the raster, which the ground goes on over.

use crate::base::control::{Control, Stage};

use super::VerifyError;
use super::joins::Joins;
use super::runs::{Run, runs_of};
use super::samples::BandReader;
use crate::base::external::{Scratch, Sorted, Sorter};

/// Bytes of the sort of runs.
const RUN_BYTES: usize = 4 << 20;

/// The holes that are bridged.
#[derive(Debug)]
pub(super) struct Bridges<'s> {
    /// How many holes.
    pub(super) holes: u64,
    /// Their samples, by rows.
    pub(super) runs: Sorted<'s, 3>,
}

/// Finds the groups of at most `limit` samples without a height, eight neighbours to a sample, that have none in the first
/// or last row or column: a pass over the raster.
///
/// Memory use is that of the reader and the sort, and O(width + samples of groups that are not decided yet): a group is
/// forgotten as soon as it is too large or at the edge, and its runs are handed on when it ends.
pub(super) fn find_bridges<'s>(
    mut reader: BandReader<'_>,
    limit: u64,
    scratch: &'s Scratch,
    control: &Control<'_>,
) -> Result<Bridges<'s>, VerifyError> {
    let (width, height) = (reader.raster().width(), reader.raster().height());
    let mut holes = Holes::new(width, height, limit, scratch);
    control.progress.begin(Stage::Ground, reader.count() as u64, width as u64 * height as u64);
    for index in 0..reader.count() {
        control.cancel.check()?;
        let first_row = index * reader.rows();
        let heights = reader.read(index)?;
        for (row, line) in (first_row..).zip(heights.chunks(width)) {
            holes.pass(row, runs_of(line, |h: &f64| h.is_nan()))?;
        }
        control.progress.step(Stage::Ground, heights.len() as u64);
    }
    control.progress.end(Stage::Ground);
    holes.finish()
}

/// A group of samples without a height, as far as the rows have passed.
#[derive(Debug)]
struct Group {
    /// Whether it may still be a hole that is bridged.
    is_open: bool,
    samples: u64,
    /// Empty where it is not open.
    runs: Vec<Run>,
}

impl Group {
    fn absorb(&mut self, mut other: Group, limit: u64) {
        self.is_open &= other.is_open;
        self.samples += other.samples;
        if self.samples > limit {
            self.is_open = false;
        }
        if !self.is_open {
            self.runs = Vec::new();
            return;
        }
        // The shorter list is moved.
        if self.runs.len() < other.runs.len() {
            std::mem::swap(&mut self.runs, &mut other.runs);
        }
        self.runs.append(&mut other.runs);
    }
}

/// The groups that reach into the latest row, and the bridged ones that have ended.
#[derive(Debug)]
struct Holes<'s> {
    width: usize,
    height: usize,
    limit: u64,
    /// The runs of the latest row, and their groups.
    above: Vec<(usize, usize, usize)>,
    groups: Vec<Group>,
    holes: u64,
    sorter: Sorter<'s, 3>,
}

impl<'s> Holes<'s> {
    fn new(width: usize, height: usize, limit: u64, scratch: &'s Scratch) -> Self {
        let sorter = Sorter::new(scratch, RUN_BYTES);
        Holes { width, height, limit, above: Vec::new(), groups: Vec::new(), holes: 0, sorter }
    }

    /// Takes the runs of the next row.
    fn pass(&mut self, row: usize, runs: impl Iterator<Item = (usize, usize)>) -> Result<(), VerifyError> {
        let on_edge = row == 0 || row + 1 == self.height;
        let mut joins = Joins::new(std::mem::take(&mut self.groups));
        let mut here = Vec::new();
        let mut next_above = 0;
        for (first, after) in runs {
            let samples = (after - first) as u64;
            let is_open = !on_edge && first > 0 && after < self.width && samples <= self.limit;
            let run = [row as u64, first as u64, after as u64];
            let group = joins.add(Group { is_open, samples, runs: if is_open { vec![run] } else { Vec::new() } });
            // A run touches those above it that end beside its first sample or later, and begin beside its last or before.
            while self.above.get(next_above).is_some_and(|above| above.1 < first) {
                next_above += 1;
            }
            for &(_, _, above) in self.above[next_above..].iter().take_while(|above| above.0 <= after) {
                joins.join(above, group, |into, taken| into.absorb(taken, self.limit));
            }
            here.push((first, after, group));
        }
        let (going_on, ended) = joins.end(here.iter_mut().map(|(_, _, group)| group));
        (self.above, self.groups) = (here, going_on);
        ended.into_iter().try_for_each(|group| self.end(group))
    }

    /// Nothing can join the group any more.
    fn end(&mut self, group: Group) -> Result<(), VerifyError> {
        self.holes += u64::from(group.is_open);
        Ok(group.runs.into_iter().try_for_each(|run| self.sorter.push(run))?)
    }

    fn finish(mut self) -> Result<Bridges<'s>, VerifyError> {
        std::mem::take(&mut self.groups).into_iter().try_for_each(|ended| self.end(ended))?;
        Ok(Bridges { holes: self.holes, runs: self.sorter.finish()? })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Flood fill, sample by sample: which samples are bridged, and how many holes they make.
    fn naive(width: usize, missing: &[bool], limit: u64) -> (Vec<bool>, u64) {
        let height = missing.len() / width;
        let (mut seen, mut bridged, mut holes) = (vec![false; missing.len()], vec![false; missing.len()], 0);
        for start in 0..missing.len() {
            let (mut group, mut next) = (vec![start], 0);
            if seen[start] || !missing[start] {
                continue;
            }
            seen[start] = true;
            while next < group.len() {
                let (column, row) = (group[next] % width, group[next] / width);
                next += 1;
                for (r, c) in (row.saturating_sub(1)..(row + 2).min(height))
                    .flat_map(|r| (column.saturating_sub(1)..(column + 2).min(width)).map(move |c| (r, c)))
                {
                    let at = r * width + c;
                    if missing[at] && !std::mem::replace(&mut seen[at], true) {
                        group.push(at);
                    }
                }
            }
            let at_edge = |&at: &usize| {
                let (column, row) = (at % width, at / width);
                column == 0 || row == 0 || column + 1 == width || row + 1 == height
            };
            if group.len() as u64 <= limit && !group.iter().any(at_edge) {
                holes += 1;
                group.into_iter().for_each(|at| bridged[at] = true);
            }
        }
        (bridged, holes)
    }

    proptest! {
        #[test]
        fn holes_are_those_that_a_flood_fill_finds(
            width in 1usize..24, share in 0.0f64..0.9, limit in 0u64..30,
            samples in proptest::collection::vec(0.0f64..1.0, 1..500),
        ) {
            let height = samples.len().div_ceil(width);
            let missing: Vec<bool> = (0..width * height).map(|i| samples[i % samples.len()] < share).collect();
            let scratch = Scratch::new(None, Default::default());
            let mut holes = Holes::new(width, height, limit, &scratch);
            for (row, line) in missing.chunks(width).enumerate() {
                holes.pass(row, runs_of(line, |m| *m)).unwrap();
                let held = |g: &Group| if g.is_open { g.samples <= limit } else { g.runs.is_empty() };
                prop_assert!(holes.groups.iter().all(held));
            }
            let Bridges { holes, runs } = holes.finish().unwrap();
            let mut found = vec![false; missing.len()];
            for run in runs {
                let [row, first, after] = run.unwrap().map(|n| n as usize);
                found[row * width + first..row * width + after].iter_mut().for_each(|f| {
                    assert!(!std::mem::replace(f, true));
                });
            }
            prop_assert_eq!((found, holes), naive(width, &missing, limit));
        }
    }
}
