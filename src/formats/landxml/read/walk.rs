//! A LandXML file, element by element: what of it belongs to a mesh.

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::Path;

use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::LandXmlError;
use super::source::{EVENT_LIMIT, Source};
use crate::base::LineType;
use crate::base::control::CancelToken;

/// Tags and texts between two looks at whether to stop; a power of two.
const PACE: u64 = 1 << 12;

/// How deep elements may be nested.
const DEPTH_LIMIT: usize = 256;

/// The most bytes of an element's name.
const NAME_LIMIT: usize = 1024;

/// The most bytes of three numbers.
const NUMBERS_LIMIT: usize = 4096;

/// The most bytes of a line: more than 16,384 points.
const LINE_LIMIT: usize = 1 << 20;

/// What comes next in a file.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Item {
    /// A point: its id, and x, y, z. Zeros in a pass over faces.
    Point(u64, [f64; 3]),
    /// The ids of a face's corners. Zeros in a pass over points.
    Face([u64; 3]),
    /// A breakline of the source data: its points, x, y, z, and its type. No points in a pass over all.
    Line(Vec<[f64; 3]>, LineType),
    /// A surface with this name.
    Surface(String),
    /// The surface has a definition of this type.
    Definition(String),
    /// Something that a file of terrabite's says of itself: its label, its value.
    Property(String, String),
    /// A CRS: its code of EPSG, its name.
    Crs(Option<String>, Option<String>),
    /// The program that has written the file.
    Program(String),
}

/// What a pass is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wanted {
    All,
    Points,
    Faces,
    Lines,
}

/// An element that has begun.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Element {
    Root,
    Surfaces,
    Surface,
    Definition,
    Points,
    Faces,
    Point(u64),
    Face,
    Source,
    Breaklines,
    Breakline(LineType),
    Line(LineType),
    /// A face that is not to be seen.
    Hidden,
    /// The feature of terrabite's.
    Ours,
    Other,
}

/// Hands on what stands in a file.
pub(super) struct Walk<'a> {
    path: &'a Path,
    reader: Reader<Source<'a>>,
    wanted: Wanted,
    cancel: &'a CancelToken,
    buffer: Vec<u8>,
    open: Vec<Element>,
    has_root: bool,
    events: u64,
    /// The text of a point, a face or a line so far.
    numbers: String,
}

impl<'a> Walk<'a> {
    /// From the beginning.
    pub(super) fn new(
        path: &'a Path,
        mut file: &'a File,
        wanted: Wanted,
        cancel: &'a CancelToken,
    ) -> Result<Walk<'a>, LandXmlError> {
        file.seek(SeekFrom::Start(0)).map_err(|source| LandXmlError::Io { path: path.to_path_buf(), source })?;
        let reader = Reader::from_reader(Source::new(file));
        let (buffer, open, numbers) = (Vec::new(), Vec::new(), String::new());
        Ok(Walk { path, reader, wanted, cancel, buffer, open, has_root: false, events: 0, numbers })
    }

    /// What comes next; `None` at the end, which is behind that of the root.
    pub(super) fn next(&mut self) -> Result<Option<Item>, LandXmlError> {
        let mut buffer = std::mem::take(&mut self.buffer);
        let item = loop {
            buffer.clear();
            if self.events.is_multiple_of(PACE) {
                self.cancel.check()?;
            }
            self.events += 1;
            self.reader.get_mut().allow_an_event();
            let event = self.reader.read_event_into(&mut buffer).map_err(|error| self.xml_error(error))?;
            let found = match event {
                Event::Start(tag) => self.start(&tag)?,
                Event::Empty(tag) => {
                    let item = self.start(&tag)?;
                    // A point or a face without numbers is an error.
                    let end = self.end()?;
                    item.or(end)
                }
                Event::End(_) => self.end()?,
                Event::Text(text) => self.text(&text)?,
                Event::CData(text) => self.text(&text)?,
                Event::GeneralRef(reference) => {
                    let character = reference.resolve_char_ref().map_err(|error| self.xml_error(error))?;
                    // Those of a document type mean nothing here; in texts that are not read they may stand.
                    let mut bytes = [0; 4];
                    self.text(character.map_or("&", |c| c.encode_utf8(&mut bytes)))?
                }
                Event::Comment(_) | Event::Decl(_) | Event::PI(_) | Event::DocType(_) => None,
                Event::Eof if self.has_root && self.open.is_empty() => break None,
                Event::Eof => {
                    return Err(LandXmlError::Truncated { path: self.path.to_path_buf(), expected: "</LandXML>" });
                }
            };
            if found.is_some() {
                break found;
            }
        };
        self.buffer = buffer;
        Ok(item)
    }

    fn start(&mut self, tag: &BytesStart<'_>) -> Result<Option<Item>, LandXmlError> {
        let limits = [
            ("nested elements", DEPTH_LIMIT, self.open.len() + 1),
            ("bytes of an element's name", NAME_LIMIT, tag.name().as_ref().len()),
        ];
        if let Some((what, limit, _)) = limits.into_iter().find(|(_, limit, found)| found > limit) {
            return Err(LandXmlError::TooMuch { path: self.path.to_path_buf(), offset: self.offset(), what, limit });
        }
        let name = tag.local_name();
        let name = name.as_ref();
        let parent = self.open.last().copied();
        if parent.is_none() {
            let is_second = std::mem::replace(&mut self.has_root, true);
            if is_second || name != "LandXML" {
                return Err(self.element_error("one element LandXML", name));
            }
        }
        let mut item = None;
        let element = match (parent, name) {
            (None, _) => Element::Root,
            (Some(Element::Root), "Surfaces") => Element::Surfaces,
            (Some(Element::Root), "CoordinateSystem") => {
                item = self.is_all().then(|| self.crs(tag)).transpose()?;
                Element::Other
            }
            (Some(Element::Root), "Application") => {
                item = self.is_all().then(|| self.program(tag)).transpose()?.flatten();
                Element::Other
            }
            (Some(Element::Surfaces), "Surface") => {
                item = Some(Item::Surface(self.value(tag, "name")?.unwrap_or_default()));
                Element::Surface
            }
            (Some(Element::Surface), "Definition") => {
                item = Some(Item::Definition(self.value(tag, "surfType")?.unwrap_or_default()));
                Element::Definition
            }
            (Some(Element::Surface), "Feature") if self.value(tag, "code")?.as_deref() == Some("terrabite") => {
                Element::Ours
            }
            (Some(Element::Ours), "Property") => {
                let label = self.value(tag, "label")?.unwrap_or_default();
                let value = self.value(tag, "value")?.unwrap_or_default();
                item = self.is_all().then_some(Item::Property(label, value));
                Element::Other
            }
            (Some(Element::Surface), "SourceData") => Element::Source,
            (Some(Element::Source), "Breaklines") => Element::Breaklines,
            (Some(Element::Breaklines), "Breakline") => match self.value(tag, "desc")?.as_deref() {
                Some("soft") => Element::Breakline(LineType::Soft),
                _ => Element::Breakline(LineType::Hard),
            },
            (Some(Element::Breakline(line_type)), "PntList3D") => Element::Line(line_type),
            (Some(Element::Definition), "Pnts") => Element::Points,
            (Some(Element::Definition), "Faces") => Element::Faces,
            (Some(Element::Points), "P") if matches!(self.wanted, Wanted::Faces | Wanted::Lines) => Element::Point(0),
            (Some(Element::Points), "P") => Element::Point(self.id(tag)?),
            (Some(Element::Faces), "F") => match self.value(tag, "i")?.as_deref() {
                Some("1" | "true") => Element::Hidden,
                _ => Element::Face,
            },
            (Some(Element::Point(_) | Element::Face), _) => {
                return Err(self.element_error("three numbers in P or F, and no elements", name));
            }
            _ => Element::Other,
        };
        self.open.push(element);
        self.numbers.clear();
        Ok(item)
    }

    fn end(&mut self) -> Result<Option<Item>, LandXmlError> {
        match self.open.pop() {
            Some(Element::Point(id)) => {
                let [y, x, z] = match self.wanted {
                    Wanted::Faces | Wanted::Lines => [0.0; 3],
                    _ => three(&self.numbers).ok_or_else(|| self.numbers_error("northing, easting and elevation"))?,
                };
                Ok(Some(Item::Point(id, [x, y, z])))
            }
            Some(Element::Face) => {
                let ids = match self.wanted {
                    Wanted::Points | Wanted::Lines => [0; 3],
                    _ => three(&self.numbers)
                        .ok_or_else(|| self.numbers_error("the ids of a triangle's three points"))?,
                };
                Ok(Some(Item::Face(ids)))
            }
            Some(Element::Line(line_type)) => {
                let points = match self.wanted {
                    Wanted::Lines => {
                        points(&self.numbers).ok_or_else(|| self.numbers_error("northings, eastings and elevations"))?
                    }
                    _ => Vec::new(),
                };
                Ok(Some(Item::Line(points, line_type)))
            }
            _ => Ok(None),
        }
    }

    fn text(&mut self, text: &str) -> Result<Option<Item>, LandXmlError> {
        match self.open.last() {
            Some(Element::Point(_) | Element::Face) if self.numbers.len() + text.len() <= NUMBERS_LIMIT => {
                self.numbers.push_str(text);
                Ok(None)
            }
            Some(Element::Point(_) | Element::Face) => {
                let (path, what) = (self.path.to_path_buf(), "bytes of three numbers");
                Err(LandXmlError::TooMuch { path, offset: self.offset(), what, limit: NUMBERS_LIMIT })
            }
            Some(Element::Line(_)) if self.wanted == Wanted::Lines => {
                if self.numbers.len() + text.len() > LINE_LIMIT {
                    let (path, what) = (self.path.to_path_buf(), "bytes of a line");
                    return Err(LandXmlError::TooMuch { path, offset: self.offset(), what, limit: LINE_LIMIT });
                }
                self.numbers.push_str(text);
                Ok(None)
            }
            None if !text.trim().is_empty() => {
                Err(self.element_error("one element LandXML, and no text beside it", text))
            }
            _ => Ok(None),
        }
    }

    fn is_all(&self) -> bool {
        self.wanted == Wanted::All
    }

    fn id(&self, tag: &BytesStart<'_>) -> Result<u64, LandXmlError> {
        let id = self.value(tag, "id")?.unwrap_or_default();
        id.trim().parse().map_err(|_| self.element_error("P with an id, a whole number", &id))
    }

    fn crs(&self, tag: &BytesStart<'_>) -> Result<Item, LandXmlError> {
        let code = self.value(tag, "epsgCode")?.map(|code| code.trim().to_string()).filter(|code| !code.is_empty());
        let name = match self.value(tag, "desc")? {
            None => self.value(tag, "name")?,
            name => name,
        };
        Ok(Item::Crs(code, name.filter(|name| !name.trim().is_empty())))
    }

    fn program(&self, tag: &BytesStart<'_>) -> Result<Option<Item>, LandXmlError> {
        let words = [self.value(tag, "name")?, self.value(tag, "version")?];
        let words: Vec<String> = words.into_iter().flatten().filter(|word| !word.trim().is_empty()).collect();
        Ok((!words.is_empty()).then(|| Item::Program(words.join(" "))))
    }

    /// The value of an attribute.
    fn value(&self, tag: &BytesStart<'_>, name: &str) -> Result<Option<String>, LandXmlError> {
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|error| self.xml_error(error.into()))?;
            if attribute.key.as_ref() == name {
                let value =
                    attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|error| self.xml_error(error))?;
                return Ok(Some(value.into_owned()));
            }
        }
        Ok(None)
    }

    fn offset(&self) -> u64 {
        self.reader.buffer_position()
    }

    fn xml_error(&self, error: quick_xml::Error) -> LandXmlError {
        let (path, offset) = (self.path.to_path_buf(), self.offset());
        match error {
            _ if self.reader.get_ref().is_exhausted() => {
                LandXmlError::TooMuch { path, offset, what: "bytes of a tag or text", limit: EVENT_LIMIT }
            }
            quick_xml::Error::Io(source) => {
                LandXmlError::Io { path, source: std::io::Error::new(source.kind(), source.to_string()) }
            }
            error => LandXmlError::Xml { path, offset, message: error.to_string() },
        }
    }

    fn element_error(&self, expected: &'static str, found: &str) -> LandXmlError {
        let found = found.trim().chars().take(80).collect();
        LandXmlError::Element { path: self.path.to_path_buf(), offset: self.offset(), expected, found }
    }

    fn numbers_error(&self, expected: &'static str) -> LandXmlError {
        self.element_error(expected, &self.numbers)
    }
}

/// Northings, eastings and elevations as x, y, z.
fn points(text: &str) -> Option<Vec<[f64; 3]>> {
    let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().map(|word| word.parse().ok()).collect();
    let numbers = numbers?;
    let (points, rest) = numbers.as_chunks::<3>();
    rest.is_empty().then(|| points.iter().map(|[y, x, z]| [*x, *y, *z]).collect())
}

/// Three numbers with blanks between them, and no more.
fn three<T: std::str::FromStr + Default + Copy>(text: &str) -> Option<[T; 3]> {
    let mut words = text.split_ascii_whitespace();
    let mut numbers = [T::default(); 3];
    for number in &mut numbers {
        *number = words.next()?.parse().ok()?;
    }
    words.next().is_none().then_some(numbers)
}
