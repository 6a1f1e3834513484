//! A vertex among the samples inside its ring: where its triangles fit best.

use super::energy::Meter;
use super::judge::Judge;
use super::net::Fit;
use crate::lattice::{Point, STEPS, orient};
use crate::mesh::Vertex;

/// The eight neighbours, in cells.
const AROUND: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Triangles from a ring to an apex inside it. Triangle i has edge i of the ring.
#[derive(Debug, Default)]
pub(super) struct Fan {
    pub(super) ring: Vec<Vertex>,
    /// The best apex found so far and how its triangles fit.
    pub(super) apex: Option<Vertex>,
    pub(super) fits: Vec<Fit>,
    trial: Vec<Fit>,
    /// In which order triangles are measured: those that have been worst come first, so that hopeless places are left
    /// early.
    order: Vec<u32>,
}

impl Fan {
    /// A new ring; nothing is known of any apex.
    pub(super) fn reset(&mut self, ring: impl Iterator<Item = Vertex>) {
        self.ring.clear();
        self.ring.extend(ring);
        let k = self.ring.len();
        self.apex = None;
        self.fits.clear();
        self.fits.resize(k, Fit::default());
        self.trial.clone_from(&self.fits);
        self.order.clear();
        self.order.extend(0..k as u32);
    }

    /// Starts from an apex whose triangles have been measured.
    pub(super) fn start_at(&mut self, apex: Vertex, fits: impl Iterator<Item = Fit>) {
        self.apex = Some(apex);
        self.fits.clear();
        self.fits.extend(fits);
        let fits = &self.fits;
        self.order.sort_by(|&a, &b| fits[b as usize].energy.total_cmp(&fits[a as usize].energy));
    }

    pub(super) fn energy(&self) -> f32 {
        self.fits.iter().map(|f| f.energy).sum()
    }

    /// Corners of triangle i with the best apex.
    pub(super) fn triangle(&self, i: usize) -> [Vertex; 3] {
        let apex = self.apex.expect("asked of a fan with an apex");
        [apex, self.ring[i], self.ring[(i + 1) % self.ring.len()]]
    }

    /// Moves the apex to a sample if the energy is below `limit` there. Returns whether it is.
    fn try_at(&mut self, place: Point, limit: f32, meter: &Meter<'_>) -> bool {
        let far = meter.tile().far_corner();
        if place.x < 0 || place.y < 0 || place.x > far.x || place.y > far.y {
            return false;
        }
        let k = self.ring.len();
        let inside = |i: usize| orient(self.ring[i].at, self.ring[(i + 1) % k].at, place) > 0;
        if !(0..k).all(inside) {
            return false;
        }
        let (column, row) = (place.x / STEPS, place.y / STEPS);
        let apex = Vertex { at: place, height: meter.tile().at(column as usize, row as usize) };
        let mut sum = 0.0;
        for turn in 0..k {
            let i = self.order[turn] as usize;
            let fit = meter.fit([apex, self.ring[i], self.ring[(i + 1) % k]], limit - sum);
            self.trial[i] = fit;
            sum += fit.energy;
            // Not if it is no number, either.
            let below = sum < limit;
            if !below {
                self.order[turn / 2..=turn].rotate_right(1);
                return false;
            }
        }
        std::mem::swap(&mut self.fits, &mut self.trial);
        self.apex = Some(apex);
        true
    }

    /// One round of the eight places `step` cells around the apex: it moves to the best of those where the energy falls
    /// below `share` of what it is. Returns whether it moved.
    pub(super) fn look_around(&mut self, step: i32, share: f32, meter: &Meter<'_>) -> bool {
        let Some(centre) = self.apex else { return false };
        let mut limit = self.energy() * share;
        let mut moved = false;
        for (x, y) in AROUND {
            let reach = step * STEPS;
            if self.try_at(Point { x: centre.at.x + x * reach, y: centre.at.y + y * reach }, limit, meter) {
                limit = self.energy();
                moved = true;
            }
        }
        moved
    }

    /// Settles the fits, and says whether every triangle is within the tolerance.
    pub(super) fn settle(&mut self, judge: &Judge<'_>) -> bool {
        (0..self.ring.len()).fold(true, |all, i| {
            self.fits[i] = judge.settle(self.triangle(i), self.fits[i]);
            all && self.fits[i].worst <= 1.0
        })
    }

    /// The exact test of every triangle and every spoke.
    pub(super) fn feasible(&self, judge: &Judge<'_>) -> bool {
        (0..self.ring.len()).all(|i| {
            let corners = self.triangle(i);
            judge.feasible(corners) && judge.may_join(corners[0], corners[1])
        })
    }
}
