//! Errors by the steepness of the ground.

use serde::Serialize;

use crate::base::{Band, Metres, metres_in};

/// Where classes begin, in degrees.
pub(super) const FROM: [f64; 8] = [0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0];

/// The errors of samples of about the same slope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlopeClass {
    /// Slopes from here on, in degrees, up to where the next class begins.
    pub from_degrees: f64,
    /// How many samples.
    pub samples: u64,
    /// Of these, above the tolerance.
    pub above_tolerance: u64,
    /// The largest error.
    pub max: f64,
    /// The root of the mean square.
    pub rms: f64,
}

/// What one class comes to so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Class {
    pub(super) samples: u64,
    pub(super) above: u64,
    pub(super) max: f64,
    pub(super) squares: f64,
}

impl Class {
    pub(super) fn add(&mut self, other: &Class) {
        self.samples += other.samples;
        self.above += other.above;
        self.max = self.max.max(other.max);
        self.squares += other.squares;
    }

    pub(super) fn report(&self, from_degrees: f64) -> SlopeClass {
        let rms = if self.samples == 0 { 0.0 } else { (self.squares / self.samples as f64).sqrt() };
        let Class { samples, above: above_tolerance, max, .. } = *self;
        SlopeClass { from_degrees, samples, above_tolerance, max, rms }
    }
}

/// What turns differences of heights into slopes.
#[derive(Debug, Clone)]
pub(super) struct Slopes {
    band: Band,
    /// Metres in a unit of heights.
    height_unit: f64,
    /// The squares of the tangents at which classes begin.
    squared: [f32; FROM.len()],
}

/// The sides of cells of one row in units of heights, as what slopes are rises times.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    per_across: f64,
    per_down: f64,
}

impl Slopes {
    pub(super) fn new(band: &Band) -> Slopes {
        let height_unit = metres_in(&band.reference().height_unit).unwrap_or(1.0);
        let squared = FROM.map(|degrees| degrees.to_radians().tan().powi(2) as f32);
        Slopes { band: band.clone(), height_unit, squared }
    }

    /// The cells of a row: where x and y are degrees they are shorter the nearer they are to a pole.
    pub(super) fn cell(&self, row: usize) -> Cell {
        let transform = self.band.geo_transform();
        let [_, xp, xl, _, yp, yl] = transform.coefficients();
        let (_, y) = transform.place((self.band.width() - 1) as f64 / 2.0, row as f64);
        let (mx, my) = Metres::between(self.band.reference().metres, y, y);
        let sides = ((xp * mx).hypot(yp * my), (xl * mx).hypot(yl * my));
        Cell { per_across: self.height_unit / sides.0, per_down: self.height_unit / sides.1 }
    }

    /// The class of a slope, by the square of its tangent.
    #[inline(always)]
    pub(super) fn class(&self, squared: f64) -> u32 {
        let squared = squared as f32;
        // The first class begins at 0.
        self.squared[1..].iter().map(|from| u32::from(squared >= *from)).sum()
    }
}

impl Cell {
    /// The square of a slope's tangent, from the rises along a row and along a column, a cell each.
    #[inline(always)]
    pub(super) fn squared(self, across: f64, down: f64) -> f64 {
        let (x, y) = (across * self.per_across, down * self.per_down);
        x * x + y * y
    }
}
