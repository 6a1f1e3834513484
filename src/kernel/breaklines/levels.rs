//! Heights that lines have of their own, by place.

use super::Place;
use super::pieces::Piece;
use crate::base::LineKind;
use crate::base::exact;

/// The heights of lines at all of their places.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Levels {
    /// In the order of places, each once.
    levels: Vec<(Place, f64)>,
    /// Where several lines have several heights, in the same order.
    differences: Vec<TwoHeights>,
}

/// Lines that have a place in common, but not their height.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "expected one height at column {column}, row {row}, where lines meet, found {} in {} and {} in {}",
    heights[0], Part(of[0]), heights[1], Part(of[1])
)]
pub struct TwoHeights {
    /// With fractions.
    pub column: f64,
    /// With fractions.
    pub row: f64,
    /// The least height and the largest.
    pub heights: [f64; 2],
    /// The lines that have them: of which kind, and the number of the feature.
    pub of: [(LineKind, u64); 2],
}

struct Part((LineKind, u64));

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "feature {} of the {}", self.0.1, self.0.0.name())
    }
}

impl Levels {
    /// Of noded pieces with heights of their own; `name` tells what a piece is of.
    pub(super) fn new<'a>(pieces: impl Iterator<Item = &'a Piece>, name: impl Fn(&Piece) -> (LineKind, u64)) -> Levels {
        let ends = |piece: &'a Piece| [0, 1].map(|i| (piece.ends[i], piece.heights[i], piece));
        let mut all: Vec<(Place, f64, &Piece)> = pieces.flat_map(ends).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let mut found = Levels::default();
        for group in all.chunk_by(|a, b| a.0 == b.0) {
            let (at, (low, of_low), (high, of_high)) =
                (group[0].0, (group[0].1, group[0].2), (group[group.len() - 1].1, group[group.len() - 1].2));
            found.levels.push((at, low + (high - low) / 2.0));
            if low < high {
                let (column, row) = at.cells();
                let of = [name(of_low), name(of_high)];
                found.differences.push(TwoHeights { column, row, heights: [low, high], of });
            }
        }
        found
    }

    /// All places with their heights, in their order.
    pub(super) fn all(&self) -> &[(Place, f64)] {
        &self.levels
    }

    /// The height at a place, if a line with heights has it.
    pub(super) fn at(&self, place: Place) -> Option<f64> {
        self.levels.binary_search_by_key(&place, |(at, _)| *at).ok().map(|i| self.levels[i].1)
    }

    pub(super) fn range(&self) -> Option<[f64; 2]> {
        let of = |pick: fn(f64, f64) -> f64| self.levels.iter().map(|(_, height)| *height).reduce(pick);
        Some([of(f64::min)?, of(f64::max)?])
    }

    pub(super) fn check(&self, tolerance: f64) -> Result<(), TwoHeights> {
        let differ = |found: &&TwoHeights| {
            let [low, high] = found.heights;
            !exact::within(&[(1, high), (-1, low)], 1, tolerance)
        };
        self.differences.iter().find(differ).map_or(Ok(()), |found| Err(*found))
    }

    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(self.levels.as_slice()) + size_of_val(self.differences.as_slice())) as u64
    }

    pub(super) fn hash(&self, hasher: &mut crc32fast::Hasher) {
        self.levels.iter().for_each(|(_, height)| hasher.update(&height.to_le_bytes()));
    }
}
