//! A mesh file that is written from front to back through one buffer.

use std::io::Write;
use std::path::Path;

use super::SinkError;
use crate::base::staged::StagedFile;

/// A staged file and the bytes that are not in it yet. Memory: one buffer of a megabyte.
#[derive(Debug)]
pub(super) struct Output {
    staged: StagedFile,
    buffer: Vec<u8>,
}

/// Bytes gathered before they are written.
const BUFFER: usize = 1 << 20;

impl Output {
    /// At the beginning of `staged`.
    pub(super) fn new(staged: StagedFile) -> Output {
        Output { staged, buffer: Vec::with_capacity(BUFFER + 4096) }
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

/// A number in decimal digits. The formatting of the standard library takes three times as long.
pub(super) fn push_decimal(buffer: &mut Vec<u8>, mut number: u64) {
    let mut digits = [0; 20];
    let mut first = digits.len();
    loop {
        first -= 1;
        digits[first] = b'0' + (number % 10) as u8;
        number /= 10;
        if number == 0 {
            break;
        }
    }
    buffer.extend_from_slice(&digits[first..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimals() {
        for number in [0, 1, 9, 10, 12_345, u64::MAX] {
            let mut text = Vec::new();
            push_decimal(&mut text, number);
            assert_eq!(String::from_utf8(text), Ok(number.to_string()));
        }
    }
}
