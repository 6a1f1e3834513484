//! Squares of any size at any place, and a cover of the samples by some of them.

use std::collections::BinaryHeap;

use super::Corners;
use super::plane::Region;
use super::reweighting::Elements;
use super::squares::{Finder, Square};
use crate::base::Tile;
use crate::base::control::{CancelToken, Cancelled};

/// Squares between two looks at the cancellation token.
const SQUARES_BETWEEN_CHECKS: u32 = 64;

/// Large valid squares of a tile as elements that cover its samples, one at every sample as its upper left corner. With free
/// heights it is the largest there, and each valid square lies within one. For [`hitting_set`](super::reweighting::hitting_set).
#[derive(Debug, Clone)]
pub struct LargestSquares {
    width: usize,
    squares: Vec<Square>,
}

impl LargestSquares {
    /// Finds them.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// If the tile has missing samples.
    pub fn new(
        tile: &Tile,
        tolerance: f64,
        corners: Corners,
        cancel: &CancelToken,
    ) -> Result<LargestSquares, Cancelled> {
        assert!(tile.validity().is_whole(), "squares of samples that are all there");
        let squares = largest(&mut Finder::new(tile, tolerance, corners), cancel)?;
        Ok(LargestSquares { width: tile.width(), squares })
    }

    /// An element's square.
    pub fn square(&self, element: usize) -> &Square {
        &self.squares[element]
    }
}

impl Elements for LargestSquares {
    fn elements(&self) -> usize {
        self.squares.len()
    }

    fn points(&self) -> usize {
        self.squares.len()
    }

    fn covers(&self, element: usize, point: usize) -> bool {
        let (Square { first, last, .. }, column, row) =
            (&self.squares[element], point % self.width, point / self.width);
        (first.0..=last.0).contains(&column) && (first.1..=last.1).contains(&row)
    }

    fn missed_by(&self, elements: &[usize]) -> Option<usize> {
        let mut covered = vec![false; self.points()];
        for &element in elements {
            samples(&self.squares[element], self.width).for_each(|sample| covered[sample] = true);
        }
        covered.iter().position(|is_covered| !is_covered)
    }
}

/// The samples of a square, as row · width + column.
fn samples(square: &Square, width: usize) -> impl Iterator<Item = usize> + use<> {
    let Region { first, last } = square.region();
    (first.1..=last.1).flat_map(move |row| (first.0..=last.0).map(move |column| row * width + column))
}

/// Chooses squares until every sample is in one: always that which holds the most samples that are in none (the greedy
/// cover of the paper's section 5); of equal ones the first by row and column. Returns those of them that are wanted.
/// The candidates are those of [`largest`].
///
/// Cost: a plane for every sample and size tried, about three times the samples of a square each.
pub(super) fn cover(
    finder: &mut Finder<'_>,
    wanted: impl Fn(&Square) -> bool,
    cancel: &CancelToken,
) -> Result<Vec<Square>, Cancelled> {
    let candidates = largest(finder, cancel)?;
    let (width, height) = (finder.tile.width(), finder.tile.height());
    let mut covered = vec![false; width * height];
    let samples = |square: &Square| samples(square, width);
    // A gain only falls: a square whose gain is what it was before is the best.
    let mut heap: BinaryHeap<(usize, std::cmp::Reverse<usize>)> =
        candidates.iter().enumerate().map(|(i, square)| (samples(square).count(), std::cmp::Reverse(i))).collect();
    let (mut chosen, mut left, mut rounds) = (Vec::new(), width * height, 0u32);
    while left > 0 {
        let (gain, index) = heap.pop().expect("every sample is in the square at it");
        let square = &candidates[index.0];
        let now = samples(square).filter(|&sample| !covered[sample]).count();
        if now < gain {
            if now > 0 {
                heap.push((now, index));
            }
            continue;
        }
        samples(square).for_each(|sample| covered[sample] = true);
        left -= now;
        chosen.extend(Some(*square).filter(&wanted));
        rounds = rounds.wrapping_add(1);
        if rounds.is_multiple_of(SQUARES_BETWEEN_CHECKS) {
            cancel.check()?;
        }
    }
    Ok(chosen)
}

/// A large valid square at every sample as its upper left corner, by rows: with free heights the largest, as what is valid has
/// valid parts; with corners at samples the one that doubling and halving finds, though a larger one may be valid.
fn largest(finder: &mut Finder<'_>, cancel: &CancelToken) -> Result<Vec<Square>, Cancelled> {
    let (width, height) = (finder.tile.width(), finder.tile.height());
    let mut found = Vec::with_capacity(width * height);
    for row in 0..height {
        cancel.check()?;
        for column in 0..width {
            let most = (width - column).min(height - row);
            let mut at = |side: usize| {
                let region = Region { first: (column, row), last: (column + side - 1, row + side - 1) };
                finder.square(region)
            };
            // From the size of the one on the left: neighbours are mostly alike.
            let beside: usize = match found.last() {
                Some(Square { first, last, .. }) if first.1 == row => last.0 - first.0 + 1,
                _ => 1,
            };
            let (mut valid, mut best, mut invalid) = (1, at(1), most + 1);
            let mut next = beside.clamp(2, most.max(2));
            while valid + 1 < invalid {
                let side = next.clamp(valid + 1, invalid - 1);
                match at(side) {
                    Some(square) => (valid, best, next) = (side, Some(square), side + (side / 4).max(1)),
                    None => (invalid, next) = (side, side - (side / 4).max(1).min(side - 1)),
                }
            }
            found.push(best.expect("one sample is valid"));
        }
    }
    Ok(found)
}
