//! Samples beside lines that have heights of their own: what the surface may be there.
//!
//! A sample is beside a line if the line comes into one of the closed cells around it; that is, if a place of the line is within a
//! cell of it both ways, as every segment lies in a closed cell. With Z the least and the largest height of lines at those places, the
//! surface may be from min(h, Z) − ε to max(h, Z) + ε at a sample of height h.
//!
//! Engines know one height and one limit for each sample. They are given a height in that interval, and as a limit how far it is
//! to the nearer end: for a sample on such a line the line's height, on another line h, elsewhere the middle. In a lake that is the
//! lake's height, and no distance from it.

use super::lakes::Lakes;
use super::{Levels, Place, Segment, Set, SetBits};
use crate::base::exact::{self, MAX_WEIGHT};
use crate::base::lattice::STEPS;
use crate::base::{EasedSample, PointSet, Tile, Window};

const CELL: i64 = STEPS as i64;

/// The samples beside lines with heights.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Beside {
    /// By rows, then by columns.
    samples: Vec<Near>,
    lakes: Lakes,
}

/// A sample beside lines.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Near {
    row: u32,
    column: u32,
    /// The least and the largest height of lines around it.
    heights: [f64; 2],
    under: Under,
}

/// What lies on a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Under {
    /// A line that has this height there.
    Own(f64),
    /// A line without heights.
    Raster,
    /// None.
    Nothing,
}

/// What engines are given for a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Eased {
    pub(super) height: f64,
    /// As [`Tile::weight`].
    pub(super) weight: f64,
}

impl Near {
    /// What stands for a sample of this height, and what interval that is for.
    fn ease(&self, height: f64, tolerance: f64, is_kept: bool) -> (Eased, [f64; 2]) {
        let [low, high] = [height.min(self.heights[0]), height.max(self.heights[1])];
        let target = match self.under {
            Under::Own(own) => own,
            Under::Raster => height,
            Under::Nothing if is_kept => height,
            Under::Nothing => low + (high - low) / 2.0,
        };
        // All rounded down.
        let room = (target - low).next_down().min((high - target).next_down());
        let weight = if room > 0.0 { weight((room + tolerance).next_down(), tolerance) } else { 1.0 };
        (Eased { height: target, weight }, [low, high])
    }
}

/// The least weight of an error that allows no more than this limit.
fn weight(limit: f64, tolerance: f64) -> f64 {
    if limit <= tolerance || tolerance == 0.0 {
        return 1.0;
    }
    let mut weight = tolerance / limit;
    while exact::limit(weight, tolerance) > limit {
        weight = weight.next_up();
    }
    weight
}

impl Beside {
    /// The same of all segments, with the sets that each is of.
    pub(super) fn of_lines(
        levels: &Levels,
        lakes: Lakes,
        (segments, of): (&[Segment], &[SetBits]),
        sets: &[Set],
        size: (usize, usize),
    ) -> Beside {
        let is_raster = |bits: &SetBits| (0..).zip(sets).all(|(i, set)| bits & 1 << i == 0 || !set.has_heights);
        let of_raster = segments.iter().zip(of).filter(|(_, bits)| is_raster(bits)).map(|(segment, _)| *segment);
        Beside::new(levels, lakes, of_raster, size)
    }

    /// Beside all places with heights, and in lakes; `others` are segments of lines without.
    pub(super) fn new(
        levels: &Levels,
        lakes: Lakes,
        others: impl Iterator<Item = Segment>,
        (width, height): (usize, usize),
    ) -> Beside {
        let near = |along: i64, count: usize| {
            let first = (along - CELL + CELL - 1).div_euclid(CELL).max(0);
            first..=(along + CELL).div_euclid(CELL).min(count as i64 - 1)
        };
        let mut samples = Vec::new();
        for &(at, level) in levels.all() {
            for row in near(at.y, height) {
                for column in near(at.x, width) {
                    let is_there = at == Place { y: row * CELL, x: column * CELL };
                    let under = if is_there { Under::Own(level) } else { Under::Nothing };
                    samples.push(Near { row: row as u32, column: column as u32, heights: [level, level], under });
                }
            }
        }
        samples.sort_unstable_by_key(|near| (near.row, near.column));
        samples.dedup_by(|next, kept| {
            let is_same = (next.row, next.column) == (kept.row, kept.column);
            if is_same {
                kept.heights = [kept.heights[0].min(next.heights[0]), kept.heights[1].max(next.heights[1])];
                if let Under::Own(_) = next.under {
                    kept.under = next.under;
                }
            }
            is_same
        });
        let mut beside = Beside { samples, lakes };
        for place in others.flatten().filter(|p| p.x % CELL == 0 && p.y % CELL == 0) {
            let at = ((place.y / CELL) as u32, (place.x / CELL) as u32);
            if let Ok(i) = beside.find(at)
                && beside.samples[i].under == Under::Nothing
            {
                beside.samples[i].under = Under::Raster;
            }
        }
        beside
    }

    fn find(&self, at: (u32, u32)) -> Result<usize, usize> {
        self.samples.binary_search_by_key(&at, |near| (near.row, near.column))
    }

    pub(super) fn bytes(&self) -> u64 {
        size_of_val(self.samples.as_slice()) as u64 + self.lakes.bytes()
    }

    /// How many samples lie in lakes.
    pub(super) fn in_lakes(&self) -> u64 {
        self.lakes.samples()
    }

    /// What stands for a sample of the raster that has this height, if it is beside a line or in a lake.
    pub(super) fn at(&self, (column, row): (i64, i64), height: f64, tolerance: f64) -> Option<Eased> {
        if let Some(run) = self.lakes.runs(row as u32, column as u32..column as u32 + 1).next() {
            return Some(Eased { height: run.height, weight: MAX_WEIGHT });
        }
        let found = self.find((row as u32, column as u32)).ok();
        found.map(|i| self.samples[i].ease(height, tolerance, false).0)
    }

    /// Puts what stands for samples in their place, as far as a tile has some beside lines. `points` keep their heights.
    pub(super) fn ease(&self, tile: &mut Tile, window: Window, points: Option<&PointSet>, tolerance: f64) {
        let mut eased = Vec::new();
        let columns = window.column as u32..(window.column + window.width) as u32;
        let (mut flooded, mut of_row) = (vec![false; window.width], Vec::new());
        for row in 0..window.height {
            let global = (window.row + row) as u32;
            of_row.clear();
            let mut add = |column: u32, stands: &dyn Fn(f64) -> (Eased, [f64; 2])| {
                let local = (column - columns.start) as usize;
                if tile.validity().is_valid(local as i32, row as i32) {
                    let (height, sample) = (tile.at(local, row), (row * window.width + local) as u32);
                    let (stands, [low, high]) = stands(height);
                    of_row.push((EasedSample { sample, height, low, high }, stands.height, stands.weight));
                }
            };
            for run in self.lakes.runs(global, columns.clone()) {
                for column in run.first.max(columns.start)..=run.last.min(columns.end - 1) {
                    let local = (column - columns.start) as usize;
                    if !std::mem::replace(&mut flooded[local], true) {
                        add(column, &|_| (Eased { height: run.height, weight: MAX_WEIGHT }, [run.height; 2]));
                    }
                }
            }
            let first = self.samples.partition_point(|near| (near.row, near.column) < (global, columns.start));
            let near = self.samples[first..].iter().take_while(|near| near.row == global && near.column < columns.end);
            for near in near.filter(|near| !flooded[(near.column - columns.start) as usize]) {
                let is_point = points.is_some_and(|points| points.has((near.column as usize, global as usize)));
                add(near.column, &|height| near.ease(height, tolerance, is_point));
            }
            of_row.retain(|(sample, _, weight)| sample.low < sample.high || *weight == MAX_WEIGHT);
            of_row.sort_unstable_by_key(|(sample, _, _)| sample.sample);
            eased.append(&mut of_row);
            flooded.fill(false);
        }
        tile.ease(eased);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::base::Heights;

    proptest! {
        /// Whatever engines are given lies in the interval, exactly, and a little off the middle nothing is lost but roundings.
        #[test]
        fn what_is_eased_stays_between_the_sample_and_the_line(
            height in -1e4..1e4f64, low in -1e4..1e4f64, more in prop_oneof![Just(0.0), 0.0..1e3f64, Just(1e-9)],
            tolerance in prop_oneof![Just(0.0), Just(1e-9), 0.0..10.0f64], under in 0..3u8, share in 0.0..=1.0f64,
        ) {
            let heights = [low, low + more];
            let own = low + (heights[1] - low) * share;
            let under = [Under::Nothing, Under::Raster, Under::Own(own.min(heights[1]))][usize::from(under)];
            let (eased, [low, high]) = Near { row: 0, column: 0, heights, under }.ease(height, tolerance, false);
            let limit = exact::limit(eased.weight, tolerance);
            prop_assert!(limit >= tolerance && low <= eased.height && eased.height <= high);
            // height + limit ≤ high + ε, and the other way.
            for (sign, end) in [(1, high), (-1, low)] {
                let over = exact::sign(&[(sign, eased.height), (1, limit), (-sign, end), (-1, tolerance)]);
                prop_assert!(over.is_le(), "{:?} in {} to {}", eased, low, high);
            }
            if under == Under::Nothing && tolerance > 0.0 {
                prop_assert!(limit >= (high - low) / 2.0 * (1.0 - 1e-12) + tolerance * (1.0 - 1e-9) - 1e-9);
            }
        }
    }

    #[test]
    fn a_sample_is_beside_the_places_within_a_cell_of_it() {
        let piece =
            super::super::pieces::Piece::new((0, 0), [(Place { y: 4, x: 5 }, 7.0), (Place { y: 5, x: 8 }, 9.0)]);
        let levels = Levels::new(&[piece], &Lakes::default(), |_| Some((crate::base::LineKind::Breaklines, 0)));
        let beside = Beside::new(&levels, Lakes::default(), std::iter::empty(), (5, 4));
        let found: Vec<_> = beside.samples.iter().map(|n| ((n.row, n.column), n.heights)).collect();
        let expected = [
            ((0, 1), [7.0, 7.0]),
            ((0, 2), [7.0, 7.0]),
            ((1, 1), [7.0, 9.0]),
            ((1, 2), [7.0, 9.0]),
            ((1, 3), [9.0, 9.0]),
            ((2, 1), [7.0, 9.0]),
            ((2, 2), [7.0, 9.0]),
            ((2, 3), [9.0, 9.0]),
        ];
        assert_eq!(found, expected);
        let mut tile = Tile::from_heights(3, 3, Heights::F32(vec![5.0; 9]));
        let window = Window { column: 1, row: 0, width: 3, height: 3 };
        beside.ease(&mut tile, window, None, 0.5);
        assert_eq!((tile.at(0, 0), tile.limit(0, 0, 0.5)), (6.0, 1.5f64.next_down()));
    }
}
