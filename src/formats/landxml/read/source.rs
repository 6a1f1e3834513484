//! The bytes of an XML file, as the parser gets them: as UTF-8, and not too many at a time.

use std::fs::File;
use std::io::{self, BufRead, Read};

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// The most bytes of a tag or a text.
pub(super) const EVENT_LIMIT: usize = 16 << 20;

/// Bytes in which the declaration of an encoding is looked for.
const DECLARATION_BYTES: usize = 200;

/// Reads a file through one buffer. Where another encoding than UTF-8 is declared, bytes beyond ASCII are question marks.
#[derive(Debug)]
pub(super) struct Source<'a> {
    file: &'a File,
    buffer: Vec<u8>,
    /// The bytes of the buffer that are still to come.
    rest: std::ops::Range<usize>,
    /// Whether bytes beyond ASCII are those of UTF-8; `None` before the first bytes.
    is_utf8: Option<bool>,
    allowed: usize,
}

impl<'a> Source<'a> {
    /// From where the file stands.
    pub(super) fn new(file: &'a File) -> Source<'a> {
        Source { file, buffer: vec![0; BUFFER_BYTES], rest: 0..0, is_utf8: None, allowed: EVENT_LIMIT }
    }

    /// Before the parser reads the next tag or text.
    pub(super) fn allow_an_event(&mut self) {
        self.allowed = EVENT_LIMIT;
    }

    /// Whether the last tag or text was too long.
    pub(super) fn is_exhausted(&self) -> bool {
        self.allowed == 0
    }

    fn refill(&mut self) -> io::Result<()> {
        let mut read = 0;
        // The beginning is looked at as a whole.
        while read < DECLARATION_BYTES {
            match self.file.read(&mut self.buffer[read..]) {
                Ok(0) => break,
                Ok(bytes) => read += bytes,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        self.rest = 0..read;
        let bytes = &mut self.buffer[..read];
        let is_utf8 = *self.is_utf8.get_or_insert_with(|| declares_utf8(bytes));
        if !is_utf8 {
            bytes.iter_mut().filter(|byte| !byte.is_ascii()).for_each(|byte| *byte = b'?');
        }
        Ok(())
    }
}

impl BufRead for Source<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.allowed == 0 {
            return Err(io::Error::other("too long"));
        }
        if self.rest.is_empty() {
            self.refill()?;
        }
        let end = self.rest.end.min(self.rest.start + self.allowed);
        Ok(&self.buffer[self.rest.start..end])
    }

    fn consume(&mut self, bytes: usize) {
        self.rest.start += bytes;
        self.allowed -= bytes;
    }
}

impl Read for Source<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let bytes = self.fill_buf()?.read(into)?;
        self.consume(bytes);
        Ok(bytes)
    }
}

/// Whether a file that begins so is in UTF-8, or says nothing about it.
fn declares_utf8(beginning: &[u8]) -> bool {
    let beginning = String::from_utf8_lossy(&beginning[..beginning.len().min(DECLARATION_BYTES)]).to_ascii_lowercase();
    let declaration = beginning.split("?>").next().unwrap_or_default();
    match declaration.split_once("encoding") {
        Some((_, encoding)) if beginning.trim_start_matches('\u{feff}').starts_with("<?xml") => {
            encoding.contains("utf-8")
        }
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings() {
        for (text, expected) in [
            ("<?xml version='1.0' encoding='UTF-8'?><a/>", true),
            ("\u{feff}<?xml version=\"1.0\" encoding=\"utf-8\" ?>", true),
            ("<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?><a b=\"utf-8\"/>", false),
            ("<?xml version=\"1.0\"?><a encoding=\"latin\"/>", true),
            ("<a encoding=\"latin\"/>", true),
            ("", true),
        ] {
            assert_eq!(declares_utf8(text.as_bytes()), expected, "{text}");
        }
    }
}
