//! The values of a body, in any encoding.

use std::io::{BufRead, ErrorKind};

use super::{Encoding, ScalarType};

/// The longest ascii number: the exact decimal digits of any double fit.
const TOKEN_LIMIT: usize = 2048;

/// Why there is no next value; the caller knows where that was.
pub(super) enum ValueError {
    Io(std::io::Error),
    End,
    NotANumber(String),
}

/// The values of a body, one after the other, whatever the encoding.
pub(super) struct Values<R> {
    reader: R,
    encoding: Encoding,
    token: Vec<u8>,
}

impl<R: BufRead> Values<R> {
    pub(super) fn new(reader: R, encoding: Encoding) -> Self {
        Values { reader, encoding, token: Vec::new() }
    }

    /// The next value as a double: singles exactly, integers beyond 2⁵³ rounded to the nearest.
    pub(super) fn real(&mut self, kind: ScalarType) -> Result<f64, ValueError> {
        match kind {
            ScalarType::F32 => match self.bytes::<4>()? {
                Some(bytes) => Ok(f64::from(f32::from_le_bytes(bytes))),
                // What a program keeps of a number that is declared as a single is a single.
                None => self.parse::<f32>().map(f64::from),
            },
            ScalarType::F64 => match self.bytes::<8>()? {
                Some(bytes) => Ok(f64::from_le_bytes(bytes)),
                None => self.parse::<f64>(),
            },
            integer => Ok(self.integer(integer)? as f64),
        }
    }

    /// The next value of an integer type.
    pub(super) fn integer(&mut self, kind: ScalarType) -> Result<i128, ValueError> {
        macro_rules! integer {
            ($t:ty) => {
                match self.bytes::<{ size_of::<$t>() }>()? {
                    Some(bytes) => Ok(<$t>::from_le_bytes(bytes).into()),
                    None => self.parse::<$t>().map(i128::from),
                }
            };
        }
        match kind {
            ScalarType::I8 => integer!(i8),
            ScalarType::U8 => integer!(u8),
            ScalarType::I16 => integer!(i16),
            ScalarType::U16 => integer!(u16),
            ScalarType::I32 => integer!(i32),
            ScalarType::U32 => integer!(u32),
            ScalarType::I64 => integer!(i64),
            ScalarType::U64 => integer!(u64),
            ScalarType::F32 | ScalarType::F64 => unreachable!("{kind} asked for as an integer"),
        }
    }

    /// Passes over one value.
    pub(super) fn skip(&mut self, kind: ScalarType) -> Result<(), ValueError> {
        if self.encoding == Encoding::Ascii {
            return self.next_token();
        }
        let mut bytes = [0; 8];
        self.fill(&mut bytes[..kind.bytes()])
    }

    /// The next value's bytes, the least significant first; `None` in ascii, where it has none.
    fn bytes<const N: usize>(&mut self) -> Result<Option<[u8; N]>, ValueError> {
        if self.encoding == Encoding::Ascii {
            return Ok(None);
        }
        let mut bytes = [0; N];
        self.fill(&mut bytes)?;
        if self.encoding == Encoding::BinaryBigEndian {
            bytes.reverse();
        }
        Ok(Some(bytes))
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), ValueError> {
        self.reader.read_exact(bytes).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => ValueError::End,
            _ => ValueError::Io(e),
        })
    }

    fn parse<T: std::str::FromStr>(&mut self) -> Result<T, ValueError> {
        self.next_token()?;
        let text = std::str::from_utf8(&self.token).ok();
        text.and_then(|t| t.parse().ok()).ok_or_else(|| {
            ValueError::NotANumber(String::from_utf8_lossy(&self.token).chars().take(40).collect::<String>())
        })
    }

    /// Reads up to the end of the next run of printing characters; keeps no more of it than a number can have.
    fn next_token(&mut self) -> Result<(), ValueError> {
        self.token.clear();
        loop {
            let buffer = self.reader.fill_buf().map_err(ValueError::Io)?;
            if buffer.is_empty() {
                return if self.token.is_empty() { Err(ValueError::End) } else { Ok(()) };
            }
            let blank = match self.token.is_empty() {
                true => buffer.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(buffer.len()),
                false => 0,
            };
            let rest = &buffer[blank..];
            let end = rest.iter().position(u8::is_ascii_whitespace);
            self.token.extend_from_slice(&rest[..end.unwrap_or(rest.len())]);
            let used = blank + end.unwrap_or(rest.len());
            self.reader.consume(used);
            if self.token.len() > TOKEN_LIMIT {
                return Err(ValueError::NotANumber(String::from_utf8_lossy(&self.token[..40]).into_owned()));
            }
            if end.is_some() {
                return Ok(());
            }
        }
    }
}
