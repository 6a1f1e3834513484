//! In which order vertices are visited, and which need not be visited again.

use super::net::{NONE, Net};
use crate::base::handed_over::{DENSE, make_room};

/// What a vertex may be visited for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Errand {
    /// To take it out.
    Remove = 1,
    /// To move it.
    Move = 2,
    /// To turn the sides of triangles at it.
    Turn = 4,
}

/// Every errand.
const ALL: u8 = 7;

/// Free vertices in raster order, and for each and every errand whether something at it has changed since it was last
/// visited for that.
///
/// Memory: 5 bytes per vertex.
#[derive(Debug, Default)]
pub(super) struct Order {
    pub(super) raster: Vec<u32>,
    due: Vec<u8>,
}

impl Order {
    /// Takes the free vertices of a net; all are due.
    pub(super) fn reset(&mut self, net: &Net) {
        let free = || (0..net.vertices.len() as u32).filter(|&v| net.is_free(v));
        make_room(&mut self.raster, free().count());
        self.raster.extend(free());
        self.raster.sort_unstable_by_key(|&v| (net.vertex(v).at.y, net.vertex(v).at.x));
        make_room(&mut self.due, net.vertices.len());
        self.due.resize(net.vertices.len(), ALL);
    }

    /// Of all vertices only those are due that are at most `rings` edges away from these, as far as these are there.
    pub(super) fn make_only_near_due(&mut self, net: &Net, centres: &[u32], rings: usize) {
        self.due.fill(0);
        let there = |v: &&u32| net.outgoing[**v as usize] != NONE;
        centres.iter().filter(there).for_each(|&v| self.make_due(v));
        for _ in 0..rings {
            let is_due = |v: &u32| self.due[*v as usize] == ALL;
            let alive = net.triangles.iter().filter(|t| t.alive());
            let beside = alive.filter(|t| t.corners.iter().any(is_due));
            let ring: Vec<u32> = beside.flat_map(|t| t.corners).collect();
            ring.into_iter().for_each(|v| self.make_due(v));
        }
    }

    /// Frees what a dense mesh has taken.
    pub(super) fn hand_over(&mut self) {
        if self.due.len() > DENSE {
            *self = Order::default();
        }
    }

    /// Something at a vertex has changed.
    pub(super) fn make_due(&mut self, v: u32) {
        self.due[v as usize] = ALL;
    }

    pub(super) fn make_all_due(&mut self) {
        self.due.fill(ALL);
    }

    pub(super) fn is_due(&self, v: u32, errand: Errand) -> bool {
        self.due[v as usize] & errand as u8 != 0
    }

    /// Whether a vertex was due; it is no more.
    pub(super) fn take_due(&mut self, v: u32, errand: Errand) -> bool {
        let was_due = self.is_due(v, errand);
        self.due[v as usize] &= !(errand as u8);
        was_due
    }

    /// No vertex is due for this errand any more.
    pub(super) fn clear_due(&mut self, errand: Errand) {
        self.due.iter_mut().for_each(|due| *due &= !(errand as u8));
    }
}
