//! A temporary file of bytes that is appended to, and read anywhere.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};

use crate::base::external::{Scratch, ScratchError};

/// Bytes gathered before they are written.
const BUFFER: usize = 1 << 20;

/// Memory: one buffer of a megabyte. The file is made with the first bytes that are written to it.
#[derive(Debug, Default)]
pub(super) struct Spool {
    file: Option<File>,
    filed: u64,
    buffer: Vec<u8>,
}

impl Spool {
    /// Bytes in all.
    pub(super) fn length(&self) -> u64 {
        self.filed + self.buffer.len() as u64
    }

    /// Takes what comes next. After every record, [`Spool::drain`].
    pub(super) fn buffer(&mut self) -> &mut Vec<u8> {
        &mut self.buffer
    }

    /// Writes the buffer if it is full.
    pub(super) fn drain(&mut self, scratch: &Scratch) -> Result<(), ScratchError> {
        if self.buffer.len() > BUFFER { self.flush(scratch) } else { Ok(()) }
    }

    /// Writes what is left; to be called before [`Spool::read`].
    pub(super) fn flush(&mut self, scratch: &Scratch) -> Result<(), ScratchError> {
        let mut file = match self.file.take() {
            Some(file) => file,
            None => scratch.file()?,
        };
        let end = SeekFrom::Start(self.filed);
        file.seek(end).and_then(|_| file.write_all(&self.buffer)).map_err(|e| scratch.error(e))?;
        self.filed += self.buffer.len() as u64;
        self.buffer.clear();
        self.file = Some(file);
        Ok(())
    }

    /// Reads as many bytes as the buffer has, from `offset` on.
    pub(super) fn read(&mut self, scratch: &Scratch, offset: u64, bytes: &mut [u8]) -> Result<(), ScratchError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        file.seek(SeekFrom::Start(offset)).and_then(|_| file.read_exact(bytes)).map_err(|e| scratch.error(e))
    }
}
