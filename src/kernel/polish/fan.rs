//! A vertex inside its ring: where its triangles fit best.

mod coarse;
mod places;

use self::places::Places;
use super::angles::{Angles, Sharpest};
use super::energy::Meter;
use super::fitting::{Fitting, near_surface};
use super::judge::Judge;
use super::net::Fit;
use super::ring::Ring;
use super::star::Star;
use super::witnesses::Witnesses;
use crate::base::lattice::{Point, STEPS, orient};
use crate::base::mesh::Vertex;

/// The eight neighbours, in cells.
const AROUND: [(i32, i32); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];

/// Which parts of a Gauss–Newton step are tried: the first one alone, unless the search is thorough.
const PARTS: [f64; 2] = [1.0, 0.4];
/// A step that rounding would lead nowhere goes to the neighbour, if it is longer than this, in lattice steps.
const LEAST_STEP: f64 = 0.150;
/// None is longer than this part of the way to the nearest vertex of the ring, or a cell.
const FARTHEST: f64 = 0.7;

/// An apex moves only where the energy falls below this share: smaller gains lead nowhere and take as long.
pub(super) const MOVE_SHARE: f32 = 0.98;

/// Triangles from a ring to an apex inside it. Triangle i has edge i of the ring.
#[derive(Debug, Default)]
pub(super) struct Fan {
    ring: Ring,
    /// Its edges: what is to the left of them all is inside, or on the rim that an open ring ends at.
    edges: Vec<RingEdge>,
    /// How the triangles fit at the best apex found so far.
    pub(super) fits: Vec<Fit>,
    trial: Vec<Fit>,
    /// In which order triangles are measured: those that have been worst come first, so that hopeless places are left
    /// early.
    order: Vec<u32>,
    star: Star,
    /// Samples that were far from triangles around here.
    witnesses: Witnesses,
    places: Places,
    /// What witnesses say of one place, by triangles.
    parts: Vec<f32>,
    /// How sharp triangles may be, once that has been asked for, as it seldom is; until then the first apex and the floor tell.
    sharpest: Sharpest,
    unasked: Option<(Vertex, Angles)>,
}

/// Where to look for a better place on samples, and what it must offer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look {
    /// How far away, in cells.
    pub(super) step: i32,
    /// How many of the eight directions.
    pub(super) places: usize,
    /// Below which share of what it is the energy must fall.
    pub(super) share: f32,
    /// How far triangles may be from their samples, as a share of the limit.
    pub(super) farthest: f32,
    /// In how many rows, about, places are compared.
    pub(super) rows: u32,
}

impl Look {
    fn places_around(self, centre: Point) -> impl Iterator<Item = Point> {
        let step = self.step * STEPS;
        AROUND[..self.places].iter().map(move |&(x, y)| Point { x: centre.x + x * step, y: centre.y + y * step })
    }
}

/// An edge of the ring: which side of it a place is on takes two products.
#[derive(Debug, Clone, Copy)]
struct RingEdge {
    x: i64,
    y: i64,
    across: i64,
}

impl RingEdge {
    fn new(from: Point, to: Point) -> RingEdge {
        let (x, y) = (i64::from(to.x - from.x), i64::from(to.y - from.y));
        RingEdge { x, y, across: x * i64::from(from.y) - y * i64::from(from.x) }
    }

    /// Whether a place is strictly to the left: [`orient`] is positive.
    #[inline(always)]
    fn is_left(self, place: Point) -> bool {
        self.x * i64::from(place.y) - self.y * i64::from(place.x) > self.across
    }
}

impl Fan {
    /// Takes a ring, the apex that it has now, how the triangles to that fit, and how sharp others may be. Where there is one
    /// triangle less than there are vertices the ring is open.
    pub(super) fn reset(
        &mut self,
        ring: impl Iterator<Item = Vertex>,
        apex: Vertex,
        fits: impl Iterator<Item = Fit>,
        angles: Angles,
    ) {
        self.unasked = Some((apex, angles));
        self.ring.vertices.clear();
        self.ring.vertices.extend(ring);
        self.fits.clear();
        self.fits.extend(fits);
        self.trial.clone_from(&self.fits);
        self.ring.is_open = self.fits.len() < self.ring.vertices.len();
        let triangles = self.ring.triangles();
        self.edges.clear();
        self.edges.extend((0..triangles).map(|i| self.ring.edge(i)).map(|[from, to]| RingEdge::new(from.at, to.at)));
        self.order.clear();
        self.order.extend(0..triangles as u32);
        let fits = &self.fits;
        self.order.sort_by(|&a, &b| fits[b as usize].energy.total_cmp(&fits[a as usize].energy));
    }

    /// Calls the samples as witnesses that are worst in triangles which nearly violate the tolerance, or do.
    pub(super) fn call_witnesses(&mut self, meter: &Meter<'_>) {
        self.witnesses.clear();
        for &i in self.order.iter().rev() {
            meter.note(self.fits[i as usize], &mut self.witnesses);
        }
    }

    /// How far the nearest vertex of the ring is from a place, in lattice steps, by the longer coordinate.
    pub(super) fn clearance(&self, from: Point) -> i32 {
        let distance = |r: &Vertex| (r.at.x - from.x).abs().max((r.at.y - from.y).abs());
        self.ring.vertices.iter().map(distance).min().unwrap_or(0)
    }

    /// One round of places around an apex. Returns the best of those where the energy falls below a share of what it is,
    /// else the apex itself. Places are measured in the order of what witnesses say of them.
    pub(super) fn look_around(&mut self, centre: Vertex, look: Look, meter: &Meter<'_>) -> Vertex {
        self.list_places(centre, look, meter);
        let stride = self.stride(look.rows, meter);
        if stride > 1 {
            return self.look_coarsely(centre, look, stride, meter);
        }
        let (mut limit, mut best) = (self.energy() * look.share, centre);
        while let Some((place, apex)) = self.places.next(limit, look.farthest) {
            if self.try_at((place, apex), limit, look.farthest, meter) {
                (limit, best) = (self.energy(), apex);
            }
        }
        best
    }

    /// Lists the places around an apex, and hears the witnesses about them.
    fn list_places(&mut self, centre: Vertex, look: Look, meter: &Meter<'_>) {
        let mut places = std::mem::take(&mut self.places);
        let apexes = look.places_around(centre.at).filter_map(|place| self.on_sample(place, meter));
        places.begin(&self.ring, centre, apexes, meter);
        self.witnesses.known().iter().for_each(|witness| places.hear(&self.ring, witness, meter));
        self.places = places;
    }

    /// The apex on a sample, if that is a place for it.
    fn on_sample(&self, place: Point, meter: &Meter<'_>) -> Option<Vertex> {
        if !self.holds(place, meter) {
            return None;
        }
        let (column, row) = (place.x / STEPS, place.y / STEPS);
        Some(Vertex { at: place, height: meter.tile().at(column as usize, row as usize) })
    }

    /// One Gauss–Newton step of an apex that has a height of its own. Returns the best of the old place and where it
    /// leads to, or else, in a thorough search, part of the way there, each with the height that fits it best, if the energy falls
    /// below a share of what it is; else the apex itself.
    pub(super) fn step(&mut self, centre: Vertex, thorough: bool, judge: &Judge<'_>, fitting: &Fitting) -> Vertex {
        let mut limit = self.energy() * MOVE_SHARE;
        let mut best = centre;
        self.star.read(&self.ring, centre, &judge.meter);
        let [x, y, rise] = self.star.step(self.free_ways());
        if let Some(apex) = self.raise(centre, limit, judge, fitting) {
            limit = self.energy();
            best = apex;
        }
        let farthest = f64::from(self.clearance(centre.at)) * FARTHEST;
        let shorten = (farthest.max(f64::from(STEPS)) / x.abs().max(y.abs())).min(1.0);
        let mut tried = centre.at;
        for part in PARTS[..if thorough { 2 } else { 1 }].iter().map(|part| part * shorten) {
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

    /// Whether the apex may move across and down: on a rim only along it.
    fn free_ways(&self) -> [bool; 2] {
        self.ring.ends().map_or([true; 2], |[p, q]| [p.at.x != q.at.x, p.at.y != q.at.y])
    }

    /// The apex whose star has been read, at the height that fits best, if the energy is below `limit` there: then the
    /// fits are those it gives.
    fn raise(&mut self, from: Vertex, limit: f32, judge: &Judge<'_>, fitting: &Fitting) -> Option<Vertex> {
        let (rise, energy) = self.star.best_rise(limit);
        let hopeful = energy < limit;
        if !hopeful {
            return None;
        }
        let (apex, rise) = fitting.raised(from, rise)?;
        let mut sum = 0.0;
        for i in 0..self.ring.triangles() {
            let corners = self.triangle(apex, i);
            self.trial[i] = judge.meter.with_edges(self.star.fit(i, rise), corners, limit - sum);
            sum += self.trial[i].energy;
        }
        let below = sum < limit;
        if !below || !self.is_blunt_at(apex.at) || !near_surface(judge.meter.tile(), apex, judge.tolerance()) {
            return None;
        }
        std::mem::swap(&mut self.fits, &mut self.trial);
        Some(apex)
    }

    /// Whether a place is inside the ring and on the tile. Of an open ring the inside is the rim between its ends.
    fn holds(&self, place: Point, meter: &Meter<'_>) -> bool {
        let far = meter.tile().far_corner();
        if place.x < 0 || place.y < 0 || place.x > far.x || place.y > far.y {
            return false;
        }
        let stays = self.ring.ends().is_none_or(|[p, q]| orient(p.at, q.at, place) == 0);
        stays && self.edges.iter().all(|edge| edge.is_left(place))
    }

    /// Whether no triangle to a place inside the ring is too sharp.
    fn is_blunt_at(&mut self, place: Point) -> bool {
        let sharpest = self.sharpest();
        let apex = Vertex { at: place, height: 0.0 };
        sharpest.allows_any() || (0..self.ring.triangles()).all(|i| sharpest.allows(self.triangle(apex, i)))
    }

    fn sharpest(&mut self) -> Sharpest {
        if let Some((apex, angles)) = self.unasked.take() {
            self.sharpest = angles.bound((0..self.ring.triangles()).map(|i| self.triangle(apex, i)));
        }
        self.sharpest
    }

    /// Whether the energy is below `limit` at one of the places, no triangle farther than `farthest`, and none too sharp: then the fits are
    /// those it gives.
    fn try_at(&mut self, (place, apex): (usize, Vertex), limit: f32, farthest: f32, meter: &Meter<'_>) -> bool {
        // What the witnesses say of the triangles that are still to be measured.
        let mut rest = self.places.known(place, &mut self.parts);
        let mut sum = 0.0;
        for turn in 0..self.ring.triangles() {
            let i = self.order[turn] as usize;
            rest = (rest - self.parts[i]).max(0.0);
            self.trial[i] = meter.fit(self.triangle(apex, i), limit - sum - rest);
            sum += self.trial[i].energy;
            // Not if it is no number, either.
            let below = sum + rest < limit && self.trial[i].worst <= farthest;
            if !below {
                if let Some(witness) = meter.note(self.trial[i], &mut self.witnesses) {
                    self.places.hear(&self.ring, &witness, meter);
                }
                self.order[turn / 2..=turn].rotate_right(1);
                return false;
            }
        }
        // Few places come so far.
        if !self.is_blunt_at(apex.at) {
            return false;
        }
        std::mem::swap(&mut self.fits, &mut self.trial);
        true
    }

    /// Settles the fits of the best apex, and says whether every triangle is within the tolerance.
    pub(super) fn settle(&mut self, apex: Vertex, judge: &Judge<'_>) -> bool {
        (0..self.ring.triangles()).fold(true, |all, i| {
            self.fits[i] = judge.settle(self.triangle(apex, i), self.fits[i]);
            all && self.fits[i].worst <= 1.0
        })
    }

    /// The exact test of every triangle and every spoke.
    pub(super) fn feasible(&self, apex: Vertex, judge: &Judge<'_>) -> bool {
        (0..self.ring.triangles()).all(|i| {
            let corners = self.triangle(apex, i);
            judge.feasible(corners) && judge.may_join(corners[0], corners[1])
        })
    }

    fn triangle(&self, apex: Vertex, i: usize) -> [Vertex; 3] {
        let [from, to] = self.ring.edge(i);
        [apex, from, to]
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
