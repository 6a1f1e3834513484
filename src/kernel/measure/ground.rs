//! Measuring where samples are missing: what has been seen, once.

use std::ops::RangeInclusive;

use super::{Bare, ErrorStats};
use crate::base::Tile;
use crate::kernel::boundary::Strip;
use crate::kernel::triangulate::feasible::Spans;

/// Which samples of a tile are still to be measured, where some are missing. A triangle's half-open share of samples does
/// not do there: what lies on the right and lower rims of the ground would belong to nobody.
///
/// Memory: one byte per sample.
pub(super) struct Ground {
    width: usize,
    samples: Vec<Sample>,
    /// Columns and rows that the tile owns where all is ground.
    owned: (usize, usize),
    bare: Bare,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sample {
    /// Not a height.
    Missing,
    /// A neighbour's, or nobody's.
    Foreign,
    /// Owned and on the ground, but without a height, and in no triangle so far.
    Bridged,
    /// Owned and on the ground.
    Due,
    /// Measured.
    Seen,
}

impl Ground {
    pub(super) fn new(tile: &Tile, owned: (usize, usize), bare: Bare) -> Ground {
        let place = |i: usize| (i % tile.width, i / tile.width);
        let is_ours = |column: usize, row: usize| match bare {
            Bare::Nothing | Bare::Strip(_) => owns(tile, column, row),
            Bare::StripOfOthers(_) => {
                column < owned.0 && row < owned.1 && tile.validity.is_ground(column as i32, row as i32)
            }
        };
        let sample = |i: usize| match place(i) {
            (column, row) if !tile.validity.is_valid(column as i32, row as i32) => Sample::Missing,
            (column, row) if !is_ours(column, row) => Sample::Foreign,
            (column, row) if tile.validity.is_bridged(column as i32, row as i32) => Sample::Bridged,
            _ => Sample::Due,
        };
        Ground { width: tile.width, samples: (0..tile.width * tile.height).map(sample).collect(), owned, bare }
    }

    /// Visits the runs of samples of a closed triangle that are due: their places in the tile, column and row of the first.
    ///
    /// # Panics
    /// If a sample is missing.
    pub(super) fn for_each_run(&mut self, spans: &Spans, mut visit: impl FnMut(RangeInclusive<usize>, (usize, usize))) {
        let height = self.samples.len() / self.width;
        for row in spans.rows() {
            // Triangles may reach beyond the tile.
            if row < 0 || row as usize >= height {
                continue;
            }
            let (first, last) = spans.columns_within(row, self.width);
            let base = row as usize * self.width;
            let mut begun = None;
            for column in first..=last {
                let (column, row) = (column as usize, row as usize);
                let sample = &mut self.samples[base + column];
                assert!(
                    *sample != Sample::Missing,
                    "a triangle touches the missing sample {column}, {row} of the tile"
                );
                let is_due = *sample == Sample::Due;
                if is_due {
                    *sample = Sample::Seen;
                    begun = begun.or(Some(column));
                    continue;
                }
                if *sample == Sample::Bridged {
                    *sample = Sample::Foreign;
                }
                if let Some(start) = begun.take() {
                    visit(base + start..=base + column - 1, (start, row));
                }
            }
            if let Some(start) = begun {
                visit(base + start..=base + last as usize, (start, row as usize));
            }
        }
    }

    /// Counts the samples that are missing, those that are there but have no ground, those that are bridged, and those that
    /// are left bare.
    ///
    /// # Panics
    /// If a sample is still due that may not be bare.
    pub(super) fn finish(&self, tile: &Tile, stats: &mut ErrorStats) {
        let strip = match self.bare {
            Bare::Nothing => None,
            Bare::Strip(cells) | Bare::StripOfOthers(cells) => Some(Strip::new(tile, cells)),
        };
        for (i, sample) in self.samples.iter().enumerate() {
            let (column, row) = (i % self.width, i / self.width);
            if matches!(sample, Sample::Due | Sample::Bridged) {
                let may_be_bare = strip.as_ref().is_some_and(|strip| {
                    strip.has(column as i32, row as i32)
                        || matches!(self.bare, Bare::StripOfOthers(cells) if is_near_side(tile, cells, (column, row)))
                });
                assert!(may_be_bare, "no triangle covers sample {:?} of the tile", (column, row));
                stats.trimmed += u64::from(*sample == Sample::Due);
            }
            if column < self.owned.0 && row < self.owned.1 {
                let is_outside = tile.validity.is_outside(column as i32, row as i32);
                let is_foreign = *sample == Sample::Foreign;
                let is_stray = is_foreign && !is_outside && !tile.validity.is_ground(column as i32, row as i32);
                stats.nodata += u64::from(*sample == Sample::Missing || is_foreign && is_outside);
                stats.stray += u64::from(is_stray);
                stats.bridged += u64::from(tile.validity.is_bridged(column as i32, row as i32));
            }
        }
    }
}

/// Whether there may be samples so near that the tile knows nothing of them: beyond those next to its window.
fn is_near_side(tile: &Tile, cells: u32, (column, row): (usize, usize)) -> bool {
    let away = [column, row, tile.width - 1 - column, tile.height - 1 - row];
    let beyond = tile.validity.beyond();
    away.iter().zip(beyond).any(|(&away, beyond)| beyond && away + 2 <= cells as usize)
}

/// Whether a sample on the ground is the tile's to measure. Of the tiles around it that have ground at it, it belongs to
/// that to the lower right, else to the lower left, the upper right or the upper left: on whole ground, rims of the raster
/// among it, that is the one that owns it anyway.
pub(crate) fn owns(tile: &Tile, column: usize, row: usize) -> bool {
    let (right, bottom) = (tile.width - 1, tile.height - 1);
    // Which quadrants of the sample lie in the tile.
    let ours =
        [(column < right, row < bottom), (column > 0, row < bottom), (column > 0, row > 0), (column < right, row > 0)];
    let mut quadrants = [0, 1, 3, 2].into_iter();
    let first = quadrants.find(|&quadrant| tile.validity.touches(column as i32, row as i32, quadrant));
    first.is_some_and(|quadrant| ours[quadrant] == (true, true))
}
