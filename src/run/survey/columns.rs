//! What samples come to that lie in one column, as vectors add it up.

use std::ops::Range;

use super::line::Line;

/// Samples of a row that are taken together: what is made of them step by step stays in the cache.
pub(super) const STRETCH: usize = 256;
/// Numbers that are added up side by side, in sums of their own.
pub(super) const LANES: usize = 8;

/// What samples come to that lie in one column, in a stretch of columns and in one row of squares.
pub(super) struct Columns {
    /// Rows of which all samples were counted that are not at an end of the row.
    pub(super) rows: u32,
    /// Samples of other rows.
    pub(super) measured: [u32; STRETCH],
    near: [u32; STRETCH],
    /// The bits of distances, which are in the same order.
    max: [i32; STRETCH],
    pub(super) errors: [f32; STRETCH],
    heights: [f64; STRETCH],
}

impl Columns {
    pub(super) const NONE: Columns = Columns {
        rows: 0,
        measured: [0; STRETCH],
        near: [0; STRETCH],
        max: [0; STRETCH],
        errors: [0.0; STRETCH],
        heights: [0.0; STRETCH],
    };

    /// Adds samples of some rows that are plain: from column `first` on, to what is at `at`.
    #[inline(always)]
    pub(super) fn add<const N: usize>(&mut self, lines: [Line<'_>; N], first: usize, at: usize, count: usize) {
        // Numbers that are not negative are in the order of their bits.
        let nearly = lines[0].measure.nearly().to_bits() as i32;
        let errors: [&[f32]; N] = std::array::from_fn(|i| &lines[i].errors[first..][..count]);
        let heights: [&[f64]; N] = std::array::from_fn(|i| &lines[i].heights[first..][..count]);
        let (near, max) = (&mut self.near[at..][..count], &mut self.max[at..][..count]);
        let (sums, of_heights) = (&mut self.errors[at..][..count], &mut self.heights[at..][..count]);
        // The loops are simple ones, so that all of them become vectors.
        for i in 0..count {
            for errors in &errors {
                let distance = errors[i].abs().to_bits() as i32;
                max[i] = max[i].max(distance);
                near[i] += u32::from(distance > nearly);
            }
        }
        for i in 0..count {
            let mut sum = 0.0;
            for errors in &errors {
                sum += errors[i];
            }
            sums[i] += sum;
        }
        for i in 0..count {
            let mut sum = 0.0;
            for heights in &heights {
                sum += heights[i];
            }
            of_heights[i] += sum;
        }
    }
}

/// What the columns of a square come to.
pub(super) struct Sum {
    pub(super) measured: u32,
    pub(super) near: u32,
    pub(super) max: i32,
    pub(super) heights: f64,
}

impl Sum {
    // With plain loops: what iterators are made of is not always compiled for the processor.
    #[inline(always)]
    pub(super) fn of(columns: &Columns, at: Range<usize>) -> Sum {
        let (near, last_near) = columns.near[at.clone()].as_chunks::<LANES>();
        let (max, last_max) = columns.max[at.clone()].as_chunks::<LANES>();
        let (heights, last_heights) = columns.heights[at.clone()].as_chunks::<LANES>();
        let mut lanes = ([0; LANES], [0; LANES], [0.0; LANES]);
        for chunk in 0..near.len() {
            for i in 0..LANES {
                lanes.0[i] += near[chunk][i];
                lanes.1[i] = lanes.1[i].max(max[chunk][i]);
                lanes.2[i] += heights[chunk][i];
            }
        }
        let mut sum = Sum { measured: 0, near: 0, max: 0, heights: by_halves(lanes.2) };
        for i in 0..LANES {
            sum.near += lanes.0[i];
            sum.max = sum.max.max(lanes.1[i]);
        }
        for i in 0..last_near.len() {
            sum.near += last_near[i];
            sum.max = sum.max.max(last_max[i]);
            sum.heights += last_heights[i];
        }
        for measured in &columns.measured[at] {
            sum.measured += measured;
        }
        sum
    }
}

/// The sum of numbers of which few wait for each other.
#[inline(always)]
fn by_halves([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The sum of errors, by halves; what is in `errors` is used up.
#[inline(always)]
pub(super) fn sum(errors: &mut [f32; STRETCH]) -> f64 {
    let mut half = STRETCH / 2;
    while half >= LANES {
        let (sums, others) = errors.split_at_mut(half);
        for i in 0..half {
            sums[i] += others[i];
        }
        half /= 2;
    }
    errors[..LANES].iter().map(|error| f64::from(*error)).sum()
}
