//! Heights that lines have of their own, by place.

use super::Place;
use super::lakes::Lakes;
use super::pieces::Piece;
use crate::base::LineKind;
use crate::base::exact;
use crate::base::lattice::STEPS;

/// The heights of lines at all of their places.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Levels {
    /// In the order of places, each once.
    levels: Vec<(Place, f64)>,
    /// Where several lines have several heights, in the same order.
    differences: Vec<TwoHeights>,
}

/// A height of a line, or of a lake, at a place.
#[derive(Debug, Clone, Copy)]
struct Level {
    at: Place,
    height: f64,
    of: (LineKind, u64),
    is_lake: bool,
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
    /// Whether they are not one, however close: lakes are level.
    is_certain: bool,
}

impl TwoHeights {
    pub(super) fn place(&self) -> Place {
        let steps = |cells: f64| (cells * f64::from(STEPS)) as i64;
        Place { y: steps(self.row), x: steps(self.column) }
    }

    /// Whether heights differ more than others do.
    pub(super) fn is_larger(&self, other: &TwoHeights) -> bool {
        let ([low, high], [other_low, other_high]) = (self.heights, other.heights);
        exact::sign(&[(1, high), (-1, low), (-1, other_high), (1, other_low)]).is_gt()
    }
}

struct Part((LineKind, u64));

impl std::fmt::Display for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "feature {} of the {}", self.0.1, self.0.0.name())
    }
}

impl Levels {
    /// Of noded pieces; `own` tells which of them have heights of their own, and what a piece is of. All places in and on lakes have
    /// the lake's height.
    pub(super) fn new(pieces: &[Piece], lakes: &Lakes, own: impl Fn(&Piece) -> Option<(LineKind, u64)>) -> Levels {
        let mut all: Vec<Level> = Vec::new();
        for piece in pieces {
            for (at, height) in piece.ends.into_iter().zip(piece.heights) {
                all.extend(own(piece).map(|of| Level { at, height, of, is_lake: false }));
                if !lakes.is_empty() {
                    let lake = |(feature, height)| Level { at, height, of: (LineKind::Lakes, feature), is_lake: true };
                    all.extend(lakes.at(at).map(lake));
                }
            }
        }
        all.sort_by(|a, b| a.at.cmp(&b.at).then(a.height.total_cmp(&b.height)).then(a.of.cmp(&b.of)));
        let mut found = Levels::default();
        for group in all.chunk_by(|a, b| a.at == b.at) {
            let (least, largest) = (group[0], group[group.len() - 1]);
            let (low, high) = (least.height, largest.height);
            let mut of_lakes = group.iter().filter(|level| level.is_lake).map(|level| level.height);
            let lake = of_lakes.next();
            let height = lake.unwrap_or(low + (high - low) / 2.0);
            found.levels.push((least.at, height));
            if low < high {
                let (column, row) = least.at.cells();
                let is_certain = of_lakes.any(|other| other != height);
                found.differences.push(TwoHeights {
                    column,
                    row,
                    heights: [low, high],
                    of: [least.of, largest.of],
                    is_certain,
                });
            }
        }
        found
    }

    /// No places, and these differences.
    pub(super) fn told(differences: Vec<TwoHeights>) -> Levels {
        Levels { levels: Vec::new(), differences }
    }

    /// Where several lines have several heights, in the order of places.
    pub(super) fn differences(&self) -> &[TwoHeights] {
        &self.differences
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
            found.is_certain || !exact::within(&[(1, high), (-1, low)], 1, tolerance)
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
