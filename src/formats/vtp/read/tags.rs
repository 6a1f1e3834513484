//! The tags of an XML file and the bytes between them, in constant memory: arrays may stand between tags, or behind all of them.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// The most bytes of a tag.
const LIMIT: usize = 1 << 20;

/// Bytes that are read at a time.
const BUFFER: u64 = 64 << 10;

/// A stretch of a file, byte by byte. Several may be read side by side.
#[derive(Debug)]
pub(super) struct Stretch<'a> {
    file: &'a File,
    /// Where the bytes after those of the buffer begin, and where the stretch ends.
    next: u64,
    end: u64,
    buffer: Vec<u8>,
    at: usize,
}

impl<'a> Stretch<'a> {
    pub(super) fn new(file: &'a File, begin: u64, end: u64) -> Stretch<'a> {
        Stretch { file, next: begin, end: end.max(begin), buffer: Vec::new(), at: 0 }
    }

    /// Where the next byte stands.
    pub(super) fn place(&self) -> u64 {
        self.next - (self.buffer.len() - self.at) as u64
    }

    /// The next byte; `None` at the end.
    #[inline]
    pub(super) fn byte(&mut self) -> io::Result<Option<u8>> {
        if self.at == self.buffer.len() && !self.fill()? {
            return Ok(None);
        }
        self.at += 1;
        Ok(Some(self.buffer[self.at - 1]))
    }

    /// The next bytes; false if there are fewer.
    #[inline]
    pub(super) fn bytes(&mut self, bytes: &mut [u8]) -> io::Result<bool> {
        if let Some(found) = self.buffer.get(self.at..self.at + bytes.len()) {
            bytes.copy_from_slice(found);
            self.at += bytes.len();
            return Ok(true);
        }
        for byte in bytes {
            match self.byte()? {
                Some(found) => *byte = found,
                None => return Ok(false),
            }
        }
        Ok(true)
    }

    fn fill(&mut self) -> io::Result<bool> {
        let bytes = BUFFER.min(self.end - self.next);
        if bytes == 0 {
            return Ok(false);
        }
        self.buffer.resize(bytes as usize, 0);
        self.at = 0;
        let mut file = self.file;
        if let Err(error) = file.seek(SeekFrom::Start(self.next)).and_then(|_| file.read_exact(&mut self.buffer)) {
            self.buffer.clear();
            return Err(error);
        }
        self.next += bytes;
        Ok(true)
    }
}

/// A tag.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tag {
    /// With a slash before it, if it closes.
    pub(super) name: String,
    attributes: Vec<(String, String)>,
    /// Whether it closes what it opens.
    pub(super) is_empty: bool,
    /// Where it begins, and where what comes after it does.
    pub(super) begin: u64,
    pub(super) end: u64,
}

impl Tag {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(found, _)| found == name).map(|(_, value)| value.as_str())
    }
}

/// Why there is no tag.
#[derive(Debug)]
pub(super) enum TagError {
    Io(io::Error),
    /// What begins here is none.
    Wrong(u64),
}

impl From<io::Error> for TagError {
    fn from(error: io::Error) -> TagError {
        TagError::Io(error)
    }
}

/// The next tag that is no comment; `None` if there is none.
pub(super) fn next(bytes: &mut Stretch<'_>) -> Result<Option<Tag>, TagError> {
    loop {
        loop {
            match bytes.byte()? {
                Some(b'<') => break,
                Some(_) => {}
                None => return Ok(None),
            }
        }
        let begin = bytes.place() - 1;
        if let Some(text) = inside(bytes, begin)? {
            return tag(&text, begin, bytes.place()).map(Some).ok_or(TagError::Wrong(begin));
        }
    }
}

/// What is between the brackets; `None` for a comment, or what only parsers need.
fn inside(bytes: &mut Stretch<'_>, begin: u64) -> Result<Option<Vec<u8>>, TagError> {
    let mut text = Vec::new();
    let mut quote = None;
    loop {
        let byte = bytes.byte()?.ok_or(TagError::Wrong(begin))?;
        let is_comment = text.starts_with(b"!--");
        match (byte, quote) {
            _ if is_comment => {}
            (b'>', None) => break,
            (b'"' | b'\'', None) => quote = Some(byte),
            (byte, Some(open)) if byte == open => quote = None,
            _ => {}
        }
        if is_comment && byte == b'>' && text.ends_with(b"--") && text.len() >= 5 {
            return Ok(None);
        }
        if is_comment && text.len() > 16 {
            // Of a comment, no more than its beginning and its end are kept.
            text.remove(3);
        }
        text.push(byte);
        if text.len() > LIMIT {
            return Err(TagError::Wrong(begin));
        }
    }
    Ok(Some(text).filter(|text| !text.starts_with(b"!") && !text.starts_with(b"?")))
}

fn tag(text: &[u8], begin: u64, end: u64) -> Option<Tag> {
    let text = std::str::from_utf8(text).ok()?.trim();
    let (text, is_empty) = text.strip_suffix('/').map_or((text, false), |text| (text, true));
    let (name, mut rest) = text.split_at(text.find(char::is_whitespace).unwrap_or(text.len()));
    let mut attributes = Vec::new();
    while !rest.trim_start().is_empty() {
        let (name, value) = rest.split_once('=')?;
        let value = value.trim_start();
        let quote = value.chars().next().filter(|c| ['"', '\''].contains(c))?;
        let (value, after) = value[1..].split_once(quote)?;
        attributes.push((name.trim().to_string(), quick_xml::escape::unescape(value).ok()?.into_owned()));
        rest = after;
    }
    (!name.is_empty() && !name.contains('<')).then(|| Tag { name: name.to_string(), attributes, is_empty, begin, end })
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    fn tags(text: &str) -> Result<Vec<Tag>, TagError> {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(text.as_bytes()).expect("written");
        let mut bytes = Stretch::new(&file, 0, text.len() as u64);
        let mut tags = Vec::new();
        while let Some(tag) = next(&mut bytes)? {
            tags.push(tag);
        }
        Ok(tags)
    }

    #[test]
    fn tags_have_names_and_attributes() {
        let text = "<?xml version='1.0'?>\n<!-- <no> '-> --><a b = \"1 > 0\" c='&lt;\"'>text</a ><d/><e f=''/>";
        let tags = tags(text).expect("tags");
        let names: Vec<(&str, bool)> = tags.iter().map(|tag| (tag.name.as_str(), tag.is_empty)).collect();
        assert_eq!(names, [("a", false), ("/a", false), ("d", true), ("e", true)]);
        assert_eq!((tags[0].attribute("b"), tags[0].attribute("c")), (Some("1 > 0"), Some("<\"")));
        assert_eq!(&text[tags[0].end as usize..tags[1].begin as usize], "text");
        assert_eq!(tags[3].attribute("f"), Some(""));
    }

    #[test]
    fn what_is_no_tag_is_an_error() {
        for (text, place) in [
            ("<a", 0),
            (" <a b>", 1),
            ("<a b=1>", 0),
            ("<a b=\"1>", 0),
            ("<!-- -->  <>", 10),
            ("<a b='&no;'>", 0),
            ("<!--", 0),
        ] {
            assert!(matches!(tags(text), Err(TagError::Wrong(found)) if found == place), "{text}");
        }
    }
}
