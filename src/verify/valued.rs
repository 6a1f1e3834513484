//! Vertices with values of attributes, on disk.

use std::fs::File;

use crate::formats::MeshReader;

use super::VerifyError;
use super::grid::Grid;
use super::pace::Pace;
use crate::base::external::Scratch;

/// A vertex with its height and its channels.
#[derive(Debug, Clone)]
pub(super) struct Valued<'a> {
    /// As that of a [`super::vertices::Vertex`].
    pub(super) place: Option<(i64, i64)>,
    words: &'a [[u64; 1]],
}

impl Valued<'_> {
    /// Value number `i`: the height, then the channels.
    pub(super) fn value(&self, i: usize) -> f64 {
        f64::from_bits(self.words[2 + i][0])
    }
}

/// Vertices with their channels by index, in a temporary file behind a cache, as a `VertexStore` has them without.
///
/// Memory use is constant: 4096 blocks of 64 vertices, each 24 bytes and 8 for every channel: 12 MiB with three of them.
#[derive(Debug)]
pub(super) struct ValuedStore<'s> {
    scratch: &'s Scratch,
    file: File,
    count: u64,
    /// Words of a vertex: place, height, channels.
    words: usize,
    slots: Vec<(u64, Vec<[u64; 1]>)>,
}

const SLOTS: u64 = 4096;
const BLOCK: u64 = 64;
/// Stands for a missing lattice point.
const NOWHERE: i64 = i64::MIN;

impl<'s> ValuedStore<'s> {
    /// Reads the vertices with the attributes of these names.
    pub(super) fn read(
        mesh: &mut dyn MeshReader,
        names: &[&str],
        grid: &Grid,
        scratch: &'s Scratch,
        pace: &mut Pace<'_>,
    ) -> Result<ValuedStore<'s>, VerifyError> {
        let (file, count) = (scratch.file()?, mesh.vertex_count());
        let mut buffer = Vec::new();
        mesh.for_each_vertex_with(names, |_, [x, y, z], attributes| {
            pace.tick()?;
            let place = grid.lattice(x, y).or_else(|| grid.nearest_lattice(x, y));
            let (x, y) = place.unwrap_or((NOWHERE, NOWHERE));
            buffer.extend([[x as u64], [y as u64], [grid.frame.height(z).to_bits()]]);
            buffer.extend(attributes.iter().map(|v| [v.to_bits()]));
            if buffer.len() >= 1 << 16 {
                scratch.write(&file, &buffer)?;
                buffer.clear();
            }
            Ok::<(), VerifyError>(())
        })?;
        scratch.write(&file, &buffer)?;
        let slots = vec![(0, Vec::new()); SLOTS as usize];
        Ok(ValuedStore { scratch, file, count, words: 3 + names.len(), slots })
    }

    /// # Panics
    /// If there is no such vertex: whoever reads indices checks them.
    pub(super) fn get(&mut self, index: u64) -> Result<Valued<'_>, VerifyError> {
        assert!(index < self.count, "vertex {index} of {}", self.count);
        let (block, words) = (index / BLOCK, self.words as u64);
        let (tag, records) = &mut self.slots[(block % SLOTS) as usize];
        if *tag != block + 1 {
            let first = block * BLOCK;
            // Empty while it is read: an error must not leave a half-read block behind.
            *tag = 0;
            records.resize((BLOCK.min(self.count - first) * words) as usize, [0]);
            self.scratch.read(&self.file, first * words, records)?;
            *tag = block + 1;
        }
        let at = (index % BLOCK * words) as usize;
        let words = &records[at..at + self.words];
        let (x, y) = (words[0][0] as i64, words[1][0] as i64);
        Ok(Valued { place: (x != NOWHERE).then_some((x, y)), words })
    }
}
