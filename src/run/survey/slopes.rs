//! Errors by the steepness of the ground.

use serde::Serialize;

use crate::base::{Band, Metres, metres_in};

/// Where classes begin, in degrees.
pub(super) const FROM: [f64; 8] = [0.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0, 45.0];

/// What stands for the class where there is none.
pub(super) const NO_CLASS: usize = FROM.len();

/// The errors of samples of about the same slope.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SlopeClass {
    /// Slopes from here on, in degrees, up to where the next class begins.
    pub from_degrees: f64,
    /// How many samples.
    pub samples: u64,
    /// Of these, above the tolerance.
    pub above_tolerance: u64,
    /// The largest error, rounded up by a thousandth of the tolerance at most.
    pub max: f64,
    /// The root of the mean square, give or take a thousandth of the tolerance.
    pub rms: f64,
}

/// What one class comes to.
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
    per_two_across: f32,
    per_down: f32,
}

impl Slopes {
    pub(super) fn new(band: &Band) -> Slopes {
        let height_unit = metres_in(&band.reference().height_unit).unwrap_or(1.0);
        let squared = FROM.map(|from| from.to_radians().tan().powi(2) as f32);
        Slopes { band: band.clone(), height_unit, squared }
    }

    /// The cells of a row: where x and y are degrees they are shorter the nearer they are to a pole.
    pub(super) fn cell(&self, row: usize) -> Cell {
        let transform = self.band.geo_transform();
        let [_, xp, xl, _, yp, yl] = transform.coefficients();
        let (_, y) = transform.place((self.band.width() - 1) as f64 / 2.0, row as f64);
        let (mx, my) = Metres::between(self.band.reference().metres, y, y);
        let sides = ((xp * mx).hypot(yp * my), (xl * mx).hypot(yl * my));
        let [across, down] = [2.0 * sides.0, sides.1].map(|side| (self.height_unit / side) as f32);
        Cell { per_two_across: across, per_down: down }
    }

    /// The class of a slope, by the square of its tangent, a number.
    #[inline(always)]
    pub(super) fn class(&self, squared: f32) -> u32 {
        // The first class begins at 0.
        let mut class = 0;
        for from in &self.squared[1..] {
            class += u32::from(squared >= *from);
        }
        class
    }
}

impl Cell {
    /// The square of a slope's tangent, from the rise along a row over two cells, and that along a column over one.
    #[inline(always)]
    pub(super) fn squared(self, across: f64, down: f64) -> f32 {
        let (x, y) = (across as f32 * self.per_two_across, down as f32 * self.per_down);
        x * x + y * y
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::base::{RasterError, SampleType, Window, Windows};

    struct Nothing;

    impl Windows for Nothing {
        fn read(&self, _: Window, out: &mut [u8]) -> Result<(), RasterError> {
            out.fill(0);
            Ok(())
        }
    }

    #[test]
    fn classes_are_those_that_comparing_finds() {
        let slopes = Slopes::new(&Band::new("flat", (2, 2), SampleType::F32, Arc::new(Nothing)).unwrap());
        let mut tried: Vec<f64> = (0..=9000).map(|i| (f64::from(i) / 100.0).to_radians().tan().powi(2)).collect();
        tried.extend([1e-300, 1e300, f64::INFINITY]);
        tried.extend(FROM.map(|from| f64::from(from.to_radians().tan().powi(2) as f32)));
        for squared in tried {
            let expected = FROM.iter().rposition(|from| squared as f32 >= from.to_radians().tan().powi(2) as f32);
            assert_eq!(slopes.class(squared as f32) as usize, expected.unwrap(), "{squared}");
        }
        let flat = slopes.cell(0);
        assert_eq!((flat.squared(2.0, 0.0), flat.squared(6.0, 4.0)), (1.0, 25.0));
    }
}
