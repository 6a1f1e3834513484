//! Samples that have spoken against a triangle, and so are likely to speak against the next one at the same place.
//!
//! A look at one sample costs little beside a scan of all. What a witness says holds: its sample's energy is a part of the
//! triangle's.

use super::channels::weighted_at;
use super::energy::{Meter, ONSET, energy};
use super::ring::Ring;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;

/// How many samples are remembered. More find more, but every candidate is compared with each.
const MOST: usize = 8;

/// A sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Witness {
    at: Point,
    /// Its place in the tile.
    sample: usize,
    height: f64,
    /// Brings an error to shares of the sample's limit.
    per_limit: f64,
}

impl Witness {
    /// The error here of a triangle over three weights, the lattice's orientations, as a share of the limit.
    #[inline(always)]
    fn share(&self, corners: [Vertex; 3], weights: [i64; 3], meter: &Meter<'_>) -> f64 {
        let [wa, wb, wc] = weights.map(|w| w as f64);
        let [a, b, c] = corners.map(|v| v.height - self.height);
        let share = ((wa * a + wb * b + wc * c) / (wa + wb + wc)).abs() * self.per_limit;
        let Some(error) = &meter.tile().channel_error else { return share };
        share.max(weighted_at(meter.tile(), error, self.sample, corners, [wa, wb, wc]) * meter.per_tolerance())
    }

    /// How far a triangle is from the sample, as a share of its limit; nothing if the sample is not under it.
    #[inline(always)]
    fn under(&self, [a, b, c]: [Vertex; 3], meter: &Meter<'_>) -> Option<f64> {
        let weights = [orient(b.at, c.at, self.at), orient(c.at, a.at, self.at), orient(a.at, b.at, self.at)];
        if weights.iter().any(|&w| w < 0) {
            return None;
        }
        Some(self.share([a, b, c], weights, meter))
    }

    pub(super) fn at(&self) -> Point {
        self.at
    }

    /// Its sample.
    pub(super) fn vertex(&self) -> Vertex {
        Vertex { at: self.at, height: self.height }
    }

    /// What a tolerance is as a share of its limit.
    pub(super) fn weight(&self, meter: &Meter<'_>) -> f64 {
        if meter.tile().is_weighted() { meter.tile().weights[self.sample] } else { 1.0 }
    }

    /// The same for the triangles from a ring to an apex inside it, and which of them it is.
    #[inline(always)]
    pub(super) fn under_fan(&self, ring: &Ring, apex: Vertex, meter: &Meter<'_>) -> Option<(usize, f64)> {
        let vertices = &ring.vertices[..];
        let side = |i: usize| orient(apex.at, vertices[i].at, self.at);
        let mut behind = side(0);
        for i in 0..ring.triangles() {
            let j = ring.end(i);
            let ahead = side(j);
            if behind >= 0 && ahead <= 0 {
                let area = orient(apex.at, vertices[i].at, vertices[j].at);
                let weights = [area - behind + ahead, -ahead, behind];
                return Some((i, self.share([apex, vertices[i], vertices[j]], weights, meter)));
            }
            behind = ahead;
        }
        None
    }
}

/// Up to eight, those that have spoken last first.
#[derive(Debug, Default)]
pub(super) struct Witnesses {
    known: Vec<Witness>,
}

impl Witnesses {
    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.known.clear();
    }

    /// Those that are remembered.
    pub(super) fn known(&self) -> &[Witness] {
        &self.known
    }

    /// Remembers the sample at `place` of the tile's heights; returns the witness, if it is a new one.
    pub(super) fn note(&mut self, place: usize, meter: &Meter<'_>) -> Option<Witness> {
        let (tile, per_tolerance) = (meter.tile(), meter.per_tolerance());
        let (column, row) = (place % tile.width, place / tile.width);
        let at = Point::of_sample(column as i32, row as i32);
        if self.known.iter().any(|w| w.at == at) {
            return None;
        }
        let per_limit = if tile.is_weighted() { tile.weights[place] * per_tolerance } else { per_tolerance };
        self.known.truncate(MOST - 1);
        let witness = Witness { at, sample: place, height: tile.at(column, row), per_limit };
        self.known.insert(0, witness);
        Some(witness)
    }

    /// Whether a triangle has this much energy or more, by one witness alone.
    pub(super) fn speak_against(&mut self, corners: [Vertex; 3], limit: f32, meter: &Meter<'_>) -> bool {
        let against = |w: &Witness| w.under(corners, meter).is_some_and(|t| energy(t as f32) >= limit);
        match self.known.iter().position(against) {
            // What spoke last will be asked first.
            Some(i) => {
                self.known[..=i].rotate_right(1);
                true
            }
            None => false,
        }
    }

    /// The energy beyond the onset of the witnesses that are in none of every `stride`th row.
    pub(super) fn between_rows(&self, ring: &Ring, apex: Vertex, stride: i32, meter: &Meter<'_>) -> f32 {
        let between = self.known.iter().filter(|w| (w.at.y / STEPS) % stride != 0);
        let shares = between.filter_map(|w| w.under_fan(ring, apex, meter));
        shares.map(|(_, t)| (t as f32 - ONSET).max(0.0).powi(2)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::channels::{ChannelError, Range, Ranges};
    use crate::base::{Heights, Tile};
    use crate::kernel::triangulate::Feasibility;
    use crate::kernel::triangulate::feasible::Tester;

    const SPIKE: usize = 2 * 9 + 5;

    fn at(column: i32, row: i32, height: f64) -> Vertex {
        Vertex { at: Point::of_sample(column, row), height }
    }

    /// A level star around (4, 4), and a spike of 3 at (5, 2).
    fn scene() -> (Tile, Ring, Vertex) {
        let mut heights = vec![0.0f32; 81];
        heights[SPIKE] = 3.0;
        let ring = [at(0, 0, 0.0), at(8, 0, 0.0), at(8, 8, 0.0), at(0, 8, 0.0)];
        (Tile::from_heights(9, 9, Heights::F32(heights)), Ring::closed(ring), at(4, 4, 0.0))
    }

    fn meter(tile: &Tile) -> Meter<'_> {
        Meter::new(Tester::new(tile, 2.0, Feasibility::Weak), 2.0)
    }

    #[test]
    fn a_witness_says_what_its_sample_says() {
        let (tile, ring, apex) = scene();
        let [[first, second], [_, third]] = [ring.edge(0), ring.edge(1)];
        let (mut witnesses, meter) = (Witnesses::default(), meter(&tile));
        witnesses.note(SPIKE, &meter);
        let (triangle, share) = witnesses.known()[0].under_fan(&ring, apex, &meter).unwrap();
        assert_eq!((triangle, share), (0, 1.5), "the spike is in the first triangle");
        let said = energy(share as f32);
        assert!(witnesses.speak_against([apex, first, second], said, &meter));
        assert!(!witnesses.speak_against([apex, first, second], said * 1.01, &meter), "it says no more than it knows");
        assert!(!witnesses.speak_against([apex, second, third], 0.0, &meter), "nor of a triangle that it is not in");
    }

    /// A spike in height counts half of what it is, one of the whole range in one of two channels a quarter of 16.
    #[test]
    fn with_channels_it_says_what_they_say() {
        let range = |max| Range { min: 0.0, max };
        let ranges = Ranges { heights: range(16.0), channels: vec![range(1.0), range(5.0)], unit: 16.0 };
        let (tile, ring, apex) = scene();
        for (of_spike, t) in [(0.0f64, 1.5f32), (1.0, (1.5 + 4.0) / 2.0)] {
            let channel = |i: usize| if i == SPIKE { of_spike } else { 0.0 };
            let channels = vec![(0..81).map(channel).collect(), vec![3.0; 81]];
            let tile = tile.clone().with_channels(channels, ChannelError::new(0.5, &ranges));
            let (mut witnesses, meter) = (Witnesses::default(), meter(&tile));
            witnesses.note(SPIKE, &meter);
            let said = energy(witnesses.known()[0].under_fan(&ring, apex, &meter).unwrap().1 as f32);
            assert!((said - energy(t)).abs() < 1e-6, "{said} for {of_spike}");
            assert!((meter.fit([apex, ring.edge(0)[0], ring.edge(0)[1]], f32::INFINITY).energy - said).abs() < 1e-6);
        }
    }

    #[test]
    fn rows_that_are_read_need_no_witness() {
        let (tile, ring, apex) = scene();
        let (mut witnesses, meter) = (Witnesses::default(), meter(&tile));
        witnesses.note(SPIKE, &meter);
        assert_eq!(witnesses.between_rows(&ring, apex, 2, &meter), 0.0);
        assert!(witnesses.between_rows(&ring, apex, 4, &meter) > 0.0);
    }
}
