//! Filled voids on disk, found again by window.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use super::Bridged;
use super::components::Hole;
use crate::base::Window;
use crate::field::FieldError;

/// Samples along a side of the blocks that bridged samples are found by.
const BLOCK: u32 = 512;

/// Bytes that wait before they are written to the file. As many as that never need one.
const PENDING: usize = 1 << 20;

/// Bridged samples, by blocks of the field: an unlinked temporary file of records, each of what one hole has in one block.
///
/// A record is the place and length of the one before it of the same block, then runs: row, first column, count and so many
/// heights.
pub(super) struct Records {
    dir: PathBuf,
    file: Option<File>,
    written: u64,
    /// What follows what is written.
    pending: Vec<u8>,
    /// The last record of each block that has one, by row and column of blocks: place and length.
    heads: BTreeMap<(u32, u32), (u64, u32)>,
}

/// What a block with a record takes.
const HEAD_BYTES: u64 = 60;

impl std::fmt::Debug for Records {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Records").field("bytes", &self.written).field("blocks", &self.heads.len()).finish()
    }
}

impl Records {
    pub(super) fn new(dir: &Path) -> Records {
        Records { dir: dir.to_path_buf(), file: None, written: 0, pending: Vec::new(), heads: BTreeMap::new() }
    }

    /// The size of the file.
    pub(super) fn bytes(&self) -> u64 {
        self.written
    }

    pub(super) fn head_bytes(&self) -> u64 {
        self.heads.len() as u64 * HEAD_BYTES
    }

    fn failed(&self, source: io::Error) -> FieldError {
        FieldError::HolesFile { dir: self.dir.clone(), source }
    }

    /// Keeps a hole with the heights of its samples.
    pub(super) fn put(&mut self, hole: &Hole, heights: &[f64]) -> Result<(), FieldError> {
        let mut records: BTreeMap<(u32, u32), Vec<u8>> = BTreeMap::new();
        let mut heights = heights.iter();
        for &(row, first, last) in &hole.runs {
            let mut column = first;
            while column <= last {
                let block = (row / BLOCK, column / BLOCK);
                let end = last.min((block.1 + 1) * BLOCK - 1);
                let record = records.entry(block).or_insert_with(|| {
                    let (place, length) = self.heads.get(&block).copied().unwrap_or_default();
                    [&place.to_le_bytes()[..], &length.to_le_bytes()].concat()
                });
                let count = end - column + 1;
                [row, column, count].iter().for_each(|word| record.extend_from_slice(&word.to_le_bytes()));
                let ours = heights.by_ref().take(count as usize);
                ours.for_each(|height| record.extend_from_slice(&height.to_le_bytes()));
                column = end + 1;
            }
        }
        for (block, record) in records {
            let place = self.written + self.pending.len() as u64;
            self.heads.insert(block, (place, record.len() as u32));
            self.pending.extend_from_slice(&record);
        }
        if self.pending.len() > PENDING {
            self.flush().map_err(|source| self.failed(source))?;
        }
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        let file = match self.file.take() {
            Some(file) => file,
            None => tempfile::tempfile_in(&self.dir)?,
        };
        let file = self.file.insert(file);
        file.write_all_at(&self.pending, self.written)?;
        self.written += self.pending.len() as u64;
        self.pending.clear();
        Ok(())
    }

    fn read(&self, place: u64, length: u32, record: &mut Vec<u8>) -> io::Result<()> {
        record.clear();
        record.resize(length as usize, 0);
        match &self.file {
            Some(file) if place < self.written => file.read_exact_at(record, place),
            _ => {
                let start = (place - self.written) as usize;
                record.copy_from_slice(&self.pending[start..start + length as usize]);
                Ok(())
            }
        }
    }

    /// Adds the bridged samples of a window.
    pub(super) fn within(&self, window: Window, found: &mut Vec<Bridged>) -> Result<(), FieldError> {
        let mut bytes = Vec::new();
        let [left, right] = [window.column, window.column + window.width].map(|c| c as u32);
        let [top, bottom] = [window.row, window.row + window.height].map(|r| r as u32);
        for block_row in top / BLOCK..=(bottom - 1) / BLOCK {
            let blocks = (block_row, left / BLOCK)..=(block_row, (right - 1) / BLOCK);
            for &(mut place, mut length) in self.heads.range(blocks).map(|(_, head)| head) {
                while length > 0 {
                    self.read(place, length, &mut bytes).map_err(|source| self.failed(source))?;
                    let mut record = Reader(&bytes);
                    (place, length) = (record.u64(), record.u32());
                    while !record.0.is_empty() {
                        let (row, first, count) = (record.u32(), record.u32(), record.u32());
                        let samples = (first..first + count).map(|c| (c, f64::from_bits(record.u64())));
                        let inside = |column: u32| (left..right).contains(&column) && (top..bottom).contains(&row);
                        let samples = samples.filter(|&(column, _)| inside(column));
                        found.extend(samples.map(|(column, height)| Bridged { column, row, height }));
                    }
                }
            }
        }
        Ok(())
    }
}

/// Numbers from the front of a record.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk::<N>().expect("a record is as long as it says");
        self.0 = rest;
        *first
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }
}
