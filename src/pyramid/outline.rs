//! What is known of a block of samples without reading it: every eighth of them along and across, between which heights its squares
//! are, and how many samples have heights. Coarse levels look at little else.

use super::store::BLOCK;
use super::voids::VOID;

/// Cells from one of the samples to the next.
pub(super) const THINNED: usize = 8;

/// Samples along a side of a square.
pub(super) const SQUARE: usize = 16;

/// Squares along a side of a block.
pub(super) const SQUARES: usize = BLOCK / SQUARE;

/// The samples along a side.
const ALONG: usize = BLOCK / THINNED;

/// Where the heights of squares begin among the numbers, those of the parts, and the checksum of all before.
const HEIGHTS: usize = ALONG * ALONG;
const PARTS: usize = HEIGHTS + 2 * SQUARES * SQUARES;
const SUM: usize = PARTS + 4 * 4;

/// What it takes in a file.
pub(super) const BYTES: u64 = ((SUM + 1) * size_of::<f64>()) as u64;

/// Some samples: between which heights they are, and how many have one, and how many are in marked voids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Count {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) inside: u64,
    pub(super) in_voids: u64,
}

impl Count {
    pub(super) const NONE: Count = Count { low: f64::INFINITY, high: f64::NEG_INFINITY, inside: 0, in_voids: 0 };

    fn of(heights: impl Iterator<Item = f64>) -> Count {
        heights.fold(Count::NONE, |count, height| match height {
            VOID => Count { in_voids: count.in_voids + 1, ..count },
            height if height.is_nan() => count,
            height => {
                Count { low: count.low.min(height), high: count.high.max(height), inside: count.inside + 1, ..count }
            }
        })
    }

    pub(super) fn with(self, other: Count) -> Count {
        Count {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            inside: self.inside + other.inside,
            in_voids: self.in_voids + other.in_voids,
        }
    }
}

/// The outline of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outline([f64; SUM + 1]);

impl Outline {
    pub(super) fn of(heights: &[f64]) -> Outline {
        let mut numbers = [0.0; SUM + 1];
        for (i, thinned) in numbers[..HEIGHTS].iter_mut().enumerate() {
            *thinned = heights[i / ALONG * THINNED * BLOCK + i % ALONG * THINNED];
        }
        let mut all = Count::NONE;
        for (i, ends) in numbers[HEIGHTS..PARTS].chunks_exact_mut(2).enumerate() {
            let first = i / SQUARES * SQUARE * BLOCK + i % SQUARES * SQUARE;
            let rows = (0..SQUARE).map(|row| &heights[first + row * BLOCK..][..SQUARE]);
            let is_whole = rows.clone().all(|row| row.iter().fold(true, |all, height| all & height.is_finite()));
            let count = match is_whole {
                true => rows.fold(Count { inside: (SQUARE * SQUARE) as u64, ..Count::NONE }, with_whole),
                false => Count::of(rows.flatten().copied()),
            };
            ends.copy_from_slice(&[count.low, count.high]);
            all = all.with(count);
        }
        let column = || heights.iter().copied().step_by(BLOCK);
        let row = || heights[..BLOCK].iter().copied();
        let parts = [all, Count::of(column()), Count::of(row()), Count::of(row().take(1))];
        for (to, part) in numbers[PARTS..SUM].chunks_exact_mut(4).zip(parts) {
            to.copy_from_slice(&[part.low, part.high, part.inside as f64, part.in_voids as f64]);
        }
        numbers[SUM] = sum(&numbers);
        Outline(numbers)
    }

    /// As it is in a file. `None` where that is damaged.
    pub(super) fn read(bytes: &[u8; BYTES as usize]) -> Option<Outline> {
        let mut numbers = [0.0; SUM + 1];
        bytemuck::cast_slice_mut(&mut numbers).copy_from_slice(bytes);
        (numbers[SUM] == sum(&numbers)).then_some(Outline(numbers))
    }

    /// See [`Outline::read`].
    pub(super) fn bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.0)
    }

    /// The height of a sample whose column and row in the block are multiples of [`THINNED`].
    pub(super) fn height(&self, column: usize, row: usize) -> f64 {
        self.0[row / THINNED * ALONG + column / THINNED]
    }

    /// Between which heights the samples of a square are; the lower is the larger where none has any.
    pub(super) fn ends(&self, column: usize, row: usize) -> (f64, f64) {
        let at = HEIGHTS + 2 * (row * SQUARES + column);
        (self.0[at], self.0[at + 1])
    }

    /// All samples, or those of the first column, or of the first row, or the one that is in both.
    pub(super) fn count(&self, all_columns: bool, all_rows: bool) -> Count {
        let at = PARTS + 4 * (2 * usize::from(!all_rows) + usize::from(!all_columns));
        // The order of parts: all, the first column, the first row, the corner.
        let [low, high, inside, in_voids] = [0, 1, 2, 3].map(|i| self.0[at + i]);
        Count { low, high, inside: inside as u64, in_voids: in_voids as u64 }
    }
}

fn with_whole(count: Count, row: &[f64]) -> Count {
    row.iter().fold(count, |count, &height| Count {
        low: if height < count.low { height } else { count.low },
        high: if height > count.high { height } else { count.high },
        ..count
    })
}

fn sum(numbers: &[f64; SUM + 1]) -> f64 {
    f64::from(crc32fast::hash(bytemuck::cast_slice(&numbers[..SUM])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::store::SAMPLES;

    /// Against a look at every sample; blocks whole, with gaps and voids, and with nothing.
    #[test]
    fn outlines_are_those_of_the_samples() {
        for (gaps, voids) in [(0, 0), (7, 0), (5, 3), (1, 0)] {
            let height = |i: usize| match i * 2_654_435_761 % 1009 {
                n if gaps > 0 && n % gaps == 0 => f64::NAN,
                n if voids > 0 && n % voids == 0 => VOID,
                n => n as f64 - 500.0,
            };
            let heights: Vec<f64> = (0..SAMPLES).map(height).collect();
            let written = Outline::of(&heights);
            let bytes = written.bytes().try_into().expect("all of it");
            let outline = Outline::read(bytes).expect("undamaged");
            let mut damaged = *bytes;
            damaged[700] ^= 1;
            assert!(Outline::read(&damaged).is_none());
            let count = |is_in: &dyn Fn(usize, usize) -> bool| {
                let samples = (0..SAMPLES).filter(|i| is_in(i % BLOCK, i / BLOCK)).map(|i| heights[i]);
                Count::of(samples)
            };
            for (all_columns, all_rows) in [(true, true), (false, true), (true, false), (false, false)] {
                let expected = count(&|column, row| (all_columns || column == 0) && (all_rows || row == 0));
                assert_eq!(outline.count(all_columns, all_rows), expected);
            }
            for (column, row) in (0..SQUARES).flat_map(|c| (0..SQUARES).map(move |r| (c, r))) {
                let expected = count(&|c, r| c / SQUARE == column && r / SQUARE == row);
                assert_eq!(outline.ends(column, row), (expected.low, expected.high));
            }
            for (column, row) in [(0, 0), (8, 0), (0, 56), (24, 32), (56, 56)] {
                assert_eq!(outline.height(column, row).to_bits(), heights[row * BLOCK + column].to_bits());
            }
        }
        assert_eq!(Outline::of(&[f64::NAN; SAMPLES]).count(true, true), Count::NONE);
    }
}
