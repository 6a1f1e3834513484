//! The head of a classic NetCDF file: dimensions, attributes, and where variables stand.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use super::UgridError;
use super::values::Type;

/// The most bytes of a head; those of meshes have some thousand.
pub(super) const LIMIT: u64 = 16 << 20;

/// Values of an attribute that are kept.
const KEPT: usize = 16;

/// A head.
#[derive(Debug, Clone, Default)]
pub(super) struct Head {
    pub(super) dimensions: Vec<Dimension>,
    pub(super) said: Said,
    pub(super) variables: Vec<Variable>,
}

#[derive(Debug, Clone)]
pub(super) struct Dimension {
    pub(super) name: String,
    /// 0 is one that grows with every record.
    pub(super) length: u64,
}

#[derive(Debug, Clone)]
pub(super) struct Variable {
    pub(super) name: String,
    /// Numbers of dimensions.
    pub(super) dimensions: Vec<usize>,
    pub(super) said: Said,
    pub(super) number: Type,
    /// Where its values begin.
    pub(super) begin: u64,
}

/// What a variable, or the file, says of itself: attributes by name.
#[derive(Debug, Clone, Default)]
pub(super) struct Said(Vec<(String, Value)>);

/// A value of an attribute; of numbers, the first few.
#[derive(Debug, Clone)]
pub(super) enum Value {
    Text(String),
    Integers(Vec<i128>),
    Reals(Vec<f64>),
}

impl Said {
    pub(super) fn value(&self, name: &str) -> Option<&Value> {
        self.0.iter().find(|(found, _)| found == name).map(|(_, value)| value)
    }

    pub(super) fn text(&self, name: &str) -> Option<&str> {
        match self.value(name)? {
            Value::Text(text) => Some(text.trim_end_matches('\0')),
            _ => None,
        }
    }

    pub(super) fn integer(&self, name: &str) -> Option<i128> {
        match self.value(name)? {
            Value::Integers(numbers) => numbers.first().copied(),
            Value::Reals(numbers) => numbers.first().filter(|n| n.fract() == 0.0).map(|n| *n as i128),
            Value::Text(_) => None,
        }
    }
}

impl Head {
    pub(super) fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }
}

/// Reads the head of a file of this length.
pub(super) fn read(path: &Path, file: &File, length: u64) -> Result<Head, UgridError> {
    let mut bytes = Bytes { path, reader: BufReader::new(file), length, place: 0, wide: false };
    let mark = bytes.take(4)?;
    bytes.wide = match mark.as_slice() {
        b"CDF\x01" | b"CDF\x02" => false,
        b"CDF\x05" => true,
        b"\x89HDF" => return Err(UgridError::Hdf5 { path: path.to_path_buf() }),
        _ => return Err(bytes.wrong(0, "CDF and 1, 2 or 5, the mark of a classic NetCDF file", &mark)),
    };
    let has_wide_places = mark[3] != 1;
    // How many records there are: none of them is read.
    bytes.count()?;
    let mut head = Head::default();
    for _ in 0..bytes.list(DIMENSION, "dimensions")? {
        let dimension = Dimension { name: bytes.text()?, length: bytes.count()? };
        head.dimensions.push(dimension);
    }
    head.said = bytes.said()?;
    for _ in 0..bytes.list(VARIABLE, "variables")? {
        let name = bytes.text()?;
        let mut dimensions = Vec::new();
        for _ in 0..bytes.count()? {
            let place = bytes.place;
            let dimension = bytes.count()?;
            if dimension >= head.dimensions.len() as u64 {
                return Err(bytes.wrong_number(place, "the number of a dimension", dimension));
            }
            dimensions.push(dimension as usize);
        }
        let said = bytes.said()?;
        let number = bytes.number()?;
        // Its length, which follows from its dimensions.
        bytes.count()?;
        let begin = if has_wide_places { bytes.wide_word()? } else { bytes.word()?.into() };
        head.variables.push(Variable { name, dimensions, said, number, begin });
    }
    Ok(head)
}

/// Tags of lists.
const DIMENSION: u32 = 10;
const VARIABLE: u32 = 11;
const ATTRIBUTE: u32 = 12;

/// The bytes of a head, one after the other.
struct Bytes<'a> {
    path: &'a Path,
    reader: BufReader<&'a File>,
    /// Of the file.
    length: u64,
    place: u64,
    /// Whether counts have 64 bits.
    wide: bool,
}

impl Bytes<'_> {
    /// So many bytes, once it is known that there are as many.
    fn take(&mut self, bytes: u64) -> Result<Vec<u8>, UgridError> {
        let path = || self.path.to_path_buf();
        let end = self.place.saturating_add(bytes);
        if end > self.length {
            let what = "the head of a NetCDF file".to_string();
            return Err(UgridError::Truncated { path: path(), what, expected: end, found: self.length });
        }
        if end > LIMIT {
            return Err(UgridError::HeadTooLong { path: path(), limit: LIMIT });
        }
        let mut taken = vec![0; bytes as usize];
        self.reader.read_exact(&mut taken).map_err(|source| UgridError::Io { path: path(), source })?;
        self.place = end;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u32, UgridError> {
        Ok(u32::from_be_bytes(self.take(4)?.try_into().expect("four bytes")))
    }

    fn wide_word(&mut self) -> Result<u64, UgridError> {
        Ok(u64::from_be_bytes(self.take(8)?.try_into().expect("eight bytes")))
    }

    fn count(&mut self) -> Result<u64, UgridError> {
        if self.wide { self.wide_word() } else { Ok(self.word()?.into()) }
    }

    /// The length of a list.
    fn list(&mut self, tag: u32, expected: &'static str) -> Result<u64, UgridError> {
        let place = self.place;
        let (found, length) = (self.word()?, self.count()?);
        match (found, length) {
            (0, 0) => Ok(0),
            _ if found == tag => Ok(length),
            _ => Err(self.wrong_number(place, expected, found.into())),
        }
    }

    fn padded(&mut self, bytes: u64) -> Result<Vec<u8>, UgridError> {
        let mut taken = self.take(bytes)?;
        self.take(bytes.next_multiple_of(4) - bytes)?;
        taken.shrink_to_fit();
        Ok(taken)
    }

    fn text(&mut self) -> Result<String, UgridError> {
        let bytes = self.count()?;
        Ok(String::from_utf8_lossy(&self.padded(bytes)?).into_owned())
    }

    fn number(&mut self) -> Result<Type, UgridError> {
        let place = self.place;
        let code = self.word()?;
        Type::of(code).ok_or_else(|| self.wrong_number(place, "the code of a number type, 1 to 11", code.into()))
    }

    fn said(&mut self) -> Result<Said, UgridError> {
        let mut said = Said::default();
        for _ in 0..self.list(ATTRIBUTE, "attributes")? {
            let (name, number, count) = (self.text()?, self.number()?, self.count()?);
            let bytes = self.padded(count.saturating_mul(number.bytes() as u64).min(u64::MAX - 3))?;
            let numbers = bytes.chunks_exact(number.bytes()).take(KEPT);
            let value = match number {
                Type::Char => Value::Text(String::from_utf8_lossy(&bytes).into_owned()),
                Type::Float | Type::Double => Value::Reals(numbers.map(|bytes| number.real(bytes)).collect()),
                _ => Value::Integers(numbers.map(|bytes| number.integer(bytes)).collect()),
            };
            said.0.push((name, value));
        }
        Ok(said)
    }

    fn wrong(&self, place: u64, expected: &'static str, found: &[u8]) -> UgridError {
        let found = format!("{:?}", String::from_utf8_lossy(found));
        UgridError::Head { path: self.path.to_path_buf(), place, expected, found }
    }

    fn wrong_number(&self, place: u64, expected: &'static str, found: u64) -> UgridError {
        UgridError::Head { path: self.path.to_path_buf(), place, expected, found: found.to_string() }
    }
}
