//! Places around a vertex with large triangles: compared in some rows, the best one measured in full.
//!
//! Which of eight places is best is seen in a part of the samples; whether it is better than the old one is not, as one
//! sample can spoil it. So some rows choose, and all of them decide.

use super::{Fan, Look};
use crate::base::lattice::STEPS;
use crate::base::mesh::Vertex;
use crate::kernel::polish::energy::Meter;

/// The largest stride.
const LONGEST_STRIDE: u32 = 16;

impl Fan {
    /// From one row that is read to the next: a power of two, so that about `rows` rows of the star are. All are where edges
    /// count, as these are not looked at here.
    pub(super) fn stride(&self, rows: u32, meter: &Meter<'_>) -> i32 {
        if meter.edges().is_some() {
            return 1;
        }
        let (low, high) =
            self.ring.vertices.iter().fold((i32::MAX, i32::MIN), |(l, h), v| (l.min(v.at.y), h.max(v.at.y)));
        let times = ((high - low) / STEPS) as u32 / rows;
        1 << times.clamp(1, LONGEST_STRIDE).ilog2()
    }

    /// [`Fan::look_around`] with a look at every `stride`th row first.
    pub(super) fn look_coarsely(&mut self, centre: Vertex, look: Look, stride: i32, meter: &Meter<'_>) -> Vertex {
        let limit = self.energy() * look.share;
        let between = self.witnesses.between_rows(&self.ring, centre, stride, meter);
        let mut least = self.coarse_energy(centre, between, f32::INFINITY, stride, meter) * look.share;
        let mut best = None;
        while let Some((place, apex)) = self.places.next(limit, look.farthest) {
            let between = self.places.between_rows(place, stride);
            let energy = self.coarse_energy(apex, between, least, stride, meter);
            if energy < least && self.is_blunt_at(apex.at) {
                (least, best) = (energy, Some((place, apex)));
            }
        }
        match best {
            Some((place, apex)) if self.try_at((place, apex), limit, look.farthest, meter) => apex,
            _ => centre,
        }
    }

    /// The energy at an apex as every `stride`th row has it, and what witnesses in other rows have, `between`; any number not
    /// below `limit` if it is not, either.
    fn coarse_energy(&self, apex: Vertex, between: f32, limit: f32, stride: i32, meter: &Meter<'_>) -> f32 {
        let mut sum = between;
        for turn in 0..self.ring.triangles() {
            let below = sum < limit;
            if !below {
                return f32::INFINITY;
            }
            let i = self.order[turn] as usize;
            sum += meter.coarse_energy(self.triangle(apex, i), limit - sum, stride);
        }
        sum
    }
}
