//! Lists of records that are put away whole and fetched by number, in any order and from any thread.

use std::collections::BTreeMap;
use std::fs::File;
use std::os::unix::fs::FileExt;

use super::{Scratch, ScratchError};

/// Where a list is: by columns in rows of shelves.
pub(crate) type Shelf = (u32, u32);

/// Lists of records of `N` words. Those that were put away last wait in memory, the others are in a temporary file.
///
/// Memory: `bytes` of records, and some 60 for each list that is not empty.
#[derive(Debug)]
pub(crate) struct Shelves<const N: usize> {
    scratch: Scratch,
    capacity: usize,
    /// The number of each list's first record, and how many it has.
    lists: BTreeMap<Shelf, (u64, usize)>,
    file: Option<File>,
    filed: u64,
    latest: Vec<[u64; N]>,
}

impl<const N: usize> Shelves<N> {
    /// Empty ones, which keep up to `bytes` bytes of records in memory.
    pub(crate) fn new(scratch: Scratch, bytes: usize) -> Self {
        let capacity = bytes / size_of::<[u64; N]>();
        Shelves { scratch, capacity, lists: BTreeMap::new(), file: None, filed: 0, latest: Vec::new() }
    }

    /// Puts a list away, in the place of what is on the shelf.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn put(&mut self, shelf: Shelf, records: &[[u64; N]]) -> Result<(), ScratchError> {
        if records.is_empty() {
            self.lists.remove(&shelf);
            return Ok(());
        }
        if self.latest.len() + records.len() > self.capacity {
            self.scratch.append(&mut self.file, &self.latest)?;
            self.filed += self.latest.len() as u64;
            self.latest.clear();
        }
        self.lists.insert(shelf, (self.filed + self.latest.len() as u64, records.len()));
        self.latest.extend_from_slice(records);
        Ok(())
    }

    /// Adds what is on a shelf to these records.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn get(&self, shelf: Shelf, records: &mut Vec<[u64; N]>) -> Result<(), ScratchError> {
        let Some(&(first, count)) = self.lists.get(&shelf) else { return Ok(()) };
        if first >= self.filed {
            let first = (first - self.filed) as usize;
            records.extend_from_slice(&self.latest[first..first + count]);
            return Ok(());
        }
        let before = records.len();
        records.resize(before + count, [0; N]);
        let bytes = bytemuck::cast_slice_mut(records[before..].as_flattened_mut());
        let file = self.file.as_ref().expect("records were filed");
        file.read_exact_at(bytes, first * size_of::<[u64; N]>() as u64).map_err(|error| self.scratch.error(error))
    }

    /// The shelves of a row that are not empty.
    pub(crate) fn row(&self, row: u32) -> impl Iterator<Item = Shelf> {
        self.lists.range((row, 0)..=(row, u32::MAX)).map(|(shelf, _)| *shelf)
    }

    /// How many records are on a shelf.
    pub(crate) fn count(&self, shelf: Shelf) -> usize {
        self.lists.get(&shelf).map_or(0, |(_, count)| *count)
    }

    /// Where temporary files are made.
    pub(crate) fn scratch(&self) -> &Scratch {
        &self.scratch
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn lists_are_what_was_put_away_last(
            lists in proptest::collection::vec((0..4u32, 0..3u32, proptest::collection::vec(any::<[u64; 3]>(), 0..9)), 0..30),
            bytes in prop_oneof![Just(0usize), Just(200), Just(1 << 20)],
        ) {
            let mut shelves = Shelves::new(Scratch::new(None, Default::default()), bytes);
            let mut expected = BTreeMap::new();
            for (row, column, records) in lists {
                shelves.put((row, column), &records).unwrap();
                expected.insert((row, column), records);
            }
            for row in 0..4 {
                let there: Vec<Shelf> = shelves.row(row).collect();
                for column in 0..3 {
                    let mut found = vec![[7; 3]];
                    shelves.get((row, column), &mut found).unwrap();
                    let list = expected.remove(&(row, column)).unwrap_or_default();
                    prop_assert_eq!(shelves.count((row, column)), list.len());
                    prop_assert_eq!(there.contains(&(row, column)), !list.is_empty());
                    prop_assert_eq!(&found[1..], list.as_slice());
                }
            }
        }
    }
}
