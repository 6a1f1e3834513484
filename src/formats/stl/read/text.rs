//! STL as text: a statement a line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::StlError;

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// The most bytes of a line.
const LINE_LIMIT: usize = 64 << 10;

/// Whether a file that begins so could be a text.
pub(super) fn is_text(beginning: &[u8]) -> bool {
    let beginning = beginning.trim_ascii_start();
    let (word, rest) = beginning.split_at(beginning.len().min(5));
    word.eq_ignore_ascii_case(b"solid") && rest.first().is_none_or(u8::is_ascii_whitespace)
}

/// The triangles of a text, one after the other.
#[derive(Debug)]
pub(super) struct TextTriangles<'a> {
    path: &'a Path,
    reader: BufReader<&'a File>,
    line: Vec<u8>,
    number: u64,
    in_solid: bool,
    solids: u64,
}

impl<'a> TextTriangles<'a> {
    /// From where the file stands.
    pub(super) fn new(path: &'a Path, file: &'a File) -> TextTriangles<'a> {
        let reader = BufReader::with_capacity(BUFFER_BYTES, file);
        TextTriangles { path, reader, line: Vec::new(), number: 0, in_solid: false, solids: 0 }
    }

    /// The corners of the next triangle; `None` after the last one.
    pub(super) fn next(&mut self) -> Result<Option<[[f64; 3]; 3]>, StlError> {
        loop {
            match (self.advance()?, self.in_solid) {
                (false, false) if self.solids > 0 => return Ok(None),
                (false, false) => return Err(self.truncated("solid")),
                (false, true) => return Err(self.truncated("facet or endsolid")),
                (true, false) => {
                    self.expect("solid", "solid and a name")?;
                    self.in_solid = true;
                    self.solids += 1;
                }
                (true, true) if self.is("endsolid") => self.in_solid = false,
                (true, true) => return self.facet().map(Some),
            }
        }
    }

    /// A facet, whose first line has been read.
    fn facet(&mut self) -> Result<[[f64; 3]; 3], StlError> {
        self.expect("facet", "facet or endsolid")?;
        self.expect_next("outer", "outer loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            self.expect_next("vertex", "vertex and three numbers")?;
            *corner = vertex(&self.line).ok_or_else(|| self.wrong("vertex and three numbers"))?;
        }
        self.expect_next("endloop", "endloop after three vertices")?;
        self.expect_next("endfacet", "endfacet")?;
        Ok(corners)
    }

    /// Goes on to the next line that is not blank; false if there is none.
    fn advance(&mut self) -> Result<bool, StlError> {
        loop {
            self.line.clear();
            let mut limited = self.reader.by_ref().take(LINE_LIMIT as u64 + 1);
            let read = limited.read_until(b'\n', &mut self.line);
            let read = read.map_err(|source| StlError::Io { path: self.path.to_path_buf(), source })?;
            if read == 0 {
                return Ok(false);
            }
            self.number += 1;
            if read > LINE_LIMIT {
                let (path, line) = (self.path.to_path_buf(), self.number);
                return Err(StlError::LineTooLong { path, line, limit: LINE_LIMIT });
            }
            if !self.line.trim_ascii().is_empty() {
                return Ok(true);
            }
        }
    }

    /// Whether the first word of the line is this one.
    fn is(&self, word: &str) -> bool {
        let line = self.line.trim_ascii_start();
        let end = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
        line[..end].eq_ignore_ascii_case(word.as_bytes())
    }

    fn expect(&self, word: &str, expected: &'static str) -> Result<(), StlError> {
        if self.is(word) { Ok(()) } else { Err(self.wrong(expected)) }
    }

    fn expect_next(&mut self, word: &str, expected: &'static str) -> Result<(), StlError> {
        if self.advance()? { self.expect(word, expected) } else { Err(self.truncated(expected)) }
    }

    fn wrong(&self, expected: &'static str) -> StlError {
        let line = &self.line[..self.line.len().min(400)];
        let found = String::from_utf8_lossy(line).trim().chars().take(80).collect();
        StlError::Line { path: self.path.to_path_buf(), line: self.number, expected, found }
    }

    fn truncated(&self, expected: &'static str) -> StlError {
        StlError::Truncated { path: self.path.to_path_buf(), line: self.number, expected }
    }
}

fn vertex(line: &[u8]) -> Option<[f64; 3]> {
    let mut words = std::str::from_utf8(line).ok()?.split_ascii_whitespace().skip(1);
    let mut next = || words.next()?.parse::<f64>().ok();
    let vertex = [next()?, next()?, next()?];
    words.next().is_none().then_some(vertex)
}
