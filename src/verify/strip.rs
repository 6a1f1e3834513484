//! The strip along samples without a height, where the ground may be trimmed.

use crate::base::control::{Control, Stage};

use super::VerifyError;
use super::runs::{RunFlags, runs_of};
use super::samples::BandReader;
use crate::base::external::{Queue, Scratch, Sorted};

/// Samples near others without a height, and the bridged ones once more.
#[derive(Debug)]
pub(super) struct Strip<'s> {
    /// Runs of samples at most so many columns and rows from one that has no height and is not bridged, by rows.
    pub(super) near: Queue<'s, 3>,
    /// Runs of the bridged samples, by rows.
    pub(super) bridged: Queue<'s, 3>,
}

/// Finds the samples that are at most `cells` columns and rows (the larger of the two) from a sample of the raster without
/// a height that is not bridged: a pass over the raster.
///
/// Memory use is that of the reader, a byte for each sample of its band, 8 bytes for each of a row, and two queues: of each
/// column the last row with such a sample near it in its row is enough to know, whatever the distance.
pub(super) fn find_strip<'s>(
    mut reader: BandReader<'_>,
    bridges: Option<Sorted<'s, 3>>,
    cells: u32,
    scratch: &'s Scratch,
    control: &Control<'_>,
) -> Result<Strip<'s>, VerifyError> {
    let (width, height) = (reader.raster().width(), reader.raster().height());
    let mut nearness = Nearness::new(width, height, cells as usize, scratch);
    let mut bridges = bridges.map(|runs| RunFlags::new(runs, 1));
    let mut bridged = Queue::new(scratch);
    let mut flags = Vec::new();
    control.progress.begin(Stage::Ground, reader.count() as u64, width as u64 * height as u64);
    for index in 0..reader.count() {
        control.cancel.check()?;
        let first_row = index * reader.rows();
        let heights = reader.read(index)?;
        flags.clear();
        flags.resize(heights.len(), 0);
        if let Some(bridges) = &mut bridges {
            bridges.set(first_row, width, &mut flags, |run| Ok(bridged.push(run)?))?;
        }
        heights.iter().zip(&mut flags).for_each(|(height, flag)| *flag = u8::from(height.is_nan() && *flag == 0));
        flags.chunks(width).try_for_each(|row| nearness.pass(runs_of(row, |missing| *missing != 0)))?;
        control.progress.step(Stage::Ground, heights.len() as u64);
    }
    control.progress.end(Stage::Ground);
    Ok(Strip { near: nearness.finish()?, bridged })
}

/// Rows of samples without a height, and which samples are near them.
#[derive(Debug)]
struct Nearness<'s> {
    cells: usize,
    height: usize,
    /// The rows that have passed.
    rows: usize,
    /// Of each column the number (from 1) of the last row that has a sample without a height near it; 0 where none has.
    last: Vec<usize>,
    near: Queue<'s, 3>,
}

impl<'s> Nearness<'s> {
    fn new(width: usize, height: usize, cells: usize, scratch: &'s Scratch) -> Self {
        Nearness { cells, height, rows: 0, last: vec![0; width], near: Queue::new(scratch) }
    }

    /// Takes the runs of samples without a height in the next row.
    fn pass(&mut self, missing: impl Iterator<Item = (usize, usize)>) -> Result<(), VerifyError> {
        let mut filled = 0;
        for (first, after) in missing {
            let (begin, end) =
                (first.saturating_sub(self.cells).max(filled), (after + self.cells).min(self.last.len()));
            self.last[begin.min(end)..end].fill(self.rows + 1);
            filled = end;
        }
        self.advance()
    }

    /// One row more is known: the row that is `cells` above it is decided.
    fn advance(&mut self) -> Result<(), VerifyError> {
        self.rows += 1;
        let Some(row) = self.rows.checked_sub(self.cells + 1) else { return Ok(()) };
        // Rows are counted from 1 in `last`: the first one that is near.
        let first_near = (row + 1).saturating_sub(self.cells).max(1);
        for (first, after) in runs_of(&self.last, |last| *last >= first_near) {
            self.near.push([row as u64, first as u64, after as u64])?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Queue<'s, 3>, VerifyError> {
        while self.rows < self.height + self.cells {
            self.advance()?;
        }
        Ok(self.near)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn samples_are_near_where_a_square_around_them_holds_one_without_a_height(
            width in 1usize..16, height in 1usize..12, share in 0.8f64..1.0, cells in 1usize..9,
            samples in proptest::collection::vec(0.0f64..1.0, 192),
        ) {
            let missing: Vec<bool> = samples[..width * height].iter().map(|s| *s > share).collect();
            let scratch = Scratch::new(None, Default::default());
            let mut nearness = Nearness::new(width, height, cells, &scratch);
            missing.chunks(width).for_each(|row| nearness.pass(runs_of(row, |m| *m)).unwrap());
            let mut flags = vec![0; width * height];
            let runs = nearness.finish().unwrap().into_records();
            RunFlags::new(runs, 1).set(0, width, &mut flags, |_| Ok(())).unwrap();
            for (at, flag) in flags.into_iter().enumerate() {
                let near = |other: usize| (at % width).abs_diff(other % width).max((at / width).abs_diff(other / width));
                let expected = (0..missing.len()).any(|other| missing[other] && near(other) <= cells);
                prop_assert_eq!(flag == 1, expected, "{} of {:?}", at, missing);
            }
        }
    }
}
