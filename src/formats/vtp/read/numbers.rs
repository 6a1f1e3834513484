//! The numbers of VTK's arrays, one after the other, whatever they are written as.

use std::io;

use super::tags::Stretch;
use crate::base::channels::Number;

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Int8,
    Int16,
    Int32,
    Int64,
    UInt8,
    UInt16,
    UInt32,
    UInt64,
    Float32,
    Float64,
}

/// A number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Value {
    Integer(i128),
    Real(f64),
}

impl Type {
    /// The type of this name.
    pub(super) fn of(name: &str) -> Option<Type> {
        Some(match name {
            "Int8" => Type::Int8,
            "Int16" => Type::Int16,
            "Int32" => Type::Int32,
            "Int64" => Type::Int64,
            "UInt8" => Type::UInt8,
            "UInt16" => Type::UInt16,
            "UInt32" => Type::UInt32,
            "UInt64" => Type::UInt64,
            "Float32" => Type::Float32,
            "Float64" => Type::Float64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn bytes(self) -> usize {
        match self {
            Type::Int8 | Type::UInt8 => 1,
            Type::Int16 | Type::UInt16 => 2,
            Type::Int32 | Type::UInt32 | Type::Float32 => 4,
            Type::Int64 | Type::UInt64 | Type::Float64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Type::Float32 | Type::Float64)
    }

    /// The narrowest type that holds all of its values; 64-bit integers are rounded.
    pub(super) fn narrowest(self) -> Number {
        match self {
            Type::UInt8 => Number::U8,
            Type::Int8 | Type::Int16 | Type::UInt16 | Type::Float32 => Number::F32,
            Type::Int32 | Type::UInt32 | Type::Int64 | Type::UInt64 | Type::Float64 => Number::F64,
        }
    }

    /// The value of these bytes, as many as the type has, followed by any others.
    #[inline]
    fn value(self, bytes: [u8; 8], is_big: bool) -> Value {
        macro_rules! of {
            ($t:ty, $kind:ident, $as:ty) => {{
                let bytes = *bytes.first_chunk().expect("no number has more");
                Value::$kind((if is_big { <$t>::from_be_bytes(bytes) } else { <$t>::from_le_bytes(bytes) }) as $as)
            }};
        }
        match self {
            Type::Int8 => of!(i8, Integer, i128),
            Type::Int16 => of!(i16, Integer, i128),
            Type::Int32 => of!(i32, Integer, i128),
            Type::Int64 => of!(i64, Integer, i128),
            Type::UInt8 => of!(u8, Integer, i128),
            Type::UInt16 => of!(u16, Integer, i128),
            Type::UInt32 => of!(u32, Integer, i128),
            Type::UInt64 => of!(u64, Integer, i128),
            Type::Float32 => of!(f32, Real, f64),
            Type::Float64 => of!(f64, Real, f64),
        }
    }

    /// The value of a word; an integer must be one that the type holds.
    fn parse(self, word: &str) -> Option<Value> {
        let within = |bits: u32, has_sign: bool| {
            let value: i128 = word.parse().ok()?;
            let (least, most) =
                if has_sign { (-(1 << (bits - 1)), (1 << (bits - 1)) - 1) } else { (0, (1 << bits) - 1) };
            (least..=most).contains(&value).then_some(Value::Integer(value))
        };
        match self {
            Type::Float64 => word.parse().ok().map(Value::Real),
            Type::Float32 => word.parse().ok().map(|value: f32| Value::Real(value.into())),
            Type::Int8 | Type::Int16 | Type::Int32 | Type::Int64 => within(8 * self.bytes() as u32, true),
            Type::UInt8 | Type::UInt16 | Type::UInt32 | Type::UInt64 => within(8 * self.bytes() as u32, false),
        }
    }
}

impl Value {
    /// As a double, rounded if need be.
    pub(super) fn real(self) -> f64 {
        match self {
            Value::Integer(value) => value as f64,
            Value::Real(value) => value,
        }
    }
}

/// How the numbers of an array are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Bytes, after their length.
    Raw,
    /// The same in base64.
    Base64,
    /// Words.
    Ascii,
}

/// Why there is no number.
#[derive(Debug)]
pub(super) enum ValueError {
    Io(io::Error),
    /// The array is at its end.
    Ended,
    /// This is none.
    Wrong(String),
}

impl From<io::Error> for ValueError {
    fn from(error: io::Error) -> ValueError {
        ValueError::Io(error)
    }
}

/// The most bytes of a word.
const WORD: usize = 400;

/// The numbers of an array.
#[derive(Debug)]
pub(super) struct Numbers<'a> {
    bytes: Stretch<'a>,
    encoding: Encoding,
    number: Type,
    is_big: bool,
    /// Bytes of base64 that are decoded, and how many of them are left.
    decoded: [u8; 3],
    left: usize,
    word: String,
}

impl<'a> Numbers<'a> {
    pub(super) fn new(bytes: Stretch<'a>, encoding: Encoding, number: Type, is_big: bool) -> Numbers<'a> {
        Numbers { bytes, encoding, number, is_big, decoded: [0; 3], left: 0, word: String::new() }
    }

    /// The length in bytes that stands before an array, in a number of this type; `None` before words.
    pub(super) fn length(&mut self, number: Type) -> Result<Option<i128>, ValueError> {
        if self.encoding == Encoding::Ascii {
            return Ok(None);
        }
        match self.take(number)? {
            Value::Integer(length) => Ok(Some(length)),
            Value::Real(_) => Ok(None),
        }
    }

    /// The next number.
    #[inline]
    pub(super) fn next(&mut self) -> Result<Value, ValueError> {
        if self.encoding == Encoding::Ascii { self.parsed() } else { self.take(self.number) }
    }

    #[inline]
    fn take(&mut self, number: Type) -> Result<Value, ValueError> {
        let mut bytes = [0; 8];
        let wanted = &mut bytes[..number.bytes()];
        let has_all = match self.encoding {
            Encoding::Raw => self.bytes.bytes(wanted)?,
            _ => self.decode(wanted)?,
        };
        if has_all { Ok(number.value(bytes, self.is_big)) } else { Err(ValueError::Ended) }
    }

    fn parsed(&mut self) -> Result<Value, ValueError> {
        self.word.clear();
        while let Some(byte) = self.bytes.byte()? {
            match byte.is_ascii_whitespace() {
                true if self.word.is_empty() => {}
                true => break,
                false if self.word.len() == WORD => break,
                false => self.word.push(byte.into()),
            }
        }
        if self.word.is_empty() {
            return Err(ValueError::Ended);
        }
        self.number.parse(&self.word).ok_or_else(|| ValueError::Wrong(format!("{:?}", shortened(&self.word))))
    }

    /// Fills `bytes` from base64; false if there are fewer.
    fn decode(&mut self, bytes: &mut [u8]) -> Result<bool, ValueError> {
        for byte in bytes {
            if self.left == 0 && !self.decode_three()? {
                return Ok(false);
            }
            *byte = self.decoded[0];
            self.decoded.rotate_left(1);
            self.left -= 1;
        }
        Ok(true)
    }

    fn decode_three(&mut self) -> Result<bool, ValueError> {
        let (mut bits, mut digits, mut padding) = (0u32, 0, 0);
        while digits < 4 {
            let digit = match self.bytes.byte()? {
                Some(byte) if byte.is_ascii_whitespace() => continue,
                Some(byte @ b'A'..=b'Z') => byte - b'A',
                Some(byte @ b'a'..=b'z') => byte - b'a' + 26,
                Some(byte @ b'0'..=b'9') => byte - b'0' + 52,
                Some(b'+') => 62,
                Some(b'/') => 63,
                Some(b'=') => {
                    padding += 1;
                    0
                }
                Some(b'<') | None => return Ok(false),
                Some(byte) => return Err(ValueError::Wrong(format!("the byte {byte}, which is none of base64"))),
            };
            bits = bits << 6 | u32::from(digit);
            digits += 1;
        }
        let [_, decoded @ ..] = bits.to_be_bytes();
        self.decoded = decoded;
        self.left = 3 - padding.min(2);
        Ok(true)
    }
}

fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}
