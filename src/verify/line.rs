//! The surface of a face over one row of samples.

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

/// What samples next to each other come to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Errors {
    /// The largest error, as [`super::plane::Judged::error`] has it before it is refined.
    pub(super) largest: f64,
    /// NaN where some sample has no height.
    pub(super) sum_of_squares: f64,
}

/// Samples that are taken side by side, as vectors.
const LANES: usize = 8;

/// The largest error and the sum of squares, lane by lane.
#[derive(Default)]
struct Sums {
    largest: [f64; LANES],
    squares: [f64; LANES],
}

impl Sums {
    #[inline(always)]
    fn take<const N: usize>(&mut self, errors: [f64; N]) {
        for (i, error) in errors.into_iter().enumerate() {
            let error = error.abs();
            self.largest[i] = if error > self.largest[i] { error } else { self.largest[i] };
            self.squares[i] += error * error;
        }
    }
}

impl Errors {
    fn of(lanes: Sums, rest: Sums) -> Errors {
        let largest = lanes.largest.into_iter().fold(rest.largest[0], f64::max);
        Errors { largest, sum_of_squares: rest.squares[0] + lanes.squares.into_iter().sum::<f64>() }
    }
}

impl Line {
    #[inline(always)]
    fn surface(&self, columns: f64) -> f64 {
        let (wb, wc) = (self.weights.0 + columns * self.steps.0, self.weights.1 + columns * self.steps.1);
        self.height + (wb * self.slopes.0 + wc * self.slopes.1)
    }

    /// The height of the surface minus the height of each sample. `columns` is how far the first of them is from the first of the line.
    #[inline(always)]
    fn signed<const N: usize>(&self, columns: f64, samples: &[f64; N]) -> [f64; N] {
        let mut errors = [0.0; N];
        for i in 0..N {
            errors[i] = self.surface(columns + i as f64) - samples[i];
        }
        errors
    }

    /// The errors of these samples, the first one in column `first`.
    pub(super) fn errors(&self, first: i64, samples: &[f64]) -> Errors {
        let first = (first - self.first) as f64;
        let (chunks, rest) = samples.as_chunks::<LANES>();
        let (mut lanes, mut last) = (Sums::default(), Sums::default());
        for (i, samples) in chunks.iter().enumerate() {
            lanes.take(self.signed(first + (i * LANES) as f64, samples));
        }
        for (i, sample) in rest.iter().enumerate() {
            last.take(self.signed(first + (chunks.len() * LANES + i) as f64, &[*sample]));
        }
        Errors::of(lanes, last)
    }

    /// The same, and in `errors` the height of the surface less that of each sample.
    pub(super) fn errors_into(&self, first: i64, samples: &[f64], errors: &mut [f32]) -> Errors {
        let first = (first - self.first) as f64;
        let ((chunks, rest), (noted, last_noted)) = (samples.as_chunks::<LANES>(), errors.as_chunks_mut::<LANES>());
        let (mut lanes, mut last) = (Sums::default(), Sums::default());
        for (i, (samples, noted)) in chunks.iter().zip(noted).enumerate() {
            let errors = self.signed(first + (i * LANES) as f64, samples);
            for lane in 0..LANES {
                noted[lane] = errors[lane] as f32;
            }
            lanes.take(errors);
        }
        for (i, (sample, noted)) in rest.iter().zip(last_noted).enumerate() {
            let error = self.signed(first + (chunks.len() * LANES + i) as f64, &[*sample]);
            *noted = error[0] as f32;
            last.take(error);
        }
        Errors::of(lanes, last)
    }

    /// Hands those of the samples from the first of these columns to the last that have a height to `visit`: column, sample,
    /// the surface's height, and the error. `samples` is the whole row.
    #[inline(always)]
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
