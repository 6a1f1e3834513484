//! What was, for as long as it may have to come back.

use super::net::{Net, Triangle};
use crate::base::handed_over::make_room;
use crate::base::mesh::Vertex;

/// The state of triangles and vertices before a move that may be taken back. Each is noted at its first change only.
///
/// Memory: 4 bytes per triangle and per vertex of the mesh, and a copy of what one move changes.
#[derive(Debug, Default)]
pub(super) struct Journal {
    open: bool,
    epoch: u32,
    triangles: Vec<(u32, Triangle)>,
    vertices: Vec<(u32, Vertex, u32)>,
    triangle_noted: Vec<u32>,
    vertex_noted: Vec<u32>,
}

impl Journal {
    pub(super) fn reset(&mut self, triangles: usize, vertices: usize) {
        (self.open, self.epoch) = (false, 0);
        for (noted, len) in [(&mut self.triangle_noted, triangles), (&mut self.vertex_noted, vertices)] {
            make_room(noted, len);
            noted.resize(len, 0);
        }
    }

    /// The slots of all triangles changed since it was opened, in the order of their first change.
    pub(super) fn changed(&self) -> impl Iterator<Item = u32> + '_ {
        self.triangles.iter().map(|&(t, _)| t)
    }

    /// Whether a triangle was changed since it was opened.
    pub(super) fn has_changed(&self, t: u32) -> bool {
        self.triangle_noted[t as usize] == self.epoch
    }
}

impl Net {
    /// From here on changes can be taken back.
    pub(super) fn begin(&mut self) {
        let journal = &mut self.journal;
        debug_assert!(!journal.open, "a journal is open");
        journal.open = true;
        // As many moves as 32 bits count are never made on one mesh: effort is limited by its size.
        journal.epoch += 1;
        journal.triangles.clear();
        journal.vertices.clear();
    }

    /// Lets the changes stand.
    pub(super) fn commit(&mut self) {
        self.journal.open = false;
    }

    /// Takes back every change since [`Net::begin`].
    pub(super) fn roll_back(&mut self) {
        self.journal.open = false;
        for &(t, before) in &self.journal.triangles {
            self.triangles[t as usize] = before;
        }
        for &(v, before, outgoing) in &self.journal.vertices {
            self.vertices[v as usize] = before;
            self.outgoing[v as usize] = outgoing;
        }
    }

    /// A triangle, to be changed.
    pub(super) fn triangle_mut(&mut self, t: u32) -> &mut Triangle {
        let (journal, triangle) = (&mut self.journal, &mut self.triangles[t as usize]);
        if journal.open && journal.triangle_noted[t as usize] != journal.epoch {
            journal.triangle_noted[t as usize] = journal.epoch;
            journal.triangles.push((t, *triangle));
        }
        triangle
    }

    /// A vertex and the half-edge known to begin there, to be changed.
    pub(super) fn vertex_mut(&mut self, v: u32) -> (&mut Vertex, &mut u32) {
        let (journal, i) = (&mut self.journal, v as usize);
        let (vertex, outgoing) = (&mut self.vertices[i], &mut self.outgoing[i]);
        if journal.open && journal.vertex_noted[i] != journal.epoch {
            journal.vertex_noted[i] = journal.epoch;
            journal.vertices.push((v, *vertex, *outgoing));
        }
        (vertex, outgoing)
    }
}
