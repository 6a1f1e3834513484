//! External sorting of fixed-size records.
//!
//! Crates for this exist (`extsort`, `ext-sort`); they encode record by record, keep one named file per run and open
//! all of them at once. Here a record is a few machine words compared in order, all runs of a sort share one file
//! without a name, and no more than [`FAN_IN`] of them are merged at a time.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;
use std::fs::File;

use rayon::slice::ParallelSliceMut;

use super::{Scratch, ScratchError};

/// Runs merged at a time.
const FAN_IN: usize = 64;
/// Bytes read of one run at a time.
const READ_BYTES: usize = 64 << 10;

/// As arrays are compared; the loop is unrolled.
fn compare<const N: usize>(a: &[u64; N], b: &[u64; N]) -> Ordering {
    for word in 0..N {
        if a[word] != b[word] {
            return a[word].cmp(&b[word]);
        }
    }
    Ordering::Equal
}

/// Takes records of `N` words in any order and gives them back in ascending order, the first word first.
///
/// Memory use is constant: the buffer's `bytes` while records come in, then 64 × 64 KiB, because a full buffer is
/// sorted and written out as a run, and runs are merged 64 at a time, in several rounds where there are more. The
/// order depends on the records alone (records that compare equal are the same bytes).
#[derive(Debug)]
pub(crate) struct Sorter<'s, const N: usize> {
    scratch: &'s Scratch,
    capacity: usize,
    buffer: Vec<[u64; N]>,
    file: Option<File>,
    runs: Vec<Run>,
}

/// A sorted stretch of the file, in records.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: u64,
    count: u64,
}

impl<'s, const N: usize> Sorter<'s, N> {
    /// With a buffer of `bytes`.
    pub(crate) fn new(scratch: &'s Scratch, bytes: usize) -> Self {
        let capacity = (bytes / size_of::<[u64; N]>()).max(1);
        // All of it at once: growing by doubling would end up to twice as large. Untouched pages cost nothing.
        Sorter { scratch, capacity, buffer: Vec::with_capacity(capacity), file: None, runs: Vec::new() }
    }

    /// Takes a record.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn push(&mut self, record: [u64; N]) -> Result<(), ScratchError> {
        if self.buffer.len() == self.capacity {
            self.write_run()?;
        }
        self.buffer.push(record);
        Ok(())
    }

    fn write_run(&mut self) -> Result<(), ScratchError> {
        self.buffer.par_sort_unstable_by(compare);
        self.scratch.append(&mut self.file, &self.buffer)?;
        let first = self.runs.last().map_or(0, |r| r.first + r.count);
        self.runs.push(Run { first, count: self.buffer.len() as u64 });
        self.buffer.clear();
        Ok(())
    }

    /// All records in order. A set that fits the buffer never sees a file.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn finish(mut self) -> Result<Sorted<'s, N>, ScratchError> {
        if self.runs.is_empty() {
            self.buffer.par_sort_unstable_by(compare);
            return Ok(Sorted::Memory(self.buffer.into_iter()));
        }
        if !self.buffer.is_empty() {
            self.write_run()?;
        }
        self.buffer = Vec::new();
        let (mut file, mut runs) = (self.file.expect("there are runs"), self.runs);
        while runs.len() > FAN_IN {
            (file, runs) = merge_round::<N>(self.scratch, file, &runs)?;
        }
        Ok(Sorted::Merge(Merge::new(self.scratch, file, &runs)?))
    }
}

/// Merges runs by groups into fewer and longer runs in a new file.
fn merge_round<const N: usize>(scratch: &Scratch, file: File, runs: &[Run]) -> Result<(File, Vec<Run>), ScratchError> {
    let target = scratch.file()?;
    let mut longer = Vec::with_capacity(runs.len().div_ceil(FAN_IN));
    let mut out = Vec::with_capacity(READ_BYTES * 16 / size_of::<[u64; N]>());
    for group in runs.chunks(FAN_IN) {
        let again = file.try_clone().map_err(|e| scratch.error(e))?;
        for record in Merge::<N>::new(scratch, again, group)? {
            out.push(record?);
            if out.len() == out.capacity() {
                scratch.write(&target, &out)?;
                out.clear();
            }
        }
        scratch.write(&target, &out)?;
        out.clear();
        longer.push(Run { first: group[0].first, count: group.iter().map(|r| r.count).sum() });
    }
    Ok((target, longer))
}

/// The records of a [`Sorter`] in ascending order.
#[derive(Debug)]
pub(crate) enum Sorted<'s, const N: usize> {
    Memory(std::vec::IntoIter<[u64; N]>),
    Merge(Merge<'s, N>),
}

impl<const N: usize> Iterator for Sorted<'_, N> {
    type Item = Result<[u64; N], ScratchError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self {
            Sorted::Memory(records) => records.next().map(Ok),
            Sorted::Merge(merge) => merge.next(),
        }
    }
}

/// Several runs read side by side, the least record of their heads first.
#[derive(Debug)]
pub(crate) struct Merge<'s, const N: usize> {
    scratch: &'s Scratch,
    file: File,
    cursors: Vec<Cursor<N>>,
    heads: BinaryHeap<Reverse<Head<N>>>,
}

/// The next record of a run.
#[derive(Debug, Clone, Copy)]
struct Head<const N: usize> {
    record: [u64; N],
    run: usize,
}

impl<const N: usize> Ord for Head<N> {
    fn cmp(&self, other: &Self) -> Ordering {
        compare(&self.record, &other.record).then(self.run.cmp(&other.run))
    }
}

impl<const N: usize> PartialOrd for Head<N> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<const N: usize> PartialEq for Head<N> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<const N: usize> Eq for Head<N> {}

/// What is left of one run: some of it in memory, the rest in the file.
#[derive(Debug)]
struct Cursor<const N: usize> {
    rest: Run,
    buffer: Vec<[u64; N]>,
    next: usize,
}

impl<'s, const N: usize> Merge<'s, N> {
    fn new(scratch: &'s Scratch, file: File, runs: &[Run]) -> Result<Self, ScratchError> {
        let cursors = runs.iter().map(|&rest| Cursor { rest, buffer: Vec::new(), next: 0 }).collect();
        let mut merge = Merge { scratch, file, cursors, heads: BinaryHeap::new() };
        for run in 0..runs.len() {
            let first = merge.cursors[run].advance(merge.scratch, &merge.file)?;
            merge.heads.extend(first.map(|record| Reverse(Head { record, run })));
        }
        Ok(merge)
    }
}

impl<const N: usize> Cursor<N> {
    /// The run's next record.
    fn advance(&mut self, scratch: &Scratch, file: &File) -> Result<Option<[u64; N]>, ScratchError> {
        if self.next == self.buffer.len() {
            let count = self.rest.count.min((READ_BYTES / size_of::<[u64; N]>()) as u64);
            self.buffer.resize(count as usize, [0; N]);
            scratch.read(file, self.rest.first, &mut self.buffer)?;
            self.rest = Run { first: self.rest.first + count, count: self.rest.count - count };
            self.next = 0;
        }
        let record = self.buffer.get(self.next).copied();
        self.next += usize::from(record.is_some());
        Ok(record)
    }
}

impl<const N: usize> Iterator for Merge<'_, N> {
    type Item = Result<[u64; N], ScratchError>;

    fn next(&mut self) -> Option<Self::Item> {
        // The run's next record takes the place of its last one: it sinks from the top, which is less than a pop and a push.
        let mut head = self.heads.peek_mut()?;
        let Reverse(Head { record, run }) = *head;
        match self.cursors[run].advance(self.scratch, &self.file) {
            Ok(Some(next)) => *head = Reverse(Head { record: next, run }),
            Ok(None) => drop(PeekMut::pop(head)),
            Err(error) => return Some(Err(error)),
        }
        Some(Ok(record))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn sorts_as_a_vector_does(
            mut records in proptest::collection::vec(any::<[u64; 2]>(), 0..2000), capacity in 1usize..300,
        ) {
            let scratch = Scratch::new(None, Default::default());
            let mut sorter = Sorter::new(&scratch, capacity * 16);
            for record in &records {
                sorter.push(*record).unwrap();
            }
            let sorted: Vec<_> = sorter.finish().unwrap().collect::<Result<_, _>>().unwrap();
            records.sort_unstable();
            prop_assert_eq!(sorted, records);
        }
    }
}
