//! Vertices on disk, found by number.

use super::VerifyError;
use crate::base::external::{Scratch, Store, StoreWriter};

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

/// Vertices by index, in a temporary file behind a cache: see [`Store`].
#[derive(Debug)]
pub(super) struct VertexStore<'s>(Store<'s, 3>);

/// Fills a [`VertexStore`], in the order of the indices.
#[derive(Debug)]
pub(super) struct VertexWriter<'s>(StoreWriter<'s, 3>);

impl<'s> VertexWriter<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Result<Self, VerifyError> {
        Ok(VertexWriter(StoreWriter::new(scratch)?))
    }

    pub(super) fn push(&mut self, vertex: Vertex) -> Result<(), VerifyError> {
        Ok(self.0.push(vertex.words())?)
    }

    pub(super) fn finish(self) -> Result<VertexStore<'s>, VerifyError> {
        Ok(VertexStore(self.0.finish()?))
    }
}

impl VertexStore<'_> {
    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.0.count()
    }

    /// # Panics
    /// If there is no such vertex: whoever reads indices checks them.
    pub(super) fn get(&mut self, index: u64) -> Result<Vertex, VerifyError> {
        Ok(Vertex::from_words(self.0.get(index)?))
    }
}
