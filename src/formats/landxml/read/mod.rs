//! Reads TIN surfaces from LandXML files of any origin, in constant memory.
//!
//! In comes a path; out go, pass by pass, the points (`P`: northing, easting, elevation, which become z = elevation, x = easting,
//! y = northing) and the faces (`F`), but for those that are marked as invisible (`i="1"`). The file holds one surface with a
//! definition; further ones are refused. Blanks of any kind may stand between numbers. Namespaces are not looked at, a document
//! type is passed over and nothing of it is expanded. Texts are UTF-8; of files that declare another encoding all characters
//! beyond ASCII are read as `?`, and UTF-16 is refused.
//!
//! Points are numbered in the order of the file. Where their ids are not one after the other, opening reads the file twice more
//! and sorts ids in temporary files, at most 80 bytes for each point and 240 for each face. Otherwise opening reads it once; each
//! pass reads it again.
//!
//! In a file of terrabite's that says how many edges follow lines (a property `edges`), the breaklines of the source data are these
//! edges; their ends are the points at the same places, which two sorts find when they are asked for. Breaklines of other programs
//! need not be edges, and are passed over.
//!
//! Memory: one buffer of 256 KiB, one tag or text of at most 16 MiB, and what is said of the mesh, 1 MiB of it at most; two
//! sorts of 16 MiB for ids.

mod error;
mod file;
mod source;
#[cfg(test)]
mod tests;
mod walk;

pub use error::LandXmlError;
pub use file::LandXmlReader;

use crate::formats::Recognised;

/// By the name of the first element, wherever it stands among the first bytes.
pub(super) fn recognise(beginning: &[u8]) -> Recognised {
    let names = beginning.split(|b| *b == b'<').skip(1).map(|tag| {
        let end = tag.iter().position(|b| b.is_ascii_whitespace() || matches!(b, b'>' | b'/')).unwrap_or(tag.len());
        tag[..end].rsplit(|b| *b == b':').next().unwrap_or_default()
    });
    let is_xml = beginning.strip_prefix(b"\xef\xbb\xbf").unwrap_or(beginning).trim_ascii_start().starts_with(b"<");
    if is_xml && names.into_iter().any(|name| name == b"LandXML") { Recognised::Surely } else { Recognised::No }
}
