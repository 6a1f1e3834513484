//! How far the triangles of a tile are from heights at places in rows and columns, as samples of the grid are, and those of a raster in longitude
//! and latitude.
//!
//! Triangle by triangle and row by row: where a row surely lies in the triangle ([`super::facet`]), few operations for each height tell whether any may be off by
//! more than what is known already, and only those that may are met one by one. So the largest error is exact, and what is beyond the limit is
//! counted exactly. Where it is not sure that a place is in a triangle, its normal is met if an error there would count. If not, it is enough that the triangles
//! that may have a place are such: where triangles tile the square, one of them has it, or goes on beyond its chord there. Where they do
//! not, and beside holes, normals are always met. A place that no triangle was found for is handed back.
//!
//! The height of a plane over a place, with n its normal, A a point of it, S the place on the ellipsoid and N the normal there, is n·(A − S) ÷ n·N;
//! along a row only x = n₀ cos λ + n₁ sin λ changes, of which both are linear functions.

use std::collections::BTreeMap;

use super::ellipsoid::{Meridian, Parallel};
use super::facet::{Facet, Plane, Spans};
use super::facets::{Facets, Window, error};

/// What the quick way may be off by, in metres on level ground, with what rounding adds to an error.
const MARGIN: f64 = 1e-6;

/// Heights that are looked at together.
const LANES: usize = 8;

/// Places in rows and columns, and heights there.
pub(super) struct Lattice<'a> {
    /// Where its columns and rows are in the tile, ascending.
    pub(super) columns: &'a [f64],
    pub(super) rows: &'a [f64],
    pub(super) meridians: &'a [Meridian],
    pub(super) parallels: &'a [Parallel],
    /// Row by row, with so many from one to the next.
    pub(super) heights: &'a [f64],
    pub(super) stride: usize,
    /// At which of them a triangle is looked for, and at which its error counts.
    pub(super) covers: &'a [bool],
    pub(super) binds: &'a [bool],
}

/// What was found. Numbers are those of heights.
#[derive(Default)]
pub(super) struct Scanned {
    /// The largest error, if it is larger than what was known.
    pub(super) largest: f64,
    /// Errors that are larger than allowed.
    pub(super) beyond: BTreeMap<usize, f64>,
    /// Places where no triangle was found that is met.
    pub(super) unmet: Vec<usize>,
}

/// What errors are compared with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// One as large was found already.
    pub(super) known: f64,
    pub(super) allowed: f64,
}

impl Facets {
    /// Ready for single places of a lattice.
    pub(super) fn around(&self, lattice: &Lattice<'_>) -> Window<'_> {
        let ends = |places: &[f64]| match (places.first(), places.last()) {
            (Some(first), Some(last)) => (first.floor() as i64, last.floor() as i64 + 1 - first.floor() as i64),
            _ => (0, 0),
        };
        let (columns, rows) = (ends(lattice.columns), ends(lattice.rows));
        self.over((columns.0, rows.0), (columns.1, rows.1))
    }

    /// Finds the errors at a lattice.
    pub(super) fn scan(&self, lattice: &Lattice<'_>, limits: Limits) -> Scanned {
        let unsettled = if self.is_tiling { Place::Near } else { Place::Unmet };
        let Lattice { columns, rows, .. } = lattice;
        let (Some(ends), Some(row_ends)) = (columns.first().zip(columns.last()), rows.first().zip(rows.last())) else {
            return Scanned::default();
        };
        let places = vec![Place::Unmet; rows.len() * columns.len()];
        let mut scan = Scan { lattice, limits, unsettled, places, found: Scanned::default(), turned: Vec::new() };
        for facet in &self.all {
            let meets = |(low, high): (f64, f64), (first, last): (&f64, &f64)| low <= *last && high >= *first;
            if meets(facet.bounds[0], ends) && meets(facet.bounds[1], row_ends) {
                scan.facet(facet);
            }
        }
        for (row, places) in scan.places.chunks_exact(columns.len()).enumerate() {
            let first = row * lattice.stride;
            let covers = &lattice.covers[first..first + columns.len()];
            let is_open = |covers: bool, place: Place| covers & (place as u8 <= Place::Open as u8);
            if places.iter().zip(covers).fold(false, |any, (&place, &covers)| any | is_open(covers, place)) {
                let open = (0..columns.len()).filter(|&i| is_open(covers[i], places[i]));
                scan.found.unmet.extend(open.map(|i| first + i));
            }
        }
        scan.found
    }
}

/// What is known of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(u8)]
enum Place {
    /// No triangle was found.
    Unmet,
    /// One is not met that would count if it goes on beyond its chord.
    Open,
    /// Of those that may have it none counts.
    Near,
    /// One is met.
    Met,
}

struct Scan<'a> {
    lattice: &'a Lattice<'a>,
    limits: Limits,
    /// What a place is that a triangle may have which does not count.
    unsettled: Place,
    places: Vec<Place>,
    found: Scanned,
    /// x of every column that a triangle may have.
    turned: Vec<f64>,
}

/// A plane over a row: facing n·N and n·(A − S) are functions of x.
struct OverRow {
    cos: f64,
    vertical: f64,
    reach: f64,
    offset: f64,
    limit: f64,
}

impl OverRow {
    fn new(plane: &Plane, parallel: &Parallel, limit: f64) -> OverRow {
        let up = plane.direction[2];
        let (vertical, offset) = (up * parallel.sin, plane.offset - up * parallel.rise);
        OverRow { cos: parallel.cos, vertical, reach: parallel.reach, offset, limit }
    }

    /// Not above 0 where the error is surely within the limit.
    #[inline(always)]
    fn excess(&self, x: f64, height: f64) -> f64 {
        let facing = self.cos * x + self.vertical;
        (self.offset - self.reach * x - height * facing).abs() - self.limit * facing + MARGIN
    }

    /// Whether all are surely within the limit.
    fn has_all(&self, turned: &[f64], heights: &[f64]) -> bool {
        let mut most = [f64::NEG_INFINITY; LANES];
        let (xs, zs) = (turned.chunks_exact(LANES), heights.chunks_exact(LANES));
        let is_rest_within = xs.remainder().iter().zip(zs.remainder()).all(|(&x, &z)| self.excess(x, z) <= 0.0);
        for (xs, zs) in xs.zip(zs) {
            for lane in 0..LANES {
                let excess = self.excess(xs[lane], zs[lane]);
                most[lane] = if excess > most[lane] { excess } else { most[lane] };
            }
        }
        is_rest_within && most.iter().all(|most| *most <= 0.0)
    }
}

impl Scan<'_> {
    fn limit(&self) -> f64 {
        self.limits.known.max(self.found.largest).min(self.limits.allowed)
    }

    fn facet(&mut self, facet: &Facet) {
        let Lattice { columns, rows, meridians, parallels, stride, .. } = *self.lattice;
        // One of no area is not met.
        let Some(plane) = facet.plane() else { return };
        let (first, end) = between(columns, facet.bounds[0]);
        self.turned.clear();
        self.turned.extend(meridians[first..end].iter().map(|meridian| meridian.forward(plane.direction)));
        let (top, bottom) = between(rows, facet.bounds[1]);
        for row in top..bottom {
            let Spans { outer, inner } = facet.spans(rows[row]);
            let (left, right) = between(columns, outer);
            if left >= right {
                continue;
            }
            let (from, to) = between(columns, inner);
            let (from, to) = if from < to { (from, to) } else { (left, left) };
            let over = OverRow::new(&plane, &parallels[row], self.limit());
            let heights = &self.lattice.heights[row * stride..];
            let place = row * columns.len();
            self.places[place + from..place + to].fill(Place::Met);
            let excess = |scan: &Scan<'_>, column: usize| over.excess(scan.turned[column - first], heights[column]);
            let binds = &self.lattice.binds[row * stride..];
            if !over.has_all(&self.turned[from - first..to - first], &heights[from..to]) {
                for column in (from..to).filter(|&column| binds[column]) {
                    if excess(self, column) > 0.0 {
                        self.judge(facet, row, column, false);
                    }
                }
            }
            for column in (left..from).chain(to..right) {
                let excess = excess(self, column);
                let counts = binds[column] && (excess.is_nan() || excess > 0.0);
                let place = self.places[place + column];
                if !counts && place == Place::Unmet && self.unsettled == Place::Near {
                    self.places[row * columns.len() + column] = Place::Near;
                } else if counts || place == Place::Unmet {
                    self.judge(facet, row, column, true);
                }
            }
        }
    }

    /// Meets a triangle at a place, on its plane or inside.
    fn judge(&mut self, facet: &Facet, row: usize, column: usize, inside: bool) {
        let Lattice { meridians, parallels, heights, stride, columns, binds, covers, .. } = *self.lattice;
        let i = row * stride + column;
        if !covers[i] {
            return;
        }
        let place = &mut self.places[row * columns.len() + column];
        match facet.meet(parallels[row].foot(meridians[column]), inside) {
            Some(found) => {
                *place = Place::Met;
                if binds[i] {
                    self.found.add(i, error(found, heights[i]), self.limits.allowed);
                }
            }
            // Turned over in space, none is met.
            None if !inside || *place != Place::Met => {
                *place = if self.unsettled == Place::Near { Place::Open } else { Place::Unmet }
            }
            None => {}
        }
    }
}

impl Scanned {
    /// Counts an error; of one place the largest does.
    pub(super) fn add(&mut self, i: usize, error: f64, allowed: f64) {
        self.largest = self.largest.max(error);
        if error.is_nan() || error > allowed {
            let most = self.beyond.entry(i).or_insert(error);
            *most = most.max(error);
        }
    }
}

/// The first of some ascending places that is not before an interval, and that behind its last one.
fn between(places: &[f64], (low, high): (f64, f64)) -> (usize, usize) {
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return (0, 0) };
    let count = places.len();
    let scale = if last > first { (count - 1) as f64 / (last - first) } else { 0.0 };
    // They are as far from each other, almost.
    let guess = |at: f64| (((at - first) * scale).max(0.0) as usize).min(count);
    let (mut from, mut to) = (guess(low), guess(high));
    while from > 0 && places[from - 1] >= low {
        from -= 1;
    }
    while from < count && places[from] < low {
        from += 1;
    }
    while to > 0 && places[to - 1] > high {
        to -= 1;
    }
    while to < count && places[to] <= high {
        to += 1;
    }
    (from, to)
}
