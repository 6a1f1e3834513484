//! A mesh file that is written from front to back through one buffer.

use std::io::{Seek, SeekFrom, Write};
use std::path::Path;

use rayon::prelude::*;

use super::SinkError;
use crate::base::decimal::Decimal;
use crate::base::staged::StagedFile;

/// A staged file and the bytes that are not in it yet. Memory: one buffer of a megabyte; some two megabytes more where threads
/// make the bytes.
#[derive(Debug)]
pub(super) struct Output {
    staged: StagedFile,
    buffer: Vec<u8>,
    /// Bytes that threads make.
    parts: Vec<Vec<u8>>,
}

/// Bytes gathered before they are written.
const BUFFER: usize = 1 << 20;

/// Records of one length that are put at a time.
const AT_A_TIME: usize = 1 << 10;

/// How many parts are made side by side, and of how many items each: so few that all of it stays in the processor's cache.
const PARTS: usize = 16;
const ITEMS: usize = 1 << 11;

impl Output {
    /// At the beginning of `staged`.
    pub(super) fn new(staged: StagedFile) -> Output {
        Output { staged, buffer: Vec::with_capacity(BUFFER + (64 << 10)), parts: Vec::new() }
    }

    /// The final name.
    pub(super) fn path(&self) -> &Path {
        self.staged.path()
    }

    /// Takes what comes next. After every record, [`Output::drain`].
    pub(super) fn buffer(&mut self) -> &mut Vec<u8> {
        &mut self.buffer
    }

    /// Writes the buffer if it is full.
    ///
    /// # Errors
    /// [`SinkError`] if it cannot be written.
    pub(super) fn drain(&mut self) -> Result<(), SinkError> {
        if self.buffer.len() > BUFFER { self.flush() } else { Ok(()) }
    }

    /// Takes what `record` makes of each item, which is faster than one by one.
    ///
    /// # Errors
    /// [`SinkError`] if it cannot be written, or what `record` returns.
    pub(super) fn put_all<T, const N: usize>(
        &mut self,
        items: &[T],
        mut record: impl FnMut(&T) -> Result<[u8; N], SinkError>,
    ) -> Result<(), SinkError> {
        for items in items.chunks(AT_A_TIME) {
            let begin = self.buffer.len();
            self.buffer.resize(begin + N * items.len(), 0);
            for (place, item) in self.buffer[begin..].as_chunks_mut().0.iter_mut().zip(items) {
                *place = record(item)?;
            }
            self.drain()?;
        }
        Ok(())
    }

    /// Takes the bytes that `push` appends for each item, whose number it is told. The threads of the current pool make them,
    /// side by side; they are the same however many there are.
    ///
    /// # Errors
    /// [`SinkError`] if it cannot be written, or what `push` returns for the first item for which it fails.
    pub(super) fn put_side_by_side<T: Sync>(
        &mut self,
        items: &[T],
        push: impl Fn(&mut Vec<u8>, usize, &T) -> Result<(), SinkError> + Sync,
    ) -> Result<(), SinkError> {
        self.parts.resize_with(PARTS, Vec::new);
        for (first, items) in (0..).step_by(PARTS * ITEMS).zip(items.chunks(PARTS * ITEMS)) {
            let parts = items.par_chunks(ITEMS).zip(&mut self.parts).enumerate();
            let made = parts.map(|(part, (items, bytes))| {
                bytes.clear();
                let mut numbered = (first + part * ITEMS..).zip(items);
                numbered.try_for_each(|(number, item)| push(bytes, number, item))
            });
            let made: Vec<Result<(), SinkError>> = made.collect();
            for (part, made) in made.into_iter().enumerate() {
                made?;
                self.buffer.extend_from_slice(&self.parts[part]);
                self.drain()?;
            }
        }
        Ok(())
    }

    /// Writes other bytes in the place of some that have come.
    ///
    /// # Errors
    /// [`SinkError`] if they cannot be written.
    pub(super) fn replace(&mut self, offset: u64, bytes: &[u8]) -> Result<(), SinkError> {
        self.flush()?;
        let file = self.staged.file();
        let replaced = file.seek(SeekFrom::Start(offset)).and_then(|_| file.write_all(bytes));
        let replaced = replaced.and_then(|()| file.seek(SeekFrom::End(0)));
        replaced.map(|_| ()).map_err(|e| self.staged.write_error(e).into())
    }

    /// Writes what is left, and puts the file in place under its final name.
    ///
    /// # Errors
    /// [`SinkError`] if either fails; then there is no file.
    pub(super) fn commit(mut self) -> Result<(), SinkError> {
        self.flush()?;
        Ok(self.staged.commit()?)
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.staged.file().write_all(&self.buffer).map_err(|e| self.staged.write_error(e))?;
        self.buffer.clear();
        Ok(())
    }
}

/// A number in decimal digits.
pub(super) fn push_decimal(text: &mut Vec<u8>, number: u64) {
    text.extend_from_slice(itoa::Buffer::new().format(number).as_bytes());
}

/// Three numbers with blanks between them, each the shortest decimal that is read again as the same double.
pub(super) fn push_place(text: &mut Vec<u8>, [x, y, z]: [f64; 3]) {
    Decimal(x).push_to(text);
    text.push(b' ');
    Decimal(y).push_to(text);
    text.push(b' ');
    Decimal(z).push_to(text);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output(folder: &tempfile::TempDir) -> Output {
        Output::new(StagedFile::create(&folder.path().join("output"), false, &[]).expect("staged"))
    }

    #[test]
    fn parts_come_in_order_whatever_the_threads() {
        let items: Vec<usize> = (0..2 * PARTS * ITEMS + 3 * ITEMS + 7).map(|i| 7 * i).collect();
        let expected: String = items.iter().map(|item| format!("{} {item}\n", item / 7)).collect();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            let folder = crate::testing::folder();
            pool.install(|| {
                let mut output = output(&folder);
                let text = |text: &mut Vec<u8>, number, item: &usize| {
                    text.extend_from_slice(format!("{number} {item}\n").as_bytes());
                    Ok(())
                };
                output.put_side_by_side(&items, text).and_then(|()| output.commit()).expect("written");
            });
            let found = std::fs::read_to_string(folder.path().join("output")).expect("text");
            assert!(found == expected, "{threads} threads");
        }
    }

    #[test]
    fn the_first_failure_is_told() {
        let folder = crate::testing::folder();
        let items: Vec<usize> = (0..PARTS * ITEMS).collect();
        let failed = output(&folder).put_side_by_side(&items, |_, number, item| {
            match [3 * ITEMS + 5, 9 * ITEMS].contains(item) {
                true => Err(SinkError::Library { path: folder.path().to_path_buf(), message: number.to_string() }),
                false => Ok(()),
            }
        });
        assert!(failed.is_err_and(|error| error.to_string().ends_with(&(3 * ITEMS + 5).to_string())));
    }

    #[test]
    fn records_come_in_order() {
        let folder = crate::testing::folder();
        let items: Vec<u32> = (0..400_000).collect();
        let mut output = output(&folder);
        output.buffer().push(b'a');
        output.put_all(&items, |item| Ok(item.to_le_bytes())).expect("taken");
        assert!(output.buffer.capacity() <= BUFFER + (64 << 10));
        output.commit().expect("written");
        let found = std::fs::read(folder.path().join("output")).expect("a file");
        assert!(found[0] == b'a' && found[1..] == *bytemuck::cast_slice::<u32, u8>(&items));
    }

    #[test]
    fn decimals() {
        for number in [0, 1, 9, 10, 12_345, u64::MAX] {
            let mut text = Vec::new();
            push_decimal(&mut text, number);
            assert_eq!(String::from_utf8(text), Ok(number.to_string()));
        }
    }
}
