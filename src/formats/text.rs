//! Text formats, line by line: what their readers have in common.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::ReadError;
use crate::base::control::{CancelToken, Cancelled};

/// Bytes of the one buffer that a pass reads through.
const BUFFER_BYTES: usize = 256 << 10;

/// The most bytes of a line that is kept. Longer comments are cut.
pub(super) const LINE_LIMIT: usize = 1 << 20;

/// Lines between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 13;

/// Bytes of comments at the head of a file that are kept.
const HEAD_LIMIT: usize = 1 << 20;

/// The last line of what terrabite writes.
const END: &str = "# end of mesh";

/// What is wrong with a text file, whatever its format. Every message names the file; lines are counted from 1.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum TextError {
    /// The file cannot be opened or read.
    #[error("{}: {source}", path.display())]
    Io {
        /// The mesh.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A line does not say what it should.
    #[error("{}: line {line}: expected {expected}, found {found:?}", path.display())]
    Line {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
        /// What would have been right.
        expected: &'static str,
        /// The line as it is, shortened.
        found: String,
    },
    /// A line is longer than any line of a mesh.
    #[error("{}: line {line}: expected at most {LINE_LIMIT} bytes, found more", path.display())]
    LineTooLong {
        /// The mesh.
        path: PathBuf,
        /// The line.
        line: u64,
    },
    /// It has not as many vertices or faces as it says at its head.
    #[error("{}: expected {expected} {what}, as the {told_by} line says, found {found}", path.display())]
    Count {
        /// The mesh.
        path: PathBuf,
        /// What the format calls them.
        what: &'static str,
        /// Which line says it.
        told_by: &'static str,
        /// What it says.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// Its last line is missing.
    #[error("{}: expected the line {END:?} at the end, found the end of the file after line {line}", path.display())]
    Truncated {
        /// The mesh.
        path: PathBuf,
        /// The last line.
        line: u64,
    },
    /// It is another file than it was when it was opened.
    #[error("{}: expected {expected} {what}, as when it was opened, found {found}: the file is being changed", path.display())]
    Changed {
        /// The mesh.
        path: PathBuf,
        /// What the format calls them.
        what: &'static str,
        /// How many there were.
        expected: u64,
        /// How many there are; more than expected are not counted to the end.
        found: u64,
    },
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<TextError> for ReadError {
    fn from(error: TextError) -> ReadError {
        match error {
            TextError::Cancelled(stopped) => ReadError::Cancelled(stopped),
            TextError::Io { path, source } => ReadError::Io { path, source },
            damaged => ReadError::Damaged(Box::new(damaged)),
        }
    }
}

/// A text file, open for passes over its lines. Memory: one buffer of 256 KiB and one line of at most 1 MiB.
#[derive(Debug)]
pub(super) struct Text {
    path: PathBuf,
    file: File,
    /// Whether a line that a backslash ends goes on in the next.
    joins: bool,
    cancel: CancelToken,
}

impl Text {
    /// Opens a file. `cancel` ends every pass.
    pub(super) fn open(path: &Path, joins: bool, cancel: &CancelToken) -> Result<Text, TextError> {
        let file = File::open(path).map_err(|source| TextError::Io { path: path.to_path_buf(), source })?;
        Ok(Text { path: path.to_path_buf(), file, joins, cancel: cancel.clone() })
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Hands every line to `visit` until it returns false; returns the number of the last one.
    pub(super) fn for_each_line<E: From<TextError>>(
        &self,
        mut visit: impl FnMut(&Lines<'_>) -> Result<bool, E>,
    ) -> Result<u64, E> {
        let io = |source| TextError::Io { path: self.path.clone(), source };
        let mut file = &self.file;
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let mut lines = Lines::new(file, self.joins);
        loop {
            if lines.number().is_multiple_of(PACE) {
                self.cancel.check().map_err(TextError::from)?;
            }
            match lines.advance() {
                Ok(true) if visit(&lines)? => {}
                Ok(_) => return Ok(lines.number()),
                Err(LineError::Io(source)) => return Err(io(source).into()),
                Err(LineError::TooLong) => {
                    return Err(TextError::LineTooLong { path: self.path.clone(), line: lines.number() }.into());
                }
            }
        }
    }

    /// A line that does not say what it should.
    pub(super) fn line_error(&self, lines: &Lines<'_>, expected: &'static str) -> TextError {
        let line = lines.line();
        let found = String::from_utf8_lossy(&line[..line.len().min(400)]).trim().chars().take(80).collect();
        TextError::Line { path: self.path.clone(), line: lines.number(), expected, found }
    }

    /// Not as many of something as there were.
    pub(super) fn changed(&self, what: &'static str, expected: u64, found: u64) -> TextError {
        TextError::Changed { path: self.path.clone(), what, expected, found }
    }

    /// Holds what a line at the head tells against what was found, each by what the format calls it.
    pub(super) fn check_counts(
        &self,
        told_by: &'static str,
        counts: [(&'static str, u64, u64); 2],
    ) -> Result<(), TextError> {
        match counts.into_iter().find(|(_, told, found)| told != found) {
            None => Ok(()),
            Some((what, expected, found)) => {
                Err(TextError::Count { path: self.path.clone(), what, told_by, expected, found })
            }
        }
    }
}

/// The comments before anything else, and whether the file is ended as terrabite ends it.
#[derive(Debug, Default)]
pub(super) struct Head {
    pub(super) comments: Vec<String>,
    bytes: usize,
    has_end: bool,
}

impl Head {
    /// Takes a comment of the head, as long as there is room.
    pub(super) fn keep(&mut self, line: &[u8]) {
        if self.bytes + line.len() <= HEAD_LIMIT {
            self.bytes += line.len();
            self.comments.push(String::from_utf8_lossy(line).into_owned());
        }
    }

    /// Looks at a line that may be the last.
    pub(super) fn look_for_end(&mut self, lines: &Lines<'_>) {
        self.has_end = lines.line() == END.as_bytes() && lines.ended();
    }

    /// Makes sure that the last line, of this number, was the end.
    pub(super) fn check_end(&self, text: &Text, last: u64) -> Result<(), TextError> {
        if self.has_end { Ok(()) } else { Err(TextError::Truncated { path: text.path.clone(), line: last }) }
    }
}

/// The lines of a file, those that a backslash ends perhaps joined with the next ones. Comments begin with `#`.
pub(super) struct Lines<'a> {
    reader: BufReader<&'a File>,
    joins: bool,
    line: Vec<u8>,
    first: u64,
    read: u64,
    ended: bool,
}

/// Why there is no next line.
enum LineError {
    Io(io::Error),
    TooLong,
}

impl<'a> Lines<'a> {
    /// From where the file stands.
    fn new(file: &'a File, joins: bool) -> Lines<'a> {
        let reader = BufReader::with_capacity(BUFFER_BYTES, file);
        Lines { reader, joins, line: Vec::new(), first: 0, read: 0, ended: true }
    }

    /// The number of the line that was read last, from 1; the first of joined ones.
    pub(super) fn number(&self) -> u64 {
        self.first
    }

    /// Whether the line that was read last had an end.
    fn ended(&self) -> bool {
        self.ended
    }

    /// The line that was read last, without its end.
    pub(super) fn line(&self) -> &[u8] {
        &self.line
    }

    /// Goes on to the next line; false if there is none. Of an overlong comment the beginning is kept.
    fn advance(&mut self) -> Result<bool, LineError> {
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
            match self.line.last_mut() {
                Some(last @ b'\\') if self.joins && self.ended && !is_comment => *last = b' ',
                _ => return Ok(true),
            }
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
