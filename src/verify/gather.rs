//! Records that are joined where they meet: soon after each other, or else in a sort.

use std::iter::Peekable;
use std::marker::PhantomData;

use super::VerifyError;
use crate::base::external::{Scratch, Sorted, Sorter};

/// A record: a key, and what has been counted of it.
pub(super) type Counted = [u64; 2];

/// What records are about. No record's second word is 0.
pub(super) trait Key {
    /// Whether two records have one key. Those that have are next to each other when records are sorted.
    fn is_same(a: Counted, b: Counted) -> bool;

    /// Two records of one key as one. In any order and any groups the same comes out.
    fn join(a: Counted, b: Counted) -> Counted;

    /// A number that differs from key to key most often.
    fn hash(record: Counted) -> u64;
}

/// Takes records in any order, and gives them back in order, those of one key joined.
///
/// Memory use is constant: 16 bytes for each of the slots that a record waits in until another one comes that hashes to
/// the same, and the sort's. What neighbours have in common meets in the slots most often, and is sorted once.
#[derive(Debug)]
pub(super) struct Gather<'s, K> {
    /// Two words of 0 where there is none.
    slots: Vec<Counted>,
    sorter: Sorter<'s, 2>,
    /// Records that were joined to others.
    joined: u64,
    key: PhantomData<K>,
}

/// Multiplies bits into the high ones of a word.
pub(super) const MIX: u64 = 0x9e37_79b9_7f4a_7c15;

impl<'s, K: Key> Gather<'s, K> {
    /// With this number of slots, a power of two, and a sort of this number of bytes.
    pub(super) fn new(scratch: &'s Scratch, slots: usize, bytes: usize) -> Self {
        assert!(slots.is_power_of_two(), "{slots} slots");
        Gather { slots: vec![[0; 2]; slots], sorter: Sorter::new(scratch, bytes), joined: 0, key: PhantomData }
    }

    pub(super) fn push(&mut self, record: Counted) -> Result<(), VerifyError> {
        let mask = self.slots.len() as u64 - 1;
        let slot = &mut self.slots[(K::hash(record) >> 32 & mask) as usize];
        if slot[1] == 0 {
            *slot = record;
        } else if K::is_same(*slot, record) {
            *slot = K::join(*slot, record);
            self.joined += 1;
        } else {
            self.sorter.push(std::mem::replace(slot, record))?;
        }
        Ok(())
    }

    /// All records in order, and how many have been joined to others so far.
    pub(super) fn finish(mut self) -> Result<(Gathered<'s, K>, u64), VerifyError> {
        for record in self.slots.into_iter().filter(|record| record[1] != 0) {
            self.sorter.push(record)?;
        }
        Ok((Gathered { sorted: self.sorter.finish()?.peekable(), key: PhantomData }, self.joined))
    }
}

/// The records of a [`Gather`], one for each key, in ascending order.
#[derive(Debug)]
pub(super) struct Gathered<'s, K> {
    sorted: Peekable<Sorted<'s, 2>>,
    key: PhantomData<K>,
}

impl<K: Key> Gathered<'_, K> {
    /// The next record, and how many of those that were sorted it is made of.
    pub(super) fn next(&mut self) -> Result<Option<(Counted, u64)>, VerifyError> {
        let Some(first) = self.sorted.next() else { return Ok(None) };
        let (mut record, mut count) = (first?, 1);
        while let Some(same) = self.sorted.next_if(|r| r.as_ref().map_or(true, |r| K::is_same(record, *r))) {
            record = K::join(record, same?);
            count += 1;
        }
        Ok(Some((record, count)))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    use super::*;

    struct Sum;

    impl Key for Sum {
        fn is_same(a: Counted, b: Counted) -> bool {
            a[0] == b[0]
        }

        fn join(a: Counted, b: Counted) -> Counted {
            [a[0], a[1] + b[1]]
        }

        fn hash(record: Counted) -> u64 {
            record[0].wrapping_mul(MIX)
        }
    }

    proptest! {
        #[test]
        fn what_is_gathered_is_what_a_map_says(
            records in proptest::collection::vec((0u64..60, 1u64..9), 0..600), slots in 0u32..6, bytes in 1usize..4000,
        ) {
            let scratch = Scratch::new(None, Default::default());
            let mut gather = Gather::<Sum>::new(&scratch, 1 << slots, bytes);
            let mut map = BTreeMap::new();
            for &(key, count) in &records {
                gather.push([key, count]).unwrap();
                *map.entry(key).or_insert(0) += count;
            }
            let (mut gathered, mut passed) = gather.finish().unwrap();
            let mut found = Vec::new();
            while let Some(([key, count], sorted)) = gathered.next().unwrap() {
                passed += sorted;
                found.push((key, count));
            }
            prop_assert_eq!(found, map.into_iter().collect::<Vec<_>>());
            prop_assert_eq!(passed, records.len() as u64);
        }
    }
}
