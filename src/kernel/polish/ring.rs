//! What surrounds a vertex, as places and heights.

use crate::base::mesh::Vertex;

/// The vertices around one that may move, in order. Closed around a vertex inside; open around one on the raster's rim: from
/// its neighbour along the rim to the one before it, with nothing beyond.
#[derive(Debug, Default)]
pub(super) struct Ring {
    pub(super) vertices: Vec<Vertex>,
    pub(super) is_open: bool,
}

impl Ring {
    /// How many triangles there are around the vertex: triangle i has edge i of the ring.
    #[inline(always)]
    pub(super) fn triangles(&self) -> usize {
        self.vertices.len() - usize::from(self.is_open)
    }

    /// Where edge i ends, as a number.
    #[inline(always)]
    pub(super) fn end(&self, i: usize) -> usize {
        if i + 1 == self.vertices.len() { 0 } else { i + 1 }
    }

    /// Edge i, with the inside to its left.
    #[inline(always)]
    pub(super) fn edge(&self, i: usize) -> [Vertex; 2] {
        [self.vertices[i], self.vertices[self.end(i)]]
    }

    /// The ends of an open ring, between which the vertex moves along the rim.
    pub(super) fn ends(&self) -> Option<[Vertex; 2]> {
        self.is_open.then(|| [self.vertices[0], self.vertices[self.vertices.len() - 1]])
    }

    /// A closed ring.
    #[cfg(test)]
    pub(super) fn closed(vertices: impl IntoIterator<Item = Vertex>) -> Ring {
        Ring { vertices: vertices.into_iter().collect(), is_open: false }
    }
}
