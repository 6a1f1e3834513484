//! What the XML of a VTP file says: how many points and triangles there are, and where their arrays stand.

use std::fs::File;
use std::path::Path;

use super::VtpError;
use super::numbers::{Encoding, Numbers, Type, Value, ValueError};
use super::tags::{self, Stretch, Tag, TagError};

/// The most bytes of the strings of `terrabite`, as text.
const STRINGS: u64 = 64 << 20;

/// The most arrays of points that are kept.
const ARRAYS: usize = 1000;

/// What the XML says.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) is_big: bool,
    /// The type of the lengths before arrays.
    pub(super) length: Type,
    pub(super) points: u64,
    pub(super) polys: u64,
    pub(super) coordinates: Option<Array>,
    pub(super) connectivity: Option<Array>,
    pub(super) offsets: Option<Array>,
    /// Of points.
    pub(super) attributes: Vec<Array>,
    /// Which of them are the normals.
    pub(super) normals: Option<String>,
    /// The strings of the field data `terrabite`.
    pub(super) facts: Option<Vec<String>>,
    /// What arrays are compressed with.
    compressor: Option<String>,
}

/// Where an array stands.
#[derive(Debug, Clone)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) number: Type,
    pub(super) components: u64,
    pub(super) encoding: Encoding,
    pub(super) begin: u64,
    pub(super) end: u64,
}

/// Reads the XML of a file of this length, as far as the arrays behind it.
pub(super) fn read(path: &Path, file: &File, length: u64) -> Result<Document, VtpError> {
    let mut reading = Reading { path, file, length, document: Document::new(), section: Section::Other, open: None };
    let mut bytes = Stretch::new(file, 0, length);
    let mut next = || {
        tags::next(&mut bytes).map_err(|error| match error {
            TagError::Io(source) => VtpError::Io { path: path.to_path_buf(), source },
            TagError::Wrong(place) => reading_error(path, place, "a tag of XML", "none"),
        })
    };
    match next()? {
        Some(tag) if tag.name == "VTKFile" => reading.file(&tag)?,
        Some(tag) => return Err(reading_error(path, tag.begin, "<VTKFile>", &format!("<{}>", shortened(&tag.name)))),
        None => return Err(VtpError::Missing { path: path.to_path_buf(), expected: "<VTKFile>".to_string() }),
    }
    let mut appended = None;
    while let Some(tag) = next()? {
        if let Some(array) = reading.open.take() {
            reading.array(&array, tag.begin)?;
        }
        if tag.name == "AppendedData" {
            appended = Some(reading.appended(&tag)?);
            break;
        }
        reading.tag(tag)?;
    }
    reading.document.place(path, appended, length)?;
    Ok(reading.document)
}

/// A part of the XML in which arrays stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Section {
    FieldData,
    PointData,
    Points,
    Polys,
    Other,
}

struct Reading<'a> {
    path: &'a Path,
    file: &'a File,
    length: u64,
    document: Document,
    section: Section,
    /// An array that has begun: where it ends, the next tag tells.
    open: Option<Tag>,
}

impl Reading<'_> {
    fn file(&mut self, tag: &Tag) -> Result<(), VtpError> {
        if tag.attribute("type") != Some("PolyData") {
            return Err(self.wrong(tag, "type=\"PolyData\"", tag.attribute("type")));
        }
        self.document.is_big = match tag.attribute("byte_order") {
            Some("BigEndian") => true,
            Some("LittleEndian") | None => false,
            other => return Err(self.wrong(tag, "byte_order LittleEndian or BigEndian", other)),
        };
        self.document.length = match tag.attribute("header_type").map(Type::of) {
            None => Type::UInt32,
            Some(Some(number @ (Type::UInt32 | Type::UInt64))) => number,
            Some(_) => return Err(self.wrong(tag, "header_type UInt32 or UInt64", tag.attribute("header_type"))),
        };
        self.document.compressor = tag.attribute("compressor").map(shortened);
        Ok(())
    }

    fn tag(&mut self, tag: Tag) -> Result<(), VtpError> {
        match tag.name.as_str() {
            "FieldData" => self.section = Section::FieldData,
            "PointData" => {
                self.section = Section::PointData;
                self.document.normals = tag.attribute("Normals").map(str::to_string);
            }
            "Points" => self.section = Section::Points,
            "Polys" => self.section = Section::Polys,
            "CellData" | "Verts" | "Lines" | "Strips" => self.section = Section::Other,
            "Piece" => self.piece(&tag)?,
            "DataArray" if tag.is_empty => self.array(&tag, tag.end)?,
            "Array" | "DataArray" => self.open = Some(tag),
            name if name.starts_with('/') && !["/DataArray", "/Array"].contains(&name) && !is_information(name) => {
                self.section = Section::Other;
            }
            _ => {}
        }
        Ok(())
    }

    fn piece(&mut self, tag: &Tag) -> Result<(), VtpError> {
        let count = |name: &str| match tag.attribute(name) {
            None => Ok(0),
            Some(text) => text.trim().parse().map_err(|_| self.wrong(tag, "counts of points and cells", Some(text))),
        };
        let (points, polys, strips) = (count("NumberOfPoints")?, count("NumberOfPolys")?, count("NumberOfStrips")?);
        if strips > 0 {
            return Err(self.wrong(tag, "no triangle strips", tag.attribute("NumberOfStrips")));
        }
        if points > 0 && self.document.points > 0 {
            return Err(self.wrong(tag, "one piece with points", Some("another")));
        }
        if points > 0 {
            (self.document.points, self.document.polys) = (points, polys);
        }
        Ok(())
    }

    /// An array whose content ends here, if it stands in the XML.
    fn array(&mut self, tag: &Tag, end: u64) -> Result<(), VtpError> {
        // Points need no name.
        let usual = if self.section == Section::Points { "Points" } else { "" };
        let name = tag.attribute("Name").filter(|name| !name.is_empty()).unwrap_or(usual);
        if self.section == Section::FieldData {
            let is_facts = name == "terrabite" && tag.attribute("format") == Some("ascii");
            if is_facts && tag.attribute("type") == Some("String") {
                self.document.facts = Some(self.strings(tag, end)?);
            }
            return Ok(());
        }
        let number = tag.attribute("type").and_then(Type::of);
        // Strings and bits of points are nobody's heights.
        let (Some(number), false) = (number, self.section == Section::Other) else { return Ok(()) };
        let components = match tag.attribute("NumberOfComponents") {
            None => 1,
            Some(text) => text.trim().parse().map_err(|_| self.wrong(tag, "a number of components", Some(text)))?,
        };
        let (encoding, begin) = match tag.attribute("format") {
            Some("appended") => {
                let offset = tag.attribute("offset").and_then(|text| text.trim().parse().ok());
                let offset = offset.ok_or_else(|| self.wrong(tag, "an offset", tag.attribute("offset")))?;
                // To be placed once it is known where the data begin.
                (Encoding::Raw, offset)
            }
            Some("binary") => (Encoding::Base64, tag.end),
            Some("ascii") | None => (Encoding::Ascii, tag.end),
            other => return Err(self.wrong(tag, "format ascii, binary or appended", other)),
        };
        let array = Array { name: shortened(name), number, components, encoding, begin, end };
        let document = &mut self.document;
        let slot = match (self.section, name) {
            (Section::Points, _) => &mut document.coordinates,
            (Section::Polys, "connectivity") => &mut document.connectivity,
            (Section::Polys, "offsets") => &mut document.offsets,
            (Section::PointData, _) => {
                if document.attributes.len() < ARRAYS {
                    document.attributes.push(array);
                }
                return Ok(());
            }
            _ => return Ok(()),
        };
        if slot.is_none() {
            *slot = Some(array);
        }
        Ok(())
    }

    /// Strings: the numbers of their bytes, and a 0 after each.
    fn strings(&self, tag: &Tag, end: u64) -> Result<Vec<String>, VtpError> {
        if end - tag.end > STRINGS {
            return Err(self.wrong(tag, "strings of at most 64 MiB", None));
        }
        let bytes = Stretch::new(self.file, tag.end, end);
        let mut numbers = Numbers::new(bytes, Encoding::Ascii, Type::Int16, false);
        let (mut strings, mut string) = (Vec::new(), Vec::new());
        loop {
            match numbers.next() {
                Ok(Value::Integer(0)) => {
                    strings.push(unescaped(&String::from_utf8_lossy(&std::mem::take(&mut string))));
                }
                // VTK has bytes with a sign.
                Ok(Value::Integer(byte @ -128..=255)) => string.push(byte as u8),
                Ok(_) => return Err(self.wrong(tag, "the numbers of bytes", Some("larger ones"))),
                Err(ValueError::Ended) => return Ok(strings),
                Err(ValueError::Io(source)) => return Err(VtpError::Io { path: self.path.to_path_buf(), source }),
                Err(ValueError::Wrong(found)) => return Err(self.wrong(tag, "the numbers of bytes", Some(&found))),
            }
        }
    }

    /// Where the data behind the XML begin, and how they are written.
    fn appended(&self, tag: &Tag) -> Result<(u64, Encoding), VtpError> {
        let encoding = match tag.attribute("encoding") {
            Some("raw") => Encoding::Raw,
            Some("base64") | None => Encoding::Base64,
            other => return Err(self.wrong(tag, "encoding raw or base64", other)),
        };
        let mut bytes = Stretch::new(self.file, tag.end, self.length);
        loop {
            match bytes.byte().map_err(|source| VtpError::Io { path: self.path.to_path_buf(), source })? {
                Some(b'_') => return Ok((bytes.place(), encoding)),
                Some(byte) if byte.is_ascii_whitespace() => {}
                _ => return Err(self.wrong(tag, "an underscore before the data", None)),
            }
        }
    }

    fn wrong(&self, tag: &Tag, expected: &'static str, found: Option<&str>) -> VtpError {
        reading_error(self.path, tag.begin, expected, found.map_or("none", |text| text))
    }
}

impl Document {
    fn new() -> Document {
        Document {
            is_big: false,
            length: Type::UInt32,
            points: 0,
            polys: 0,
            coordinates: None,
            connectivity: None,
            offsets: None,
            attributes: Vec::new(),
            normals: None,
            facts: None,
            compressor: None,
        }
    }

    /// Gives arrays behind the XML their places; none that is needed may be compressed.
    fn place(&mut self, path: &Path, appended: Option<(u64, Encoding)>, length: u64) -> Result<(), VtpError> {
        let needed = [&mut self.coordinates, &mut self.connectivity, &mut self.offsets].into_iter().flatten();
        for array in needed.chain(&mut self.attributes) {
            if array.encoding == Encoding::Raw {
                let missing = || VtpError::Missing { path: path.to_path_buf(), expected: "<AppendedData>".to_string() };
                let (base, encoding) = appended.ok_or_else(missing)?;
                let begin = base.saturating_add(array.begin);
                if begin > length {
                    let expected = format!("a place before byte {length}, where the file ends");
                    let (array, found) = (array.name.clone(), format!("byte {begin}"));
                    return Err(VtpError::Array { path: path.to_path_buf(), array, expected, found });
                }
                (array.encoding, array.begin, array.end) = (encoding, begin, length);
            }
            if let Some(compressor) = self.compressor.as_ref().filter(|_| array.encoding != Encoding::Ascii) {
                return Err(VtpError::Compressed { path: path.to_path_buf(), compressor: compressor.clone() });
            }
        }
        Ok(())
    }
}

/// Whether a tag closes what VTK says of an array, within it.
fn is_information(name: &str) -> bool {
    matches!(name, "/InformationKey" | "/Value")
}

/// A text in which `\0` stands for a byte of 0, and two backslashes for one.
fn unescaped(text: &str) -> String {
    let mut characters = text.chars();
    let mut unescaped = String::new();
    while let Some(character) = characters.next() {
        unescaped.push(match character {
            '\\' => match characters.next() {
                Some('0') => '\0',
                Some(other) => other,
                None => '\\',
            },
            other => other,
        });
    }
    unescaped
}

fn shortened(text: &str) -> String {
    text.chars().take(200).collect()
}

fn reading_error(path: &Path, place: u64, expected: &'static str, found: &str) -> VtpError {
    VtpError::Xml { path: path.to_path_buf(), place, expected, found: shortened(found) }
}
