//! Lines of 2DM files: one after the other, and what each is.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// The most bytes of a line that is kept. Longer comments are cut.
pub(super) const LINE_LIMIT: usize = 1 << 20;

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `ND`.
    Node,
    /// `E3T`.
    Triangle,
    /// An element with another number of nodes.
    OtherElement,
    /// Of a comment.
    Comment,
    /// Blank.
    Nothing,
    /// `MESH2D`, with which a file begins.
    First,
    /// Something that is not read: strings of nodes, lines, materials, boundary conditions.
    Unused,
}

/// What a line is, by its first word.
pub(super) fn kind(line: &[u8]) -> Kind {
    match word(line) {
        [] => Kind::Nothing,
        [b'#', ..] => Kind::Comment,
        b"ND" => Kind::Node,
        b"E3T" => Kind::Triangle,
        // Lines of two and of three nodes have no face.
        b"E2L" | b"E3L" => Kind::Unused,
        [b'E', digit, ..] if digit.is_ascii_digit() => Kind::OtherElement,
        b"MESH2D" => Kind::First,
        _ => Kind::Unused,
    }
}

/// The first word of a line.
pub(super) fn word(line: &[u8]) -> &[u8] {
    let line = line.trim_ascii_start();
    &line[..line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len())]
}

/// What the second line of a file of terrabite's tells: the counts of nodes and of elements.
pub(super) fn counts(line: &str) -> Option<(u64, u64)> {
    let (nodes, elements) = line.strip_prefix("# mesh of ")?.strip_suffix(" elements")?.split_once(" nodes and ")?;
    Some((nodes.parse().ok()?, elements.parse().ok()?))
}

/// The lines of a file.
pub(super) struct Lines<'a> {
    reader: BufReader<&'a File>,
    line: Vec<u8>,
    number: u64,
    ended: bool,
}

/// Why there is no next line.
pub(super) enum LineError {
    Io(io::Error),
    TooLong,
}

impl<'a> Lines<'a> {
    /// From where the file stands.
    pub(super) fn new(file: &'a File) -> Lines<'a> {
        let reader = BufReader::with_capacity(BUFFER_BYTES, file);
        Lines { reader, line: Vec::new(), number: 0, ended: true }
    }

    /// The number of the line that was read last, from 1.
    pub(super) fn number(&self) -> u64 {
        self.number
    }

    /// Whether the line that was read last had an end.
    pub(super) fn ended(&self) -> bool {
        self.ended
    }

    /// The line that was read last, without its end.
    pub(super) fn line(&self) -> &[u8] {
        &self.line
    }

    /// Goes on to the next line; false if there is none. Of an overlong comment the beginning is kept.
    pub(super) fn advance(&mut self) -> Result<bool, LineError> {
        self.line.clear();
        let limited = self.reader.by_ref().take(LINE_LIMIT as u64).read_until(b'\n', &mut self.line);
        if limited.map_err(LineError::Io)? == 0 {
            return Ok(false);
        }
        self.number += 1;
        self.ended = self.line.last() == Some(&b'\n');
        if self.ended {
            self.line.pop();
            if self.line.last() == Some(&b'\r') {
                self.line.pop();
            }
        } else if self.line.len() == LINE_LIMIT {
            if kind(&self.line) != Kind::Comment {
                return Err(LineError::TooLong);
            }
            self.ended = self.skip().map_err(LineError::Io)?;
        }
        Ok(true)
    }

    /// Passes over the rest of a line; false if it has no end.
    fn skip(&mut self) -> io::Result<bool> {
        loop {
            let buffer = self.reader.fill_buf()?;
            if buffer.is_empty() {
                return Ok(false);
            }
            let end = buffer.iter().position(|b| *b == b'\n');
            let used = end.map_or(buffer.len(), |end| end + 1);
            self.reader.consume(used);
            if end.is_some() {
                return Ok(true);
            }
        }
    }
}
