//! The surface of a face over one row of samples.

use super::samples::Samples;

/// The surface over one row of samples, from the first one in the triangle on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    pub(super) row: i64,
    /// The column of the first sample.
    pub(super) first: i64,
    /// The height of corner a.
    pub(super) height: f64,
    /// The weights wb, wc at the first sample, and by how much they change from column to column.
    pub(super) weights: (f64, f64),
    pub(super) steps: (f64, f64),
    /// What a unit of each weight adds to the height.
    pub(super) slopes: (f64, f64),
}

/// The one of two errors that is farther from 0.
fn farther(before: f64, found: f64) -> f64 {
    if before.abs() >= found.abs() { before } else { found }
}

/// What samples next to each other come to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Errors {
    /// The largest error, as [`super::plane::Judged::error`] has it before it is refined.
    pub(super) largest: f64,
    /// NaN where some sample has no height.
    pub(super) sum_of_squares: f64,
}

impl Errors {
    /// From one value for each sample, the first one in column `first`, and what makes an error of column and value.
    #[inline(always)]
    fn of(first: f64, values: &[f64], error: impl Fn(f64, f64) -> f64) -> Errors {
        const LANES: usize = 8;
        let (lanes, rest) = values.as_chunks::<LANES>();
        let (mut largest, mut sums) = ([0.0f64; LANES], [0.0f64; LANES]);
        for (chunk, values) in lanes.iter().enumerate() {
            let first = first + (chunk * LANES) as f64;
            for (i, value) in values.iter().enumerate() {
                let error = error(first + i as f64, *value).abs();
                largest[i] = if error > largest[i] { error } else { largest[i] };
                sums[i] += error * error;
            }
        }
        let (mut largest_of_all, mut sum) = (0.0f64, 0.0);
        for (i, value) in rest.iter().enumerate() {
            let error = error(first + (lanes.len() * LANES + i) as f64, *value).abs();
            largest_of_all = if error > largest_of_all { error } else { largest_of_all };
            sum += error * error;
        }
        if !lanes.is_empty() {
            largest_of_all = largest.into_iter().fold(largest_of_all, f64::max);
            sum += sums.into_iter().sum::<f64>();
        }
        Errors { largest: largest_of_all, sum_of_squares: sum }
    }
}

impl Line {
    #[inline(always)]
    fn surface(&self, columns: f64) -> f64 {
        let (wb, wc) = (self.weights.0 + columns * self.steps.0, self.weights.1 + columns * self.steps.1);
        self.height + (wb * self.slopes.0 + wc * self.slopes.1)
    }

    /// The errors of these samples, the first one in column `first`.
    pub(super) fn errors(&self, first: i64, samples: &[f64]) -> Errors {
        Errors::of((first - self.first) as f64, samples, |column, sample| sample - self.surface(column))
    }

    /// The same, and in `errors` the height of the surface less that of each sample.
    pub(super) fn errors_into(&self, first: i64, samples: &[f64], errors: &mut [f64]) -> Errors {
        let first = (first - self.first) as f64;
        // Two loops that are vectors: what the second reads is at hand.
        for (i, (error, sample)) in (0i32..).zip(errors.iter_mut().zip(samples)) {
            *error = self.surface(first + f64::from(i)) - sample;
        }
        Errors::of(first, errors, |_, error| error)
    }

    /// Notes the height of the surface less that of the sample for each of these samples of the row, the first one in column
    /// `first`, where it is farther from 0 than what is there, or nothing is there. `samples` and `errors` are the whole row.
    #[inline]
    pub(super) fn note_errors(&self, (first, last): (i64, i64), samples: Samples<'_>, errors: &mut [f64]) {
        // Few, most often: those on the edges of a face.
        for column in first..=last {
            let surface = self.surface((column - self.first) as f64);
            let found = match samples.interval(column as usize) {
                Some([low, high]) => surface - surface.clamp(low, high),
                None => surface - samples.heights[column as usize],
            };
            let error = &mut errors[column as usize];
            *error = farther(*error, found);
        }
    }

    /// Hands those of the samples from the first of these columns to the last that have a height to `visit`: column, sample,
    /// the surface's height, and the error. `samples` is the whole row.
    pub(super) fn visit(&self, (first, last): (i64, i64), samples: &[f64], mut visit: impl FnMut(i64, f64, f64, f64)) {
        for column in first..=last {
            let sample = samples[column as usize];
            if sample.is_nan() {
                continue;
            }
            let surface = self.surface((column - self.first) as f64);
            visit(column, sample, surface, (sample - surface).abs());
        }
    }
}
