//! In which order vertices are visited, and which need not be visited again.

use super::net::Net;

/// Free vertices in raster order, and for each whether something at it has changed since it was last tried in vain.
///
/// Memory: 5 bytes per vertex.
#[derive(Debug, Default)]
pub(super) struct Order {
    pub(super) raster: Vec<u32>,
    due: Vec<bool>,
}

impl Order {
    /// Takes the free vertices of a net; all are due.
    pub(super) fn reset(&mut self, net: &Net) {
        self.raster.clear();
        self.raster.extend((0..net.vertices.len() as u32).filter(|&v| net.is_free(v)));
        self.raster.sort_unstable_by_key(|&v| (net.vertex(v).at.y, net.vertex(v).at.x));
        self.due.clear();
        self.due.resize(net.vertices.len(), true);
    }

    pub(super) fn make_due(&mut self, v: u32) {
        self.due[v as usize] = true;
    }

    pub(super) fn make_all_due(&mut self) {
        self.due.fill(true);
    }

    /// Whether a vertex was due; it is no more.
    pub(super) fn take_due(&mut self, v: u32) -> bool {
        std::mem::take(&mut self.due[v as usize])
    }
}
