//! The head of a classic NetCDF file as bytes, and where its variables stand.

/// How the numbers of a file are counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    /// CDF-2: counts of 31 bits, places in the file of 64.
    Offset64,
    /// CDF-5: both have 64 bits.
    Data64,
}

/// A number type of variables; none of them needs padding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    Int,
    Float,
    Double,
    /// CDF-5 alone.
    Int64,
}

impl Type {
    fn code(self) -> u32 {
        match self {
            Type::Int => 4,
            Type::Float => 5,
            Type::Double => 6,
            Type::Int64 => 10,
        }
    }

    /// Bytes of a number.
    pub(super) fn bytes(self) -> u64 {
        match self {
            Type::Int | Type::Float => 4,
            Type::Double | Type::Int64 => 8,
        }
    }
}

/// A value of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Text(String),
    Int(i32),
}

/// What a variable, or the file, says of itself.
pub(super) type Said = Vec<(&'static str, Value)>;

/// A variable; its dimensions are numbers of those of the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variable {
    pub(super) name: String,
    pub(super) number: Type,
    pub(super) dimensions: Vec<usize>,
    pub(super) said: Said,
}

/// A file but for the values of its variables, which stand in it in their order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct File {
    pub(super) version: Version,
    /// Names and lengths; 0 would be one without an end.
    pub(super) dimensions: Vec<(String, u64)>,
    pub(super) said: Said,
    pub(super) variables: Vec<Variable>,
}

/// The most bytes of a variable in CDF-2, and the largest of its dimensions.
const VARIABLE_OF_CDF2: u64 = u32::MAX as u64 - 3;
const DIMENSION_OF_CDF2: u64 = i32::MAX as u64;

/// Tags of the lists in a head.
const DIMENSION: u32 = 10;
const VARIABLE: u32 = 11;
const ATTRIBUTE: u32 = 12;

/// Number types of attributes.
const TEXT: u32 = 2;
const INT: u32 = 4;

impl File {
    /// The head, and of every variable where it begins and how many bytes it has.
    pub(super) fn head(&self) -> (Vec<u8>, Vec<(u64, u64)>) {
        let bytes: Vec<u64> = self.variables.iter().map(|variable| self.bytes(variable)).collect();
        let length = self.bytes_of_head(&vec![0; bytes.len()]).len() as u64;
        let mut next = length;
        let mut begins = Vec::new();
        for bytes in &bytes {
            begins.push(next);
            next += bytes;
        }
        (self.bytes_of_head(&begins), begins.into_iter().zip(bytes).collect())
    }

    /// Whether all counts are such as CDF-2 has.
    pub(super) fn is_small(&self) -> bool {
        self.dimensions.iter().all(|(_, length)| *length <= DIMENSION_OF_CDF2)
            && self.variables.iter().all(|variable| self.bytes(variable) <= VARIABLE_OF_CDF2)
    }

    /// Bytes of the values of a variable.
    fn bytes(&self, variable: &Variable) -> u64 {
        let lengths = variable.dimensions.iter().map(|&dimension| self.dimensions[dimension].1);
        variable.number.bytes() * lengths.product::<u64>()
    }

    fn bytes_of_head(&self, begins: &[u64]) -> Vec<u8> {
        let mut head = Head { version: self.version, bytes: b"CDF".to_vec() };
        head.bytes.push(match self.version {
            Version::Offset64 => 2,
            Version::Data64 => 5,
        });
        // No dimension is without an end, so there are no records.
        head.count(0);
        head.list(DIMENSION, self.dimensions.len());
        for (name, length) in &self.dimensions {
            head.text(name);
            head.count(*length);
        }
        head.said(&self.said);
        head.list(VARIABLE, self.variables.len());
        for (variable, begin) in self.variables.iter().zip(begins) {
            head.text(&variable.name);
            head.count(variable.dimensions.len() as u64);
            variable.dimensions.iter().for_each(|&dimension| head.count(dimension as u64));
            head.said(&variable.said);
            head.word(variable.number.code());
            head.count(self.bytes(variable));
            head.bytes.extend_from_slice(&begin.to_be_bytes());
        }
        head.bytes
    }
}

/// A head that grows.
struct Head {
    version: Version,
    bytes: Vec<u8>,
}

impl Head {
    fn word(&mut self, word: u32) {
        self.bytes.extend_from_slice(&word.to_be_bytes());
    }

    fn count(&mut self, count: u64) {
        match self.version {
            Version::Offset64 => self.word(u32::try_from(count).expect("a count of CDF-2")),
            Version::Data64 => self.bytes.extend_from_slice(&count.to_be_bytes()),
        }
    }

    fn list(&mut self, tag: u32, length: usize) {
        self.word(if length == 0 { 0 } else { tag });
        self.count(length as u64);
    }

    fn text(&mut self, text: &str) {
        self.count(text.len() as u64);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
    }

    fn said(&mut self, said: &Said) {
        self.list(ATTRIBUTE, said.len());
        for (name, value) in said {
            self.text(name);
            match value {
                Value::Text(text) => {
                    self.word(TEXT);
                    self.text(text);
                }
                Value::Int(number) => {
                    self.word(INT);
                    self.count(1);
                    self.word(*number as u32);
                }
            }
        }
    }
}
