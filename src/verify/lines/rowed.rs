//! Records by rows of cells or of samples, in memory or in a temporary file.

use std::ops::Range;

use crate::base::external::{Scratch, ScratchError, Shelves};

/// Rows that are in one list.
const ROWS: i64 = if cfg!(test) { 2 } else { 16 };

/// Bytes of records in memory; tests go to the file.
const IN_MEMORY: usize = if cfg!(test) { 1 << 10 } else { 8 << 20 };

/// Records of `N` words whose first word has a row in its high bits, from the first row to the last.
///
/// Memory: 8 MiB of records, and some 60 bytes for each 16 rows.
#[derive(Debug)]
pub(super) struct Rowed<const N: usize> {
    shelves: Shelves<N>,
    /// Bits of the first word below the row.
    below: u32,
    /// Those of the last list, which is not put away yet.
    latest: Vec<[u64; N]>,
    count: u64,
}

impl<const N: usize> Rowed<N> {
    /// None, of a kind whose first word has so many bits below the row.
    pub(super) fn new(scratch: &Scratch, below: u32) -> Rowed<N> {
        Rowed { shelves: Shelves::new(scratch.clone(), IN_MEMORY), below, latest: Vec::new(), count: 0 }
    }

    fn row(&self, record: &[u64; N]) -> i64 {
        (record[0] >> self.below) as i64
    }

    /// Adds a record of the row that the last one is of, or of one below.
    pub(super) fn push(&mut self, record: [u64; N]) -> Result<(), ScratchError> {
        if self.latest.last().is_some_and(|last| self.row(last) / ROWS != self.row(&record) / ROWS) {
            self.finish()?;
        }
        self.latest.push(record);
        self.count += 1;
        Ok(())
    }

    /// Puts away what is left, once all are there.
    pub(super) fn finish(&mut self) -> Result<(), ScratchError> {
        if let Some(last) = self.latest.last() {
            self.shelves.put(((self.row(last) / ROWS) as u32, 0), &self.latest)?;
            self.latest.clear();
        }
        Ok(())
    }

    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Those of some rows, by rows.
    pub(super) fn of(&self, rows: Range<i64>) -> Result<Vec<[u64; N]>, ScratchError> {
        let mut records = Vec::new();
        let rows = rows.start.max(0)..rows.end.max(0);
        for list in rows.start / ROWS..(rows.end + ROWS - 1) / ROWS {
            self.shelves.get((list as u32, 0), &mut records)?;
        }
        records.retain(|record| rows.contains(&self.row(record)));
        Ok(records)
    }

    /// From the first of the rows on, as many as have a number of records, but no fewer than are in one list.
    pub(super) fn some(&self, rows: Range<i64>, most: usize) -> Range<i64> {
        let (mut end, mut count) = ((rows.start / ROWS + 1) * ROWS, 0);
        count += self.shelves.count(((rows.start / ROWS) as u32, 0));
        while end < rows.end {
            count += self.shelves.count(((end / ROWS) as u32, 0));
            if count > most {
                break;
            }
            end += ROWS;
        }
        rows.start..end.min(rows.end)
    }

    /// Where temporary files are made.
    pub(super) fn scratch(&self) -> &Scratch {
        self.shelves.scratch()
    }
}
