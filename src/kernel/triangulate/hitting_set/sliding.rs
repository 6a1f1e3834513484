//! Squares of any size at any place, and a cover of the samples by some of them.

use std::collections::BinaryHeap;

use super::plane::Region;
use super::squares::{Finder, Square};
use crate::base::control::{CancelToken, Cancelled};

/// Chooses squares until every sample is in one: always that which holds the most samples that are in none (the greedy cover of
/// the paper's section 5); of equal ones the first by row and column. The candidates are the largest valid square at every
/// sample as its upper left corner; every other valid square is part of one.
///
/// Cost: a plane for every sample and size tried, about three times the samples of a square each.
pub(super) fn cover(finder: &mut Finder<'_>, cancel: &CancelToken) -> Result<Vec<Square>, Cancelled> {
    let candidates = largest(finder, cancel)?;
    let (width, height) = (finder.tile.width(), finder.tile.height());
    let mut covered = vec![false; width * height];
    let samples = |square: &Square| {
        let Region { first, last } = square.region();
        (first.1..=last.1).flat_map(move |row| (first.0..=last.0).map(move |column| row * width + column))
    };
    // A gain only falls: a square whose gain is what it was before is the best.
    let mut heap: BinaryHeap<(usize, std::cmp::Reverse<usize>)> =
        candidates.iter().enumerate().map(|(i, square)| (samples(square).count(), std::cmp::Reverse(i))).collect();
    let (mut chosen, mut left) = (Vec::new(), width * height);
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
        chosen.push(*square);
        if chosen.len().is_multiple_of(64) {
            cancel.check()?;
        }
    }
    Ok(chosen)
}

/// The largest valid square at every sample as its upper left corner, by rows. What is valid has valid parts, so a square is at
/// most one larger than the one before it on its diagonal, less one.
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
