//! Numbers of NetCDF files, all big-endian.

use std::fmt;

use crate::base::channels::Number;

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Byte,
    Char,
    Short,
    Int,
    Float,
    Double,
    UByte,
    UShort,
    UInt,
    Int64,
    UInt64,
}

/// Calls `$with` for the bytes as a number of the type.
macro_rules! number {
    ($number:expr, $bytes:expr, $with:expr) => {{
        let bytes: &[u8] = $bytes;
        macro_rules! of {
            ($t:ty) => {
                $with(<$t>::from_be_bytes(bytes.try_into().expect("the bytes of a number")))
            };
        }
        match $number {
            Type::Byte => of!(i8),
            Type::Char | Type::UByte => of!(u8),
            Type::Short => of!(i16),
            Type::Int => of!(i32),
            Type::Float => of!(f32),
            Type::Double => of!(f64),
            Type::UShort => of!(u16),
            Type::UInt => of!(u32),
            Type::Int64 => of!(i64),
            Type::UInt64 => of!(u64),
        }
    }};
}

/// A number as a double or as an integer.
trait As {
    fn real(self) -> f64;
    fn integer(self) -> i128;
}

macro_rules! are_numbers {
    ($($t:ty),*) => {$(
        impl As for $t {
            fn real(self) -> f64 {
                self as f64
            }
            fn integer(self) -> i128 {
                self as i128
            }
        }
    )*};
}

are_numbers!(i8, u8, i16, u16, i32, u32, i64, u64, f32, f64);

impl Type {
    /// The type of this code.
    pub(super) fn of(code: u32) -> Option<Type> {
        Some(match code {
            1 => Type::Byte,
            2 => Type::Char,
            3 => Type::Short,
            4 => Type::Int,
            5 => Type::Float,
            6 => Type::Double,
            7 => Type::UByte,
            8 => Type::UShort,
            9 => Type::UInt,
            10 => Type::Int64,
            11 => Type::UInt64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn bytes(self) -> usize {
        match self {
            Type::Byte | Type::Char | Type::UByte => 1,
            Type::Short | Type::UShort => 2,
            Type::Int | Type::UInt | Type::Float => 4,
            Type::Double | Type::Int64 | Type::UInt64 => 8,
        }
    }

    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Type::Char | Type::Float | Type::Double)
    }

    /// The narrowest type that holds all of its values; 64-bit integers are rounded.
    pub(super) fn narrowest(self) -> Number {
        match self {
            Type::UByte | Type::Char => Number::U8,
            Type::Byte | Type::Short | Type::UShort | Type::Float => Number::F32,
            Type::Int | Type::UInt | Type::Int64 | Type::UInt64 | Type::Double => Number::F64,
        }
    }

    /// The value of these bytes, as a double.
    #[inline]
    pub(super) fn real(self, bytes: &[u8]) -> f64 {
        number!(self, bytes, As::real)
    }

    /// The value of these bytes, as an integer.
    #[inline]
    pub(super) fn integer(self, bytes: &[u8]) -> i128 {
        number!(self, bytes, As::integer)
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Type::Byte => "byte",
            Type::Char => "char",
            Type::Short => "short",
            Type::Int => "int",
            Type::Float => "float",
            Type::Double => "double",
            Type::UByte => "ubyte",
            Type::UShort => "ushort",
            Type::UInt => "uint",
            Type::Int64 => "int64",
            Type::UInt64 => "uint64",
        })
    }
}
