//! The heights of the finest grid in a temporary file, or one that is kept: square blocks one after the other, then their outlines, read by the call,
//! never mapped, so that none of it counts as this process's memory.

use std::fs::File;
use std::ops::Range;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::error::PyramidError;
use super::outline::{self, Outline};
use crate::base::control::{Control, Stage};
use crate::base::faults::{self, Point};
use crate::field::FieldError;

/// Samples along a side of a block.
pub(super) const BLOCK: usize = 64;

/// Samples of a block.
pub(super) const SAMPLES: usize = BLOCK * BLOCK;

/// Blocks that one thread fills one after the other: neighbours share what the raster is read by.
const RUN: usize = 8;

/// Heights in blocks, each with a checksum, which is compared whenever a block is read whole: all samples of a tile are while it is
/// measured. NaN where there is none, infinite in marked voids.
pub(crate) struct Store {
    file: File,
    folder: PathBuf,
    /// Blocks across and down.
    size: (usize, usize),
    /// The blocks that have any height: only those are in the file. A byte for every block.
    filled: Vec<bool>,
    /// The checksum of every block that is in the file, as it was written.
    sums: Vec<u32>,
    /// No other store of this process has it.
    id: u64,
}

impl Store {
    /// Makes a store of so many blocks across and down, with the threads of the current rayon pool. `fill` is given a block's
    /// column and row, and its heights, all NaN; it says whether the block has any height. `scratch` makes what a thread keeps
    /// from block to block.
    pub(super) fn make<S>(
        size: (usize, usize),
        (file, folder): (File, &Path),
        scratch: impl Fn() -> Result<S, PyramidError> + Sync,
        fill: impl Fn(&mut S, (usize, usize), &mut [f64]) -> Result<bool, PyramidError> + Sync,
        control: &Control<'_>,
    ) -> Result<Store, PyramidError> {
        let mut store =
            Store { file, folder: folder.to_path_buf(), size, filled: Vec::new(), sums: Vec::new(), id: new_id() };
        let total = size.0 * size.1;
        control.progress.begin(Stage::Decode, total.div_ceil(RUN) as u64, (total * SAMPLES) as u64);
        let run = |kept: &mut Option<(S, Vec<f64>)>, first: usize| {
            control.cancel.check()?;
            let (scratch, heights) = match kept {
                Some(kept) => kept,
                None => kept.insert((scratch()?, vec![0.0; SAMPLES])),
            };
            let block = |number: usize| {
                heights.fill(f64::NAN);
                faults::reach(Point::DecodeUnit);
                let is_filled = fill(scratch, (number % size.0, number / size.0), heights)?;
                if !is_filled {
                    return Ok((false, 0));
                }
                let bytes = bytemuck::cast_slice(heights);
                let at = (number * SAMPLES * size_of::<f64>()) as u64;
                store.file.write_all_at(bytes, at).map_err(|e| store.failed(e))?;
                let (outline, at) = (Outline::of(heights), outline_at(size, number));
                store.file.write_all_at(outline.bytes(), at).map_err(|e| store.failed(e))?;
                Ok((true, crc32fast::hash(bytes)))
            };
            let filled: Result<Vec<(bool, u32)>, PyramidError> = (first..(first + RUN).min(total)).map(block).collect();
            control.progress.step(Stage::Decode, (RUN * SAMPLES) as u64);
            filled
        };
        let runs: Vec<usize> = (0..total).step_by(RUN).collect();
        let filled: Result<Vec<Vec<(bool, u32)>>, PyramidError> = runs.into_par_iter().map_init(|| None, run).collect();
        (store.filled, store.sums) = filled?.concat().into_iter().unzip();
        control.progress.end(Stage::Decode);
        Ok(store)
    }

    /// A store that was made, in a file with a name: how many blocks follow one another that have no heights, that have some, and
    /// so on, as [`Store::runs`] tells, and checksums as of [`Store::sums`]. `None` where the file has another length.
    pub(super) fn open(
        size: (usize, usize),
        (file, folder): (File, &Path),
        (runs, sums): (&[u64], &[u32]),
    ) -> Result<Option<Store>, PyramidError> {
        let mut filled = Vec::with_capacity(size.0 * size.1);
        for (i, &run) in runs.iter().enumerate() {
            filled.resize(filled.len().saturating_add(run as usize).min(size.0 * size.1), i % 2 == 1);
        }
        let length = filled.iter().rposition(|&filled| filled).map_or(0, |last| outline_at(size, last + 1));
        let folder = folder.to_path_buf();
        let found = file.metadata().map_err(|source| PyramidError::File { path: folder.clone(), source })?.len();
        if found != length || filled.len() != size.0 * size.1 {
            return Ok(None);
        }
        let mut known = sums.iter().copied();
        let sums = filled.iter().map(|filled| if *filled { known.next() } else { Some(0) });
        let Some(sums) = sums.collect() else { return Ok(None) };
        Ok(Some(Store { file, folder, size, filled, sums, id: new_id() }))
    }

    /// Blocks across and down.
    pub(super) fn size(&self) -> (usize, usize) {
        self.size
    }

    /// See [`Store::open`].
    pub(super) fn runs(&self) -> Vec<u64> {
        let mut runs: Vec<u64> = self.filled.chunk_by(|a, b| a == b).map(|run| run.len() as u64).collect();
        if self.filled.first() == Some(&true) {
            runs.insert(0, 0);
        }
        runs
    }

    /// The checksums of the blocks that have heights.
    pub(super) fn sums(&self) -> Vec<u32> {
        self.sums.iter().zip(&self.filled).filter(|(_, filled)| **filled).map(|(sum, _)| *sum).collect()
    }

    /// The size that the file may have.
    pub(super) fn bytes(&self) -> u64 {
        bytes_of(self.size)
    }

    fn failed(&self, source: std::io::Error) -> PyramidError {
        FieldError::Temporary { dir: self.folder.clone(), bytes: self.bytes(), source }.into()
    }

    /// Whether a block has any height.
    pub(super) fn is_filled(&self, (column, row): (usize, usize)) -> bool {
        self.filled[row * self.size.0 + column]
    }

    /// The share of the blocks that have any height.
    #[cfg(test)]
    pub(super) fn share_filled(&self) -> f64 {
        self.filled.iter().filter(|&&filled| filled).count() as f64 / self.filled.len() as f64
    }

    /// The outline of a block that has heights.
    pub(super) fn outline(&self, block: (usize, usize)) -> Result<Outline, PyramidError> {
        let number = block.1 * self.size.0 + block.0;
        let mut bytes = [0; outline::BYTES as usize];
        self.file.read_exact_at(&mut bytes, outline_at(self.size, number)).map_err(|e| self.failed(e))?;
        Outline::read(&bytes).ok_or_else(|| PyramidError::Damaged { dir: self.folder.clone(), block: number as u64 })
    }

    /// Reads a block that has heights.
    fn read_whole(&self, block: (usize, usize), out: &mut [f64]) -> Result<(), PyramidError> {
        self.read(block, 0..SAMPLES, out)?;
        let number = block.1 * self.size.0 + block.0;
        match crc32fast::hash(bytemuck::cast_slice(out)) == self.sums[number] {
            true => Ok(()),
            false => Err(PyramidError::Damaged { dir: self.folder.clone(), block: number as u64 }),
        }
    }

    /// Reads samples of a block that has heights, some of them that follow one another row by row.
    fn read(&self, (column, row): (usize, usize), samples: Range<usize>, out: &mut [f64]) -> Result<(), PyramidError> {
        let at = ((row * self.size.0 + column) * SAMPLES + samples.start) * size_of::<f64>();
        let out = bytemuck::cast_slice_mut(&mut out[..samples.len()]);
        self.file.read_exact_at(out, at as u64).map_err(|e| self.failed(e))
    }
}

fn new_id() -> u64 {
    static STORES: AtomicU64 = AtomicU64::new(1);
    STORES.fetch_add(1, Ordering::Relaxed)
}

/// A file without a name for a store of so many blocks.
pub(super) fn temporary(folder: &Path) -> Result<File, PyramidError> {
    let failed = |source| FieldError::Temporary { dir: folder.to_path_buf(), bytes: 0, source };
    Ok(tempfile::tempfile_in(folder).map_err(failed)?)
}

fn bytes_of(size: (usize, usize)) -> u64 {
    let each = (SAMPLES * size_of::<f64>()) as u64 + outline::BYTES;
    (size.0 as u64).saturating_mul(size.1 as u64).saturating_mul(each)
}

/// Where the outline of a block is in the file: behind all blocks.
fn outline_at(size: (usize, usize), number: usize) -> u64 {
    (size.0 * size.1 * SAMPLES * size_of::<f64>()) as u64 + number as u64 * outline::BYTES
}

/// Blocks kept along each side of a square of them.
const KEPT: usize = 8;

/// What they take.
pub(super) const CACHE_BYTES: u64 = (KEPT * KEPT * SAMPLES * size_of::<f64>()) as u64;

/// Blocks that have been read, the last at each place of a square: two megabytes.
#[derive(Default)]
pub(super) struct Cache {
    slots: Vec<Slot>,
    one: [f64; 1],
}

struct Slot {
    store: u64,
    block: (usize, usize),
    heights: Vec<f64>,
    is_whole: bool,
}

impl Cache {
    fn slot(&mut self, block: (usize, usize)) -> &mut Slot {
        if self.slots.is_empty() {
            let empty = || Slot { store: 0, block: (0, 0), heights: Vec::new(), is_whole: false };
            self.slots.resize_with(KEPT * KEPT, empty);
        }
        &mut self.slots[block.0 % KEPT + block.1 % KEPT * KEPT]
    }

    /// The heights of a block that has any, and whether all of its samples have one.
    pub(super) fn block(&mut self, store: &Store, block: (usize, usize)) -> Result<(&[f64], bool), PyramidError> {
        let slot = self.slot(block);
        if (slot.store, slot.block) != (store.id, block) {
            // Should reading fail, there is nothing in the slot.
            slot.store = 0;
            slot.heights.resize(SAMPLES, 0.0);
            store.read_whole(block, &mut slot.heights)?;
            slot.is_whole = slot.heights.iter().fold(true, |all, height| all & height.is_finite());
            (slot.store, slot.block) = (store.id, block);
        }
        Ok((&slot.heights, slot.is_whole))
    }

    /// One height of a block that has any: no other of the block is wanted.
    pub(super) fn one(&mut self, store: &Store, block: (usize, usize), at: usize) -> Result<f64, PyramidError> {
        let slot = self.slot(block);
        if (slot.store, slot.block) == (store.id, block) {
            return Ok(slot.heights[at]);
        }
        store.read(block, at..at + 1, &mut self.one)?;
        Ok(self.one[0])
    }
}
