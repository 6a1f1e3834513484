//! Elements of accessors, one after the other, in constant memory.

use std::sync::Arc;

use super::GlbError;
use super::container::GlbFile;
use super::packed::Packing;
use crate::base::channels::Number;

/// Bytes of a view that are read at a time.
const BUFFER: u64 = 256 << 10;

/// Where the elements of an accessor are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    pub(super) view: usize,
    pub(super) data: Data,
    /// Bytes of the view.
    pub(super) length: u64,
    /// Where the first element begins in it.
    pub(super) offset: u64,
    /// Bytes from one to the next; at least as many as an element has.
    pub(super) stride: usize,
    pub(super) count: u64,
    pub(super) component: Component,
    /// How many each element has.
    pub(super) components: usize,
}

/// Where the bytes of a view are.
#[derive(Debug, Clone, Copy)]
pub(super) enum Data {
    /// In the file, from here on.
    Plain { start: u64 },
    /// In the file, compressed.
    Packed(Packing),
}

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    /// By glTF's number.
    pub(super) fn of(number: u64) -> Option<Component> {
        Some(match number {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return None,
        })
    }

    pub(super) fn bytes(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// The narrowest type that holds its values.
    pub(super) fn number(self) -> Number {
        match self {
            Component::U8 => Number::U8,
            Component::I8 | Component::I16 | Component::U16 | Component::F32 => Number::F32,
            Component::U32 => Number::F64,
        }
    }

    /// The number that `bytes` begin with.
    fn value(self, bytes: &[u8]) -> f64 {
        match self {
            Component::I8 => f64::from(bytes[0] as i8),
            Component::U8 => f64::from(bytes[0]),
            Component::I16 => f64::from(i16::from_le_bytes(first(bytes))),
            Component::U16 => f64::from(u16::from_le_bytes(first(bytes))),
            Component::U32 => f64::from(u32::from_le_bytes(first(bytes))),
            Component::F32 => f64::from(f32::from_le_bytes(first(bytes))),
        }
    }
}

fn first<const N: usize>(bytes: &[u8]) -> [u8; N] {
    *bytes.first_chunk().expect("columns are within their views")
}

/// Columns that are read side by side. Memory: a buffer of 256 KiB for each stretch of a view; those that are interleaved
/// share one.
pub(super) struct Columns {
    streams: Vec<Stream>,
    columns: Vec<Placed>,
}

/// A column in a stream.
struct Placed {
    stream: usize,
    /// Where it is in a record.
    offset: usize,
    component: Component,
}

/// Records of a view, of one length.
struct Stream {
    view: usize,
    /// Where the first record begins in the view.
    base: u64,
    stride: usize,
    length: u64,
    bytes: Bytes,
}

enum Bytes {
    /// All of the view.
    Whole(Arc<Vec<u8>>),
    /// Some records of it, from number `first` to below `end`.
    Some { start: u64, first: u64, end: u64, bytes: Vec<u8> },
}

impl Columns {
    /// Begins to read columns.
    pub(super) fn open<'c>(
        glb: &mut GlbFile,
        columns: impl IntoIterator<Item = &'c Column>,
    ) -> Result<Columns, GlbError> {
        let mut all = Columns { streams: Vec::new(), columns: Vec::new() };
        for column in columns {
            let (base, offset) = column.place();
            let is_same = |s: &Stream| (s.view, s.base, s.stride) == (column.view, base, column.stride);
            let stream = match all.streams.iter().position(is_same) {
                Some(stream) => stream,
                None => {
                    let bytes = match &column.data {
                        Data::Plain { start } => Bytes::Some { start: *start, first: 0, end: 0, bytes: Vec::new() },
                        Data::Packed(packing) => Bytes::Whole(glb.unpacked(column.view, packing)?),
                    };
                    let Column { view, stride, length, .. } = *column;
                    all.streams.push(Stream { view, base, stride, length, bytes });
                    all.streams.len() - 1
                }
            };
            all.columns.push(Placed { stream, offset, component: column.component });
        }
        Ok(all)
    }

    /// Makes the elements of number `record` available.
    pub(super) fn load(&mut self, glb: &GlbFile, record: u64) -> Result<(), GlbError> {
        self.streams.iter_mut().try_for_each(|stream| stream.load(glb, record))
    }

    /// A component of an element that has been loaded.
    pub(super) fn value(&self, column: usize, record: u64, component: usize) -> f64 {
        let Placed { stream, offset, component: kind } = &self.columns[column];
        kind.value(self.streams[*stream].at(record, offset + component * kind.bytes()))
    }
}

impl Column {
    /// Where the first record begins in the view of which its elements are part, and where they are in the records.
    fn place(&self) -> (u64, usize) {
        let within = self.offset % self.stride as u64;
        let bytes = (self.components * self.component.bytes()) as u64;
        let fits = within + bytes <= self.stride as u64;
        if fits { (self.offset - within, within as usize) } else { (self.offset, 0) }
    }
}

impl Stream {
    fn load(&mut self, glb: &GlbFile, record: u64) -> Result<(), GlbError> {
        let Bytes::Some { start, first, end, bytes } = &mut self.bytes else { return Ok(()) };
        if (*first..*end).contains(&record) {
            return Ok(());
        }
        let stride = self.stride as u64;
        let from = self.base + record * stride;
        let count = (BUFFER / stride * stride).min(self.length - from);
        bytes.resize(count as usize, 0);
        glb.read(*start + from, bytes)?;
        (*first, *end) = (record, record + count.div_ceil(stride));
        Ok(())
    }

    /// The bytes from `offset` of a record on.
    fn at(&self, record: u64, offset: usize) -> &[u8] {
        match &self.bytes {
            Bytes::Whole(bytes) => &bytes[self.base as usize + record as usize * self.stride + offset..],
            Bytes::Some { first, bytes, .. } => &bytes[(record - first) as usize * self.stride + offset..],
        }
    }
}
