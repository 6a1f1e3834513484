//! The lines before the values.

use std::io::{BufRead, Read};
use std::path::Path;

use super::PlyError;

/// The most bytes a header may take, so that a file without `end_header` is not read to its end.
const HEADER_LIMIT: usize = 1 << 20;

/// How the values after the header are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Encoding {
    Ascii,
    BinaryLittleEndian,
    BinaryBigEndian,
}

/// The number type a property is declared as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl ScalarType {
    /// Bytes of one value in the binary encodings.
    pub fn bytes(self) -> usize {
        match self {
            ScalarType::I8 | ScalarType::U8 => 1,
            ScalarType::I16 | ScalarType::U16 => 2,
            ScalarType::I32 | ScalarType::U32 | ScalarType::F32 => 4,
            ScalarType::I64 | ScalarType::U64 | ScalarType::F64 => 8,
        }
    }

    /// Whether its values are whole numbers.
    pub fn is_integer(self) -> bool {
        !matches!(self, ScalarType::F32 | ScalarType::F64)
    }

    fn from_name(name: &str) -> Option<ScalarType> {
        Some(match name {
            "char" | "int8" => ScalarType::I8,
            "uchar" | "uint8" => ScalarType::U8,
            "short" | "int16" => ScalarType::I16,
            "ushort" | "uint16" => ScalarType::U16,
            "int" | "int32" => ScalarType::I32,
            "uint" | "uint32" => ScalarType::U32,
            "int64" => ScalarType::I64,
            "uint64" => ScalarType::U64,
            "float" | "float32" => ScalarType::F32,
            "double" | "float64" => ScalarType::F64,
            _ => return None,
        })
    }
}

impl std::fmt::Display for ScalarType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            ScalarType::I8 => "char",
            ScalarType::U8 => "uchar",
            ScalarType::I16 => "short",
            ScalarType::U16 => "ushort",
            ScalarType::I32 => "int",
            ScalarType::U32 => "uint",
            ScalarType::I64 => "int64",
            ScalarType::U64 => "uint64",
            ScalarType::F32 => "float",
            ScalarType::F64 => "double",
        })
    }
}

/// One property of an element: a value, or a list with a length in front.
#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of the list's length; `None` for a single value.
    pub(super) length: Option<ScalarType>,
    pub(super) value: ScalarType,
}

/// One kind of record in the body.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    pub(super) fn position(&self, property: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == property)
    }

    /// Bytes of one binary record; `None` where a list makes them vary.
    pub(super) fn stride(&self) -> Option<usize> {
        self.properties.iter().map(|p| p.length.is_none().then(|| p.value.bytes())).sum()
    }

    /// The least bytes one record can take: empty lists; in ascii one digit and one space for each value.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> usize {
        let least = |p: &Property| match encoding {
            Encoding::Ascii => 2,
            _ => p.length.unwrap_or(p.value).bytes(),
        };
        self.properties.iter().map(least).sum()
    }
}

/// What stands before the values.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) comments: Vec<String>,
    pub(super) elements: Vec<Element>,
    /// Bytes up to the first value.
    pub(super) length: u64,
}

/// Reads the lines up to `end_header`.
pub(super) fn read_header(path: &Path, reader: &mut impl BufRead) -> Result<Header, PlyError> {
    let mut lines = Lines { path, reader: reader.take(HEADER_LIMIT as u64), number: 0, bytes: 0 };
    if lines.next()?.as_str() != "ply" {
        return Err(lines.error("ply, the mark of a PLY file", "other bytes"));
    }
    let format = lines.next()?;
    let encoding = match format.split_whitespace().collect::<Vec<_>>()[..] {
        ["format", "ascii", "1.0"] => Encoding::Ascii,
        ["format", "binary_little_endian", "1.0"] => Encoding::BinaryLittleEndian,
        ["format", "binary_big_endian", "1.0"] => Encoding::BinaryBigEndian,
        _ => return Err(lines.error("format ascii|binary_little_endian|binary_big_endian 1.0", &format)),
    };
    let (mut comments, mut elements) = (Vec::new(), Vec::<Element>::new());
    loop {
        let line = lines.next()?;
        let (keyword, rest) = line.split_once([' ', '\t']).unwrap_or((&line, ""));
        match keyword {
            "end_header" => break,
            "comment" => comments.push(rest.trim().to_string()),
            "obj_info" => {}
            "element" => elements.push(element(rest).ok_or_else(|| lines.error("element NAME COUNT", &line))?),
            "property" => {
                let property = property(rest)
                    .ok_or_else(|| lines.error("property [list TYPE] TYPE NAME of known types", &line))?;
                let last = elements.last_mut().ok_or_else(|| lines.error("an element before its properties", &line))?;
                last.properties.push(property);
            }
            _ => return Err(lines.error("comment, obj_info, element, property or end_header", &line)),
        }
    }
    Ok(Header { encoding, comments, elements, length: lines.bytes as u64 })
}

fn element(rest: &str) -> Option<Element> {
    let (name, count) = rest.trim().split_once(char::is_whitespace)?;
    Some(Element { name: name.to_string(), count: count.trim().parse().ok()?, properties: Vec::new() })
}

fn property(rest: &str) -> Option<Property> {
    let (length, value, name) = match rest.split_whitespace().collect::<Vec<_>>()[..] {
        ["list", length, value, name] => (Some(ScalarType::from_name(length)?), value, name),
        [value, name] => (None, value, name),
        _ => return None,
    };
    if length.is_some_and(|t| !t.is_integer()) {
        return None;
    }
    Some(Property { name: name.to_string(), length, value: ScalarType::from_name(value)? })
}

/// Header lines, ended by LF or CR LF.
struct Lines<'a, R> {
    path: &'a Path,
    reader: std::io::Take<&'a mut R>,
    number: usize,
    bytes: usize,
}

impl<R: BufRead> Lines<'_, R> {
    fn next(&mut self) -> Result<String, PlyError> {
        let mut line = Vec::new();
        self.number += 1;
        let io = |source| PlyError::Io { path: self.path.to_path_buf(), source };
        self.bytes += self.reader.read_until(b'\n', &mut line).map_err(io)?;
        if line.last() != Some(&b'\n') {
            // A first line without end is most often no PLY file at all.
            if self.number == 1 {
                return Err(self.error("ply, the mark of a PLY file", "other bytes"));
            }
            if self.bytes == HEADER_LIMIT {
                return Err(PlyError::HeaderTooLong { path: self.path.to_path_buf(), limit: HEADER_LIMIT });
            }
            return Err(self.error("end_header", "the end of the file"));
        }
        Ok(String::from_utf8_lossy(&line).trim_end().to_string())
    }

    fn error(&self, expected: &'static str, found: &str) -> PlyError {
        PlyError::Header {
            path: self.path.to_path_buf(),
            line: self.number,
            expected,
            found: found.chars().take(80).collect(),
        }
    }
}
