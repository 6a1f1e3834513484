//! A survey against a naive one, sample by sample.

use std::sync::Arc;

use proptest::prelude::*;

use super::grid::Square;
use super::slopes::FROM;
use super::*;
use crate::base::{RasterError, SampleType, Window, Windows};

struct Nothing;

impl Windows for Nothing {
    fn read(&self, _: Window, _: &mut [u8]) -> Result<(), RasterError> {
        unreachable!("a survey is told its samples")
    }
}

/// Heights and errors, NaN where there are none, of a raster of this size, and what is above the tolerance.
struct Told {
    size: (usize, usize),
    tolerance: f64,
    heights: Vec<f64>,
    errors: Vec<f32>,
    marks: Vec<u8>,
}

impl Told {
    fn new(size: (usize, usize), tolerance: f64, (gaps, spread): (u64, f64), seed: u64) -> Told {
        let mut state = seed;
        let mut random = |below: u64| {
            state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (state >> 33) % below
        };
        let (mut heights, mut errors, mut marks) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..size.0 * size.1 {
            let is_gap = gaps > 0 && random(gaps) == 0;
            let is_bare = gaps > 0 && random(gaps) == 0;
            heights.push(if is_gap { f64::NAN } else { random(4000) as f64 / 1000.0 });
            let error = (random(20_001) as f64 / 10_000.0 - 1.0) * spread * tolerance;
            errors.push(if is_gap || is_bare { f32::NAN } else { error as f32 });
            marks.push(if error.abs() > tolerance { ObservedRows::ABOVE } else { 0 });
        }
        Told { size, tolerance, heights, errors, marks }
    }

    fn surveyed(&self, rows: usize) -> Survey {
        let (width, height) = self.size;
        let band = Band::new("told", self.size, SampleType::F64, Arc::new(Nothing)).unwrap();
        let mut surveyor = Surveyor::new(&band, self.tolerance);
        let all = (self.heights.as_slice(), self.errors.as_slice(), self.marks.as_slice());
        for first in (0..height).step_by(rows) {
            let band = first..(first + rows).min(height);
            // Pieces come in any order.
            for row in band.clone().step_by(2).rev() {
                let observer = surveyor.row_observer().expect("a survey counts rows");
                observer.rows(&ObservedRows::marked(row..(row + 2).min(band.end), width, all));
            }
            surveyor.rows(&ObservedRows::marked(band, width, all)).unwrap();
        }
        let worst = self.errors.iter().fold(0f32, |worst, error| worst.max(error.abs()));
        surveyor.finish(worst.into(), worst.into())
    }

    fn height(&self, column: usize, row: usize) -> Option<f64> {
        let at = row * self.size.0 + column;
        (column < self.size.0).then(|| self.heights[at]).filter(|height| !height.is_nan())
    }

    /// The class of a slope, cells being 1 by 1.
    fn class(&self, column: usize, row: usize) -> Option<usize> {
        let here = self.height(column, row)?;
        let left = column.checked_sub(1).and_then(|left| self.height(left, row));
        let across = match (left, self.height(column + 1, row)) {
            (Some(left), Some(right)) => (right - left) / 2.0,
            (Some(left), None) => here - left,
            (None, Some(right)) => right - here,
            (None, None) => return None,
        };
        let down = if row == 0 { 0.0 } else { here - self.height(column, row - 1)? };
        let degrees = across.hypot(down).atan().to_degrees();
        FROM.iter().rposition(|from| degrees >= *from)
    }

    fn check(&self, survey: &Survey) {
        let (width, height) = self.size;
        let side = survey.map.side;
        let mut cells = vec![Square::default(); survey.map.size.0 * survey.map.size.1];
        let mut classes = [Class::default(); FROM.len()];
        let (mut sum, mut beyond) = (0.0, [0, 0]);
        for (column, row) in (0..height).flat_map(|row| (0..width).map(move |column| (column, row))) {
            let at = row * width + column;
            let Some(here) = self.height(column, row) else { continue };
            let cell = &mut cells[row / side * survey.map.size.0 + column / side];
            cell.heights += 1;
            cell.sum += here;
            let (error, is_above) = (self.errors[at], self.marks[at] != 0);
            if error.is_nan() {
                continue;
            }
            sum += f64::from(error);
            cell.measured += 1;
            cell.max = cell.max.max(error.abs());
            cell.near += u32::from(error.abs() > (0.9 * self.tolerance) as f32);
            cell.above += u32::from(is_above);
            beyond[usize::from(error > 0.0)] += u64::from(is_above);
            if let Some(class) = self.class(column, row) {
                let distance = f64::from(error.abs());
                let squares = distance * distance;
                classes[class].add(&Class { samples: 1, above: u64::from(is_above), max: distance, squares });
            }
        }
        assert_eq!(survey.map.cells.len(), cells.len());
        for (found, expected) in survey.map.cells.iter().zip(&cells) {
            let Square { measured, heights, near, above, max, sum } = *expected;
            let height = sum / f64::from(heights);
            assert!((found.height - height).abs() <= 1e-6 || height.is_nan(), "{found:?} {expected:?}");
            assert_eq!(found.height.is_nan(), height.is_nan());
            assert_eq!(
                MapCell { height: 0.0, ..*found },
                MapCell { measured, near, above, faces: 0, max, height: 0.0 }
            );
        }
        let measured = cells.iter().map(|cell| u64::from(cell.measured)).sum::<u64>();
        assert_eq!(survey.measured, measured);
        let signed = &survey.signed_errors;
        assert_eq!((signed.iter().sum::<u64>(), [signed[0], signed[signed.len() - 1]]), (measured, beyond));
        assert!((survey.mean_error - sum / measured.max(1) as f64).abs() <= 1e-6 * self.tolerance);
        for (found, expected) in survey.slopes.iter().zip(classes) {
            let expected = expected.report(found.from_degrees);
            assert_eq!((found.samples, found.above_tolerance), (expected.samples, expected.above_tolerance));
            let bin = self.tolerance / 999.0;
            // What is less than 1/512 of a bin beyond an end counts before it.
            assert!((-bin / 500.0..bin).contains(&(found.max - expected.max)), "{found:?} {expected:?}");
            assert!((found.rms - expected.rms).abs() < bin, "{found:?} {expected:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn a_survey_is_what_every_sample_by_itself_says(
        width in prop_oneof![2usize..5, 250usize..530, 2040usize..2100], height in 2usize..12, rows in 1usize..13,
        gaps in prop_oneof![Just(0u64), Just(2), Just(40), Just(5000)], spread in prop_oneof![Just(0.01), Just(1.0), Just(1.1)],
        seed in 0u64..u64::MAX,
    ) {
        let told = Told::new((width, height), 2.5, (gaps, spread), seed);
        told.check(&told.surveyed(rows));
    }
}

#[test]
fn squares_of_many_samples_are_put_together() {
    let told = Told::new((1100, 70), 3.0, (9000, 1.0), 7);
    let survey = told.surveyed(32);
    assert_eq!(survey.map.side, 3);
    told.check(&survey);
}

/// Of two triangles over a sample the worse one may have no height to tell.
#[test]
fn what_is_above_without_an_error_has_a_bar() {
    let mut told = Told::new((4, 3), 1.0, (0, 0.0), 7);
    told.marks[5] = ObservedRows::ABOVE;
    let survey = told.surveyed(3);
    assert_eq!((survey.measured, survey.signed_errors.iter().sum::<u64>()), (12, 12));
    assert_eq!(survey.signed_errors.last(), Some(&1));
}
