//! Blocks of samples in memory or mapped, and the runs of a window in them.

use std::fs::File;
use std::ops::Range;

use memmap2::Mmap;

use super::map::give_back;
use crate::base::Window;

/// Samples as bytes, in blocks of rows.
pub(super) struct Store {
    pub(super) bytes: Bytes,
    pub(super) block_width: usize,
    pub(super) block_height: usize,
    pub(super) blocks_across: usize,
    pub(super) offsets: Offsets,
    pub(super) sample_bytes: usize,
    /// Column and row of the first sample that is looked at, in the blocks.
    pub(super) first: (usize, usize),
}

/// Who holds the bytes.
pub(super) enum Bytes {
    /// The mapped file, and a handle that tells its length.
    Mapped(Mmap, File),
    Owned(Vec<u8>),
}

/// Where block number `i` (row by row) begins.
pub(super) enum Offsets {
    /// One after the other.
    Regular,
    /// As the file says.
    Table(Vec<u64>),
}

impl Store {
    fn bytes(&self) -> &[u8] {
        match &self.bytes {
            Bytes::Mapped(map, _) => map,
            Bytes::Owned(vec) => vec,
        }
    }

    /// The length the mapped file has now, if it is shorter than when it was mapped: (then, now).
    pub(super) fn truncated(&self) -> Option<(u64, u64)> {
        let Bytes::Mapped(map, file) = &self.bytes else { return None };
        let now = file.metadata().map_or(0, |m| m.len());
        (now < map.len() as u64).then_some((map.len() as u64, now))
    }

    fn block_offset(&self, index: usize) -> usize {
        match &self.offsets {
            Offsets::Regular => index * self.block_width * self.block_height * self.sample_bytes,
            Offsets::Table(table) => table[index] as usize,
        }
    }

    /// Calls `run(row, column, bytes)` for every run of samples of the window that lies together in a block; rows and
    /// columns are counted from the window's corner. Blocks are visited one after the other. Mapped pages are given
    /// back every [`RUNS_KEPT`] runs, so that what stays resident does not grow with the window.
    pub(super) fn for_each_run<E>(
        &self,
        window: Window,
        mut run: impl FnMut(usize, usize, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let window = Window { column: window.column + self.first.0, row: window.row + self.first.1, ..window };
        let (right, bottom) = (window.column + window.width, window.row + window.height);
        let bytes = self.bytes();
        let mut touched = Touched::default();
        for block_row in window.row / self.block_height..bottom.div_ceil(self.block_height) {
            for block_column in window.column / self.block_width..right.div_ceil(self.block_width) {
                let start = self.block_offset(block_row * self.blocks_across + block_column);
                let (left, top) = (block_column * self.block_width, block_row * self.block_height);
                let columns = left.max(window.column)..(left + self.block_width).min(right);
                for row in top.max(window.row)..(top + self.block_height).min(bottom) {
                    let first = start + ((row - top) * self.block_width + columns.start - left) * self.sample_bytes;
                    let run_bytes = first..first + columns.len() * self.sample_bytes;
                    run(row - window.row, columns.start - window.column, &bytes[run_bytes.clone()])?;
                    touched.add(run_bytes);
                    if touched.runs == RUNS_KEPT {
                        self.give_back(&mut touched);
                    }
                }
            }
        }
        self.give_back(&mut touched);
        Ok(())
    }

    fn give_back(&self, touched: &mut Touched) {
        if let Bytes::Mapped(map, _) = &self.bytes
            && touched.runs > 0
        {
            give_back(map, touched.bytes.clone());
        }
        *touched = Touched::default();
    }
}

/// Runs copied before their pages are given back. The kernel maps up to 16 pages around a fault, so this is 8 MiB of
/// short runs at most.
const RUNS_KEPT: usize = 128;

/// The stretch of the map that has been read.
#[derive(Default)]
struct Touched {
    bytes: Range<usize>,
    runs: usize,
}

impl Touched {
    fn add(&mut self, run: Range<usize>) {
        self.bytes = match self.runs {
            0 => run,
            _ => self.bytes.start.min(run.start)..self.bytes.end.max(run.end),
        };
        self.runs += 1;
    }
}
