//! Cells beside lines, where the surface may stray as far as it likes.

use std::ops::Range;

use super::{RequiredLines, Spot};
use crate::base::external::ScratchError;

/// The cells that lines run in, near some rows, and how far around them no limit on straying holds: as many cells as edges may be from lines, rounded up,
/// and at the least one where lines have heights of their own.
///
/// Memory: 16 bytes for each cell that a line runs in.
#[derive(Debug)]
pub(in crate::verify) struct Unbound {
    /// By rows, then by columns: row and column.
    cells: Vec<(i64, i64)>,
    reach: i64,
}

impl Unbound {
    /// Those that tell of the cells of some rows.
    pub(in crate::verify) fn near(lines: &RequiredLines, rows: Range<i64>) -> Result<Unbound, ScratchError> {
        let reach = |shift: f64, has_heights: bool| if has_heights { shift.max(1.0) } else { shift };
        let reach = lines.sets.iter().map(|set| reach(set.shift, set.has_heights)).fold(0.0, f64::max).ceil() as i64;
        // A segment touches the rows next to its own.
        let near = lines.segments(rows.start - reach - 1..rows.end + reach + 1)?;
        let spots = near.flat_map(|(ends, _)| ends);
        let mut cells: Vec<(i64, i64)> = spots.flat_map(around).collect();
        cells.sort_unstable();
        cells.dedup();
        Ok(Unbound { cells, reach })
    }

    /// Whether a cell, by the column and the row of its first sample, is one of them.
    pub(in crate::verify) fn has(&self, column: i64, row: i64) -> bool {
        (row - self.reach..=row + self.reach).any(|row| {
            let first = self.cells.partition_point(|cell| *cell < (row, column - self.reach));
            self.cells.get(first).is_some_and(|cell| *cell <= (row, column + self.reach))
        })
    }
}

/// The cells that a spot lies in, up to four: row and column.
fn around((x, y): Spot) -> impl Iterator<Item = (i64, i64)> {
    let along = |quarters: i64| (quarters - 1).div_euclid(4)..=quarters.div_euclid(4);
    along(y).flat_map(move |row| along(x).map(move |column| (row, column)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_touch_their_spots() {
        let cells = |x: i64, y: i64| around((x, y)).collect::<Vec<_>>();
        assert_eq!(cells(5, 6), [(1, 1)]);
        assert_eq!(cells(4, 6), [(1, 0), (1, 1)]);
        assert_eq!(cells(8, 4), [(0, 1), (0, 2), (1, 1), (1, 2)]);
    }

    #[test]
    fn reach_is_counted_both_ways() {
        let near = Unbound { cells: vec![(3, 7), (5, 1)], reach: 1 };
        assert!(near.has(6, 2) && near.has(8, 4) && near.has(7, 3) && near.has(0, 6) && near.has(2, 4));
        assert!(!near.has(9, 3) && !near.has(5, 3) && !near.has(7, 5) && !near.has(7, 1) && !near.has(3, 5));
        let here = Unbound { reach: 0, ..near };
        assert!(here.has(7, 3) && !here.has(6, 3) && !here.has(7, 2));
    }
}
