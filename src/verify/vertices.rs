//! Vertices on disk, found by number.

use std::fs::File;

use super::VerifyError;
use crate::base::external::Scratch;

/// A vertex as the verifier sees it: on the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vertex {
    /// The lattice point, the nearest one for a vertex off the lattice; `None` where there is none in any raster's
    /// range.
    pub(super) place: Option<(i64, i64)>,
    pub(super) z: f64,
}

type Words = [u64; 3];

/// Stands for a missing lattice point.
const NOWHERE: i64 = i64::MIN;

impl Vertex {
    fn words(self) -> Words {
        let (x, y) = self.place.unwrap_or((NOWHERE, NOWHERE));
        [x as u64, y as u64, self.z.to_bits()]
    }

    fn from_words([x, y, z]: Words) -> Vertex {
        let place = (x as i64 != NOWHERE).then_some((x as i64, y as i64));
        Vertex { place, z: f64::from_bits(z) }
    }
}

/// Vertices by index, in a temporary file behind a cache.
///
/// Memory use is constant: `SLOTS` blocks of 64 vertices, 12 MiB, because every block has one slot it may be in. Faces
/// mostly name vertices written near each other, which this serves from memory; faces in random order cost one read of
/// 1.5 KiB per corner, which is slow but never wrong.
#[derive(Debug)]
pub(super) struct VertexStore<'s> {
    scratch: &'s Scratch,
    file: File,
    count: u64,
    slots: Vec<Slot>,
}

#[derive(Debug, Clone, Default)]
struct Slot {
    /// The block's number plus one; 0 is empty.
    tag: u64,
    records: Vec<Words>,
}

const SLOTS: u64 = 8192;
const BLOCK: u64 = 64;

/// Fills a [`VertexStore`], in the order of the indices.
#[derive(Debug)]
pub(super) struct VertexWriter<'s> {
    scratch: &'s Scratch,
    file: File,
    count: u64,
    buffer: Vec<Words>,
}

impl<'s> VertexWriter<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Result<Self, VerifyError> {
        Ok(VertexWriter { scratch, file: scratch.file()?, count: 0, buffer: Vec::new() })
    }

    pub(super) fn push(&mut self, vertex: Vertex) -> Result<(), VerifyError> {
        self.buffer.push(vertex.words());
        self.count += 1;
        if self.buffer.len() == 64 * BLOCK as usize {
            self.scratch.write(&self.file, &self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
    }

    pub(super) fn finish(self) -> Result<VertexStore<'s>, VerifyError> {
        self.scratch.write(&self.file, &self.buffer)?;
        let slots = vec![Slot::default(); SLOTS as usize];
        Ok(VertexStore { scratch: self.scratch, file: self.file, count: self.count, slots })
    }
}

impl VertexStore<'_> {
    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// # Panics
    /// If there is no such vertex: whoever reads indices checks them.
    pub(super) fn get(&mut self, index: u64) -> Result<Vertex, VerifyError> {
        assert!(index < self.count, "vertex {index} of {}", self.count);
        let block = index / BLOCK;
        let slot = &mut self.slots[(block % SLOTS) as usize];
        if slot.tag != block + 1 {
            let first = block * BLOCK;
            // Empty while it is read: an error must not leave a half-read block behind.
            slot.tag = 0;
            slot.records.resize(BLOCK.min(self.count - first) as usize, [0; 3]);
            self.scratch.read(&self.file, first, &mut slot.records)?;
            slot.tag = block + 1;
        }
        Ok(Vertex::from_words(slot.records[(index % BLOCK) as usize]))
    }
}
