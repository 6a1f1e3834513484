//! A vertex inside its ring: where its triangles fit best.

use super::angles::Sharpest;
use super::energy::Meter;
use super::fitting::{Fitting, near_surface};
use super::judge::Judge;
use super::net::Fit;
use super::star::Star;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;

/// The eight neighbours, in cells.
const AROUND: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Which parts of a Gauss–Newton step are tried.
const PARTS: [f64; 2] = [1.0, 0.4];
/// A step that rounding would lead nowhere goes to the neighbour, if it is longer than this, in lattice steps.
const LEAST_STEP: f64 = 0.15;
/// None is longer than this part of the way to the nearest vertex of the ring, or a cell.
const FARTHEST: f64 = 0.7;

/// Triangles from a ring to an apex inside it. Triangle i has edge i of the ring.
#[derive(Debug, Default)]
pub(super) struct Fan {
    ring: Vec<Vertex>,
    /// How the triangles fit at the best apex found so far.
    pub(super) fits: Vec<Fit>,
    trial: Vec<Fit>,
    /// In which order triangles are measured: those that have been worst come first, so that hopeless places are left
    /// early.
    order: Vec<u32>,
    star: Star,
    sharpest: Sharpest,
}

impl Fan {
    /// Takes a ring, how the triangles to the apex that it has now fit, and how sharp others may be.
    pub(super) fn reset(
        &mut self,
        ring: impl Iterator<Item = Vertex>,
        fits: impl Iterator<Item = Fit>,
        sharpest: Sharpest,
    ) {
        self.sharpest = sharpest;
        self.ring.clear();
        self.ring.extend(ring);
        self.fits.clear();
        self.fits.extend(fits);
        self.trial.clone_from(&self.fits);
        self.order.clear();
        self.order.extend(0..self.ring.len() as u32);
        let fits = &self.fits;
        self.order.sort_by(|&a, &b| fits[b as usize].energy.total_cmp(&fits[a as usize].energy));
    }

    /// How far the nearest vertex of the ring is from a place, in lattice steps, by the longer coordinate.
    pub(super) fn clearance(&self, from: Point) -> i32 {
        let distance = |r: &Vertex| (r.at.x - from.x).abs().max((r.at.y - from.y).abs());
        self.ring.iter().map(distance).min().unwrap_or(0)
    }

    /// One round of the first `places` of eight, `step` cells around an apex. Returns the best of those where the energy falls below
    /// `share` of what it is, else the apex itself.
    pub(super) fn look_around(
        &mut self,
        centre: Vertex,
        step: i32,
        places: usize,
        share: f32,
        meter: &Meter<'_>,
    ) -> Vertex {
        let mut limit = self.energy() * share;
        let mut best = centre;
        for &(x, y) in &AROUND[..places] {
            let place = Point { x: centre.at.x + x * step * STEPS, y: centre.at.y + y * step * STEPS };
            if let Some(apex) = self.try_at(place, limit, meter) {
                limit = self.energy();
                best = apex;
            }
        }
        best
    }

    /// One Gauss–Newton step of an apex that has a height of its own. Returns the best of the old place and where it
    /// leads to, or else part of the way there, each with the height that fits it best, if the energy falls below `share`
    /// of what it is; else the apex itself.
    pub(super) fn step(&mut self, centre: Vertex, share: f32, judge: &Judge<'_>, fitting: &Fitting) -> Vertex {
        let mut limit = self.energy() * share;
        let mut best = centre;
        self.star.read(&self.ring, centre, &judge.meter);
        let [x, y, rise] = self.star.step();
        if let Some(apex) = self.raise(centre, limit, judge, fitting) {
            limit = self.energy();
            best = apex;
        }
        let farthest = f64::from(self.clearance(centre.at)) * FARTHEST;
        let shorten = (farthest.max(f64::from(STEPS)) / x.abs().max(y.abs())).min(1.0);
        let mut tried = centre.at;
        for part in PARTS.map(|part| part * shorten) {
            let place = stepped(centre.at, x * part, y * part);
            if place == tried || place == centre.at || !self.holds(place, &judge.meter) {
                continue;
            }
            tried = place;
            let guess = fitting.guess(centre, place, rise * part);
            self.star.read(&self.ring, guess, &judge.meter);
            if let Some(apex) = self.raise(guess, limit, judge, fitting) {
                best = apex;
                break;
            }
        }
        best
    }

    /// The apex whose star has been read, at the height that fits best, if the energy is below `limit` there: then the
    /// fits are those it gives.
    fn raise(&mut self, from: Vertex, limit: f32, judge: &Judge<'_>, fitting: &Fitting) -> Option<Vertex> {
        let (rise, energy) = self.star.best_rise();
        let hopeful = energy < limit;
        if !hopeful {
            return None;
        }
        let (apex, rise) = fitting.raised(from, rise)?;
        let mut sum = 0.0;
        for i in 0..self.ring.len() {
            let corners = self.triangle(apex, i);
            self.trial[i] = judge.meter.with_edges(self.star.fit(i, rise), corners, limit - sum);
            sum += self.trial[i].energy;
        }
        let below = sum < limit;
        if !below || !near_surface(judge.meter.tile(), apex, judge.tolerance()) {
            return None;
        }
        std::mem::swap(&mut self.fits, &mut self.trial);
        Some(apex)
    }

    /// Whether a place is inside the ring, on the tile, and such that no triangle is too sharp.
    fn holds(&self, place: Point, meter: &Meter<'_>) -> bool {
        let far = meter.tile().far_corner();
        if place.x < 0 || place.y < 0 || place.x > far.x || place.y > far.y {
            return false;
        }
        let k = self.ring.len();
        let inside = |i: usize| orient(self.ring[i].at, self.ring[(i + 1) % k].at, place) > 0;
        (0..k).all(inside) && self.is_blunt_at(place)
    }

    /// Whether no triangle to a place inside the ring is too sharp.
    fn is_blunt_at(&self, place: Point) -> bool {
        let apex = Vertex { at: place, height: 0.0 };
        self.sharpest.allows_any() || (0..self.ring.len()).all(|i| self.sharpest.allows(self.triangle(apex, i)))
    }

    /// The sample at a place, if the energy is below `limit` there: then the fits are those it gives.
    fn try_at(&mut self, place: Point, limit: f32, meter: &Meter<'_>) -> Option<Vertex> {
        if !self.holds(place, meter) {
            return None;
        }
        let k = self.ring.len();
        let (column, row) = (place.x / STEPS, place.y / STEPS);
        let apex = Vertex { at: place, height: meter.tile().at(column as usize, row as usize) };
        let mut sum = 0.0;
        for turn in 0..k {
            let i = self.order[turn] as usize;
            self.trial[i] = meter.fit(self.triangle(apex, i), limit - sum);
            sum += self.trial[i].energy;
            // Not if it is no number, either.
            let below = sum < limit;
            if !below {
                self.order[turn / 2..=turn].rotate_right(1);
                return None;
            }
        }
        std::mem::swap(&mut self.fits, &mut self.trial);
        Some(apex)
    }

    /// Settles the fits of the best apex, and says whether every triangle is within the tolerance.
    pub(super) fn settle(&mut self, apex: Vertex, judge: &Judge<'_>) -> bool {
        (0..self.ring.len()).fold(true, |all, i| {
            self.fits[i] = judge.settle(self.triangle(apex, i), self.fits[i]);
            all && self.fits[i].worst <= 1.0
        })
    }

    /// The exact test of every triangle and every spoke.
    pub(super) fn feasible(&self, apex: Vertex, judge: &Judge<'_>) -> bool {
        (0..self.ring.len()).all(|i| {
            let corners = self.triangle(apex, i);
            judge.feasible(corners) && judge.may_join(corners[0], corners[1])
        })
    }

    fn triangle(&self, apex: Vertex, i: usize) -> [Vertex; 3] {
        [apex, self.ring[i], self.ring[(i + 1) % self.ring.len()]]
    }

    fn energy(&self) -> f32 {
        self.fits.iter().map(|f| f.energy).sum()
    }
}

/// The lattice's place next to where a step leads.
fn stepped(from: Point, x: f64, y: f64) -> Point {
    let [mut dx, mut dy] = [x, y].map(|d| d.round() as i32);
    if (dx, dy) == (0, 0) && x.abs().max(y.abs()) > LEAST_STEP {
        (dx, dy) = if x.abs() > y.abs() { (x.signum() as i32, 0) } else { (0, y.signum() as i32) };
    }
    Point { x: from.x + dx, y: from.y + dy }
}
