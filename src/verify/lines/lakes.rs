//! Lakes: which places and samples lie in them.

use std::collections::BTreeMap;
use std::ops::Range;

use num_rational::Ratio;

use super::Spot;
use crate::verify::VerifyError;

/// A side of an outline, the upper end first.
type Side = [Spot; 2];

/// Between two rows of quarter cells, no side begins, ends or crosses another: there a lake is what lies between an odd side of its
/// outline and the next. Memory: some 100 bytes for each row that a side passes.
#[derive(Debug, Default)]
pub(super) struct Shores {
    /// By the upper row: left side, right side, and the lake's number.
    strips: BTreeMap<i64, Vec<(Side, Side, usize)>>,
    /// Features and heights.
    lakes: Vec<(u64, f64)>,
}

/// Where a side is at some height of the lattice, perhaps between two rows.
fn across([(ax, ay), (bx, by)]: Side, y: Ratio<i64>) -> Ratio<i64> {
    (y - ay) * Ratio::new(bx - ax, by - ay) + ax
}

impl Shores {
    /// Of lakes by feature and height, and of their sides, each with the number of its lake.
    pub(super) fn new(
        lakes: Vec<(u64, f64)>,
        sides: impl Iterator<Item = (Side, usize)>,
    ) -> Result<Shores, VerifyError> {
        let mut crossings: BTreeMap<i64, Vec<(Ratio<i64>, usize, Side)>> = BTreeMap::new();
        for (side, lake) in sides {
            for row in side[0].1..side[1].1 {
                let middle = Ratio::new(2 * row + 1, 2);
                crossings.entry(row).or_default().push((across(side, middle), lake, side));
            }
        }
        let mut strips = BTreeMap::new();
        for (row, mut of_row) in crossings {
            of_row.sort_unstable();
            let mut parts: Vec<(Side, Side, usize)> = Vec::new();
            let mut begun: BTreeMap<usize, Side> = BTreeMap::new();
            for at in of_row.chunk_by(|a, b| a.0 == b.0) {
                for &(_, lake, side) in at {
                    match begun.remove(&lake) {
                        Some(left) => parts.push((left, side, lake)),
                        None => _ = begun.insert(lake, side),
                    }
                }
                let mut both = begun.keys().map(|&lake| lakes[lake].0);
                if let (Some(a), Some(b)) = (both.next(), both.next()) {
                    return Err(VerifyError::LakesOverlap { features: [a, b] });
                }
            }
            strips.insert(row, parts);
        }
        Ok(Shores { strips, lakes })
    }

    pub(super) fn len(&self) -> usize {
        self.lakes.len()
    }

    /// The numbers of the lakes that a place is in or on; one may be there twice.
    pub(super) fn at(&self, (x, y): Spot) -> impl Iterator<Item = usize> {
        let (x, line) = (Ratio::from_integer(x), Ratio::from_integer(y));
        let parts = [y - 1, y].into_iter().filter_map(|row| self.strips.get(&row)).flatten();
        let there = parts.filter(move |(left, right, _)| across(*left, line) <= x && x <= across(*right, line));
        there.map(|(_, _, lake)| *lake)
    }

    /// Feature and height of a lake.
    pub(super) fn lake(&self, number: usize) -> (u64, f64) {
        self.lakes[number]
    }

    /// The samples of some rows that are in lakes or on their outlines: row, columns, height. Some may be there twice.
    pub(super) fn samples(&self, rows: Range<i64>) -> impl Iterator<Item = (i64, Range<i64>, f64)> {
        rows.flat_map(|row| [(row, 4 * row - 1), (row, 4 * row)]).flat_map(move |(row, strip)| {
            let parts = self.strips.get(&strip).into_iter().flatten();
            parts.map(move |&(left, right, lake)| {
                let line = Ratio::from_integer(4 * row);
                let [first, last] = [(across(left, line) / 4).ceil(), (across(right, line) / 4).floor()];
                (row, first.to_integer()..last.to_integer() + 1, self.lakes[lake].1)
            })
        })
    }
}
