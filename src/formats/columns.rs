//! A mesh file that is written in columns: stretches at known places, filled side by side.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use super::SinkError;
use crate::base::staged::StagedFile;

/// A staged file whose columns are filled in one pass, each through a buffer of its own. What no column covers is 0.
///
/// Memory: 8 MiB for all buffers, or 4 KiB for each column if that is more.
#[derive(Debug)]
pub(super) struct Columns {
    staged: StagedFile,
    columns: Vec<Stretch>,
    /// Bytes that a column gathers before they are written.
    buffer: usize,
}

/// One of the columns of a [`Columns`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Column(usize);

/// What is left of a column: the bytes that it has gathered, and where they go.
#[derive(Debug)]
struct Stretch {
    next: u64,
    end: u64,
    buffer: Vec<u8>,
}

/// Bytes of all buffers.
const BUFFERS: usize = 8 << 20;

/// The fewest and the most bytes of one buffer.
const BUFFER: (usize, usize) = (4 << 10, 1 << 20);

/// How many numbers are put at a time.
pub(super) const AT_A_TIME: usize = 4096;

impl Columns {
    /// Of `staged`, which is empty.
    pub(super) fn new(staged: StagedFile) -> Columns {
        Columns { staged, columns: Vec::new(), buffer: BUFFER.1 }
    }

    /// The final name.
    pub(super) fn path(&self) -> &Path {
        self.staged.path()
    }

    /// Writes the `head` of the file, and lays columns out: where each begins, and how many bytes it has. The file ends where
    /// the last of them does.
    ///
    /// # Errors
    /// [`SinkError`] if the head cannot be written, or the file cannot have this length.
    pub(super) fn lay_out(&mut self, head: &[u8], columns: &[(u64, u64)]) -> Result<Vec<Column>, SinkError> {
        self.buffer = (BUFFERS / columns.len().max(1)).clamp(BUFFER.0, BUFFER.1);
        let length = columns.iter().map(|(start, bytes)| start + bytes).max().unwrap_or(0).max(head.len() as u64);
        self.write_at(0, head)?;
        self.staged.file().set_len(length).map_err(|e| self.staged.write_error(e))?;
        let stretch = |&(next, bytes): &(u64, u64)| Stretch { next, end: next + bytes, buffer: Vec::new() };
        self.columns = columns.iter().map(stretch).collect();
        Ok((0..columns.len()).map(Column).collect())
    }

    /// Writes bytes that belong to no column, such as the length before one.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    pub(super) fn write_at(&mut self, place: u64, bytes: &[u8]) -> Result<(), SinkError> {
        let file = self.staged.file();
        let written = file.seek(SeekFrom::Start(place)).and_then(|_| file.write_all(bytes));
        Ok(written.map_err(|e| self.staged.write_error(e))?)
    }

    /// Takes what comes next in a column.
    ///
    /// # Errors
    /// [`SinkError`] if it cannot be written.
    ///
    /// # Panics
    /// If the column has no room for it, at the latest when it is written.
    #[inline]
    pub(super) fn put(&mut self, Column(column): Column, bytes: &[u8]) -> Result<(), SinkError> {
        let stretch = &mut self.columns[column];
        stretch.buffer.extend_from_slice(bytes);
        if stretch.buffer.len() >= self.buffer { self.flush(column) } else { Ok(()) }
    }

    /// Takes several numbers that come next in a column, which is faster than one by one. They stay in memory together:
    /// [`AT_A_TIME`] are enough.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    ///
    /// # Panics
    /// If the column has no room for them, at the latest when they are written.
    pub(super) fn put_all<const N: usize>(
        &mut self,
        Column(column): Column,
        numbers: impl ExactSizeIterator<Item = [u8; N]>,
    ) -> Result<(), SinkError> {
        let buffer = &mut self.columns[column].buffer;
        let begin = buffer.len();
        buffer.resize(begin + N * numbers.len(), 0);
        buffer[begin..].as_chunks_mut().0.iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
        if buffer.len() >= self.buffer { self.flush(column) } else { Ok(()) }
    }

    /// Writes what is left, and puts the file in place under its final name.
    ///
    /// # Errors
    /// [`SinkError`] if either fails; then there is no file.
    ///
    /// # Panics
    /// If a column is not full.
    pub(super) fn commit(mut self) -> Result<(), SinkError> {
        for column in 0..self.columns.len() {
            self.flush(column)?;
            let Stretch { next, end, .. } = self.columns[column];
            assert_eq!(next, end, "column {column} is not full");
        }
        Ok(self.staged.commit()?)
    }

    fn flush(&mut self, column: usize) -> Result<(), SinkError> {
        let mut buffer = std::mem::take(&mut self.columns[column].buffer);
        let Stretch { next, end, .. } = self.columns[column];
        let after = next + buffer.len() as u64;
        assert!(after <= end, "column {column} has no room");
        self.write_at(next, &buffer)?;
        buffer.clear();
        self.columns[column] = Stretch { next: after, end, buffer };
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(folder: &tempfile::TempDir) -> Columns {
        Columns::new(StagedFile::create(&folder.path().join("columns"), false, &[]).expect("staged"))
    }

    #[test]
    fn columns_are_filled_side_by_side() {
        let folder = crate::testing::folder();
        let mut file = columns(&folder);
        let long = 3 * BUFFER.1 as u64;
        let laid = file.lay_out(b"head", &[(5, 2), (8, long), (8 + long, 1)]).expect("laid out");
        for i in 0..long {
            match i % 2 {
                0 => file.put(laid[1], &[i as u8]).expect("taken"),
                _ => file.put_all(laid[1], [[i as u8]].into_iter()).expect("taken"),
            }
            if i == 77 {
                file.put(laid[2], b"z").expect("taken");
                file.put(laid[0], b"ab").expect("taken");
            }
        }
        assert!(file.columns.iter().all(|stretch| stretch.buffer.capacity() <= 2 * BUFFER.1));
        file.commit().expect("committed");
        let found = std::fs::read(folder.path().join("columns")).expect("a file");
        let mut expected = b"head\0ab\0".to_vec();
        expected.extend((0..long).map(|i| i as u8));
        expected.push(b'z');
        assert!(found == expected);
    }

    #[test]
    #[should_panic(expected = "column 1 is not full")]
    fn a_column_that_is_not_full_is_no_file() {
        let folder = crate::testing::folder();
        let mut file = columns(&folder);
        let laid = file.lay_out(b"", &[(0, 1), (1, 2)]).expect("laid out");
        file.put(laid[0], b"a").and_then(|()| file.put(laid[1], b"b")).expect("taken");
        let _ = file.commit();
    }

    #[test]
    #[should_panic(expected = "column 0 has no room")]
    fn a_column_is_not_written_beyond() {
        let folder = crate::testing::folder();
        let mut file = columns(&folder);
        let laid = file.lay_out(b"", &[(0, 1), (1, 2)]).expect("laid out");
        file.put(laid[0], b"ab").expect("taken");
        let _ = file.commit();
    }
}
