//! Lines of OBJ files: one after the other, and what each is.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// The most bytes of a line that is kept. Longer comments are cut.
pub(super) const LINE_LIMIT: usize = 1 << 20;

/// What the first comment of a file of terrabite's begins with.
const HEADER: &str = "# mesh of ";

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Vertex,
    Face,
    /// Blank, or a comment.
    Nothing,
    /// Something of a mesh that is not read.
    Unused,
    /// Something else.
    Unknown,
}

/// Statements that change nothing about vertices and triangles.
const UNUSED: &[&str] = &[
    "vt",
    "vn",
    "vp",
    "p",
    "l",
    "o",
    "g",
    "s",
    "mg",
    "usemtl",
    "usemap",
    "mtllib",
    "maplib",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
];

/// What a line is, by its first word.
pub(super) fn kind(line: &[u8]) -> Kind {
    let line = line.trim_ascii_start();
    let word = &line[..line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len())];
    match word {
        b"v" => Kind::Vertex,
        // The latter is an old name of the former.
        b"f" | b"fo" => Kind::Face,
        [] | [b'#', ..] => Kind::Nothing,
        _ if UNUSED.iter().any(|unused| unused.as_bytes() == word) => Kind::Unused,
        _ => Kind::Unknown,
    }
}

/// Whether a file that begins so is terrabite's.
pub(super) fn is_header(line: &[u8]) -> bool {
    line.starts_with(HEADER.as_bytes())
}

/// What such a first line tells: the counts of vertices and of triangles.
pub(super) fn counts(line: &str) -> Option<(u64, u64)> {
    let (vertices, triangles) = line.strip_prefix(HEADER)?.strip_suffix(" triangles")?.split_once(" vertices and ")?;
    Some((vertices.parse().ok()?, triangles.parse().ok()?))
}

/// The lines of a file, those that a backslash ends joined with the next ones.
pub(super) struct Lines<'a> {
    reader: BufReader<&'a File>,
    line: Vec<u8>,
    first: u64,
    read: u64,
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
        Lines { reader, line: Vec::new(), first: 0, read: 0, ended: true }
    }

    /// The number of the line that was read last, from 1; the first of joined ones.
    pub(super) fn number(&self) -> u64 {
        self.first
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
        let first = self.read + 1;
        loop {
            let room = (LINE_LIMIT - self.line.len()) as u64;
            let bytes = self.reader.by_ref().take(room).read_until(b'\n', &mut self.line).map_err(LineError::Io)?;
            if bytes == 0 && self.line.is_empty() {
                return Ok(false);
            }
            self.read += 1;
            self.first = first;
            self.ended = self.line.last() == Some(&b'\n');
            let is_comment = self.line.trim_ascii_start().first() == Some(&b'#');
            if !self.ended && self.line.len() == LINE_LIMIT {
                if !is_comment {
                    return Err(LineError::TooLong);
                }
                self.ended = self.skip().map_err(LineError::Io)?;
                return Ok(true);
            }
            if self.ended {
                self.line.pop();
                if self.line.last() == Some(&b'\r') {
                    self.line.pop();
                }
            }
            if is_comment || !self.ended || self.line.last() != Some(&b'\\') {
                return Ok(true);
            }
            *self.line.last_mut().expect("a backslash") = b' ';
        }
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
