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

impl Line {
    #[inline(always)]
    fn surface(&self, columns: f64) -> f64 {
        let (wb, wc) = (self.weights.0 + columns * self.steps.0, self.weights.1 + columns * self.steps.1);
        self.height + (wb * self.slopes.0 + wc * self.slopes.1)
    }

    /// The errors of these samples, the first one in column `first`.
    pub(super) fn errors(&self, first: i64, samples: &[f64]) -> Errors {
        const LANES: usize = 8;
        let first = (first - self.first) as f64;
        let (lanes, rest) = samples.as_chunks::<LANES>();
        let (mut largest, mut sums) = ([0.0f64; LANES], [0.0f64; LANES]);
        for (chunk, samples) in lanes.iter().enumerate() {
            let first = first + (chunk * LANES) as f64;
            for (i, sample) in samples.iter().enumerate() {
                let error = (sample - self.surface(first + i as f64)).abs();
                largest[i] = if error > largest[i] { error } else { largest[i] };
                sums[i] += error * error;
            }
        }
        let (mut largest_of_all, mut sum) = (0.0f64, 0.0);
        for (i, sample) in rest.iter().enumerate() {
            let error = (sample - self.surface(first + (lanes.len() * LANES + i) as f64)).abs();
            largest_of_all = if error > largest_of_all { error } else { largest_of_all };
            sum += error * error;
        }
        if !lanes.is_empty() {
            largest_of_all = largest.into_iter().fold(largest_of_all, f64::max);
            sum += sums.into_iter().sum::<f64>();
        }
        Errors { largest: largest_of_all, sum_of_squares: sum }
    }

    /// Notes the height of the surface less that of the sample for each of these samples of the row, the first one in column
    /// `first`, where it is farther from 0 than what is there, or nothing is there. `samples` and `errors` are the whole row.
    pub(super) fn note_errors(&self, (first, last): (i64, i64), samples: Samples<'_>, errors: &mut [f64]) {
        let intervals = (first..=last).filter_map(|column| Some((column, samples.interval(column as usize)?)));
        let noted: Vec<(i64, [f64; 2], f64)> = intervals.map(|(at, ends)| (at, ends, errors[at as usize])).collect();
        self.note_all((first, last), samples.heights, errors);
        for (column, [low, high], before) in noted {
            let surface = self.surface((column - self.first) as f64);
            errors[column as usize] = farther(before, surface - surface.clamp(low, high));
        }
    }

    fn note_all(&self, (first, last): (i64, i64), samples: &[f64], errors: &mut [f64]) {
        const LANES: usize = 8;
        let columns = first as usize..=last as usize;
        let first = (first - self.first) as f64;
        let (errors, last_errors) = errors[columns.clone()].as_chunks_mut::<LANES>();
        let (samples, last_samples) = samples[columns].as_chunks::<LANES>();
        for (chunk, (errors, samples)) in errors.iter_mut().zip(samples).enumerate() {
            let first = first + (chunk * LANES) as f64;
            for i in 0..LANES {
                errors[i] = farther(errors[i], self.surface(first + i as f64) - samples[i]);
            }
        }
        let first = first + (samples.len() * LANES) as f64;
        for (i, (error, sample)) in (0i32..).zip(last_errors.iter_mut().zip(last_samples)) {
            *error = farther(*error, self.surface(first + f64::from(i)) - sample);
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
