//! What a report shows beyond a verdict: shares of errors, errors by slope, shapes of triangles, maps.
//!
//! In come the faces and the rows with their errors as the sweep of `verify` passes them ([`Observer`]); out goes a [`Survey`].
//! There is no pass of its own. Each thread counts rows while the sweep has them in its cache, in pieces that depend on the raster
//! alone; they are put together in their order, so that sums are the same whatever the threads.
//!
//! Errors count as single floats. Memory: a [`MapGrid`], 4 bytes more for each square, 150 KiB for each thread, 16 KiB for each piece of a
//! band.

mod angles;
mod columns;
mod counting;
mod grid;
mod histogram;
mod line;
mod piece;
mod slopes;
#[cfg(test)]
mod tests;

use serde::Serialize;

use crate::base::{Band, GeoTransform, Reference};
use crate::verify::{ObservedRows, Observer, RowObserver};

pub use grid::{MapCell, MapGrid};
pub use slopes::SlopeClass;

use angles::Angles;
use grid::Square;
use histogram::{Binned, Total};
use piece::{Counter, Measure, Piece, Tally};
use slopes::{Class, FROM, Slopes};

/// Bins of signed errors on each side of 0, up to the tolerance.
pub const SIGNED: usize = 20;

/// What a raster is, as far as a report needs it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RasterFacts {
    /// Samples across.
    pub width: usize,
    /// Samples down.
    pub height: usize,
    /// The least x and y of samples, and the largest.
    pub extent: [f64; 4],
    /// The sides of a cell along rows and columns, in metres, in the middle of the raster; null where it does not say how long a
    /// unit of x and y is.
    pub cell_metres: Option<(f64, f64)>,
    /// What coordinates and heights mean.
    pub reference: Reference,
    /// Where samples lie on the map. Not part of reports.
    #[serde(skip)]
    pub geo_transform: GeoTransform,
}

impl RasterFacts {
    fn of(band: &Band) -> RasterFacts {
        let [_, xp, xl, _, yp, yl] = band.geo_transform().coefficients();
        let ((x, y), _) = band.in_metres();
        let is_known = band.is_georeferenced() && band.reference().metres.is_some();
        RasterFacts {
            width: band.width(),
            height: band.height(),
            extent: band.extent(),
            cell_metres: is_known.then(|| ((xp * x).hypot(yp * y), (xl * x).hypot(yl * y))),
            reference: band.reference().clone(),
            geo_transform: band.geo_transform(),
        }
    }
}

/// What a mesh's errors and triangles come to. Distances are vertical; where errors are weighted, shares are those of
/// distance × weight.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Survey {
    /// The raster.
    pub raster: RasterFacts,
    /// Samples that have a height and a surface over or under them.
    pub measured: u64,
    /// The mean of the surface's height less the sample's: above 0 where the mesh lies too high.
    pub mean_error: f64,
    /// Half of the samples, 90 %, 95 % and 99 % have at most this distance, rounded up by a thousandth of the tolerance at most (beyond
    /// the tolerance, by a thirty-second of the distance).
    pub p50: f64,
    /// See `p50`.
    pub p90: f64,
    /// See `p50`.
    pub p95: f64,
    /// See `p50`.
    pub p99: f64,
    /// All of them: the largest distance.
    pub p100: f64,
    /// Samples above nine tenths of the tolerance, those above it among them.
    pub above_nine_tenths: u64,
    /// Samples by signed error, surface less sample: below −ε, twenty bins up to 0, twenty up to ε, above ε.
    pub signed_errors: Vec<u64>,
    /// Samples at shares of 1 %, 2 % and so on to 100 %: their distances are at most this.
    pub cumulative: Vec<f64>,
    /// By the slope of the ground, as the differences of neighbouring heights say it. Samples without neighbours are left out.
    pub slopes: Vec<SlopeClass>,
    /// Triangles by the whole degrees of their smallest angle, seen from above with square cells.
    pub smallest_angles: Vec<u64>,
    /// Where.
    #[serde(skip)]
    pub map: MapGrid,
}

/// Gathers a [`Survey`].
pub(super) struct Surveyor {
    raster: RasterFacts,
    counter: Counter,
    map: MapGrid,
    /// The row of its squares that samples come into.
    row: Vec<Square>,
    /// Faces whose middle lies in each square.
    faces: Vec<u32>,
    histogram: Total,
    /// Samples below −ε and above ε.
    beyond: [u64; 2],
    sum: f64,
    /// By slope, as far as the histogram does not know it.
    classes: [Class; FROM.len()],
    angles: Angles,
}

impl Surveyor {
    pub(super) fn new(band: &Band, tolerance: f64) -> Surveyor {
        let histogram = Total::new(tolerance);
        let map = MapGrid::new((band.width(), band.height()));
        let measure = Measure { tolerance, slopes: Slopes::new(band), bins: histogram.bins() };
        Surveyor {
            raster: RasterFacts::of(band),
            counter: Counter::new(measure, map.side),
            row: vec![Square::default(); map.size.0],
            faces: vec![0; map.size.0 * map.size.1],
            map,
            histogram,
            beyond: [0; 2],
            sum: 0.0,
            classes: [Class::default(); FROM.len()],
            angles: Angles::new(),
        }
    }

    /// What was gathered, given the largest distance and the largest of what counts, distance or distance × weight: the verdict's, which
    /// are rounded once.
    pub(super) fn finish(mut self, worst: f64, largest: f64) -> Survey {
        self.counter.all().iter().for_each(|tally| self.add_up(tally));
        self.map.push(&self.row);
        self.map.cells.iter_mut().zip(&self.faces).for_each(|(cell, faces)| cell.faces = *faces);
        let measured = self.histogram.samples();
        let percents = (1..=100).map(|percent| f64::from(percent) / 100.0);
        let cumulative = self.histogram.shares(percents, largest);
        let share = |percent: usize| cumulative[percent - 1];
        let [low, high] = self.beyond;
        let mut signed = self.histogram.signed(2 * SIGNED);
        if self.counter.measure.tolerance == 0.0 {
            // All that is within is in the middle; the bins have counted by another scale.
            signed.fill(0);
            signed[SIGNED] = measured - low - high;
        }
        let slopes = self.classes.iter().zip(FROM).enumerate().map(|(index, (class, from))| {
            let Binned { samples, squares, max } = self.histogram.of_class(index);
            let mut class = *class;
            class.add(&Class { samples, above: 0, max, squares });
            class.max = class.max.min(worst);
            class.report(from)
        });
        Survey {
            raster: self.raster,
            measured,
            mean_error: if measured == 0 { 0.0 } else { self.sum / measured as f64 },
            p50: share(50),
            p90: share(90),
            p95: share(95),
            p99: share(99),
            p100: largest,
            above_nine_tenths: self.map.cells.iter().map(|cell| u64::from(cell.near)).sum(),
            signed_errors: [low].into_iter().chain(signed).chain([high]).collect(),
            cumulative,
            slopes: slopes.collect(),
            smallest_angles: self.angles.counts(),
            map: self.map,
        }
    }
}

impl Observer for Surveyor {
    fn face(&mut self, corners: [(i64, i64); 3], _: [f64; 3]) {
        self.faces[self.map.of_face(corners)] += 1;
        self.angles.count(corners);
    }

    fn row_observer(&self) -> Option<&dyn RowObserver> {
        Some(&self.counter)
    }

    fn needs_errors(&self) -> bool {
        false
    }

    fn rows(&mut self, _: &ObservedRows<'_>) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        let Surveyor { counter, map, row, sum, classes, .. } = self;
        counter.add_pieces(|piece| {
            *sum += piece.sum;
            classes.iter_mut().zip(&piece.classes).for_each(|(class, other)| class.add(other));
            add_squares(piece, map, row);
        });
        let full: Vec<Tally> = self.counter.full().collect();
        full.iter().for_each(|tally| self.add_up(tally));
        Ok(())
    }
}

impl Surveyor {
    fn add_up(&mut self, tally: &Tally) {
        self.histogram.add(&tally.histogram);
        self.beyond = [self.beyond[0] + tally.low, self.beyond[1] + tally.high];
    }
}

/// Adds the squares of the next piece to `row`, and rows that are complete to the map.
fn add_squares(piece: &Piece, map: &mut MapGrid, row: &mut [Square]) {
    for (at, squares) in (piece.row / map.side..).zip(piece.squares.chunks(map.size.0)) {
        if at * map.size.0 > map.cells.len() {
            map.push(row);
            row.fill(Square::default());
        }
        row.iter_mut().zip(squares).for_each(|(sum, square)| sum.add(square));
    }
}
