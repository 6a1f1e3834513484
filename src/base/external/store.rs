//! Records on disk, found by number.

use std::fs::File;

use super::{Scratch, ScratchError};

/// Slots of the cache.
const SLOTS: u64 = 8192;

/// Records of a block: what is read at once.
const BLOCK: u64 = 64;

/// Records of `N` words by number, in a temporary file behind a cache.
///
/// Memory use is constant: 8192 blocks of 64 records (12 MiB with three words), because every block has one slot it may be
/// in. Records near each other in the file are served from memory; in random order each costs a read, which is slow but never
/// wrong.
#[derive(Debug)]
pub(crate) struct Store<'s, const N: usize> {
    scratch: &'s Scratch,
    file: File,
    count: u64,
    slots: Vec<Slot<N>>,
}

#[derive(Debug, Clone, Default)]
struct Slot<const N: usize> {
    /// The block's number plus one; 0 is empty.
    tag: u64,
    records: Vec<[u64; N]>,
}

/// Fills a [`Store`], one record after the other.
#[derive(Debug)]
pub(crate) struct StoreWriter<'s, const N: usize> {
    scratch: &'s Scratch,
    file: File,
    count: u64,
    buffer: Vec<[u64; N]>,
}

impl<'s, const N: usize> StoreWriter<'s, N> {
    /// An empty one.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn new(scratch: &'s Scratch) -> Result<Self, ScratchError> {
        Ok(StoreWriter { scratch, file: scratch.file()?, count: 0, buffer: Vec::new() })
    }

    /// Takes the next record.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn push(&mut self, record: [u64; N]) -> Result<(), ScratchError> {
        self.buffer.push(record);
        self.count += 1;
        if self.buffer.len() == 64 * BLOCK as usize {
            self.scratch.write(&self.file, &self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
    }

    /// The records, once all are there.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(crate) fn finish(self) -> Result<Store<'s, N>, ScratchError> {
        self.scratch.write(&self.file, &self.buffer)?;
        let slots = vec![Slot::default(); SLOTS as usize];
        Ok(Store { scratch: self.scratch, file: self.file, count: self.count, slots })
    }
}

impl<const N: usize> Store<'_, N> {
    /// How many there are.
    pub(crate) fn count(&self) -> u64 {
        self.count
    }

    /// A record.
    ///
    /// # Errors
    /// [`ScratchError`].
    ///
    /// # Panics
    /// If there is no such record: whoever reads numbers checks them.
    pub(crate) fn get(&mut self, index: u64) -> Result<[u64; N], ScratchError> {
        assert!(index < self.count, "record {index} of {}", self.count);
        let block = index / BLOCK;
        let slot = &mut self.slots[(block % SLOTS) as usize];
        if slot.tag != block + 1 {
            let first = block * BLOCK;
            // Empty while it is read: an error must not leave a half-read block behind.
            slot.tag = 0;
            slot.records.resize(BLOCK.min(self.count - first) as usize, [0; N]);
            self.scratch.read(&self.file, first, &mut slot.records)?;
            slot.tag = block + 1;
        }
        Ok(slot.records[(index % BLOCK) as usize])
    }
}
