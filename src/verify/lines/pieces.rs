//! Pieces of lines, and what is known of each.

use super::Spot;
use super::words::{spot, word};

/// A piece as words, in the order of its first place by rows; how often its line runs over it comes last.
pub(super) type Record = [u64; 6];

/// A piece, and how often its line runs over it.
pub(super) type Counted = (Piece, u64);

/// A piece of a line between two places.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Piece {
    /// From the smaller place to the larger as (down, across).
    pub(super) ends: [Spot; 2],
    /// Which set of lines it is of.
    pub(super) set: usize,
    /// Which line of the set, where lines have heights of their own or are a cutline; else 0.
    pub(super) line: usize,
    /// Bits of its own heights at both ends; else 0.
    heights: [u64; 2],
}

impl Piece {
    pub(super) fn new((set, line): (usize, usize), from: (Spot, f64), to: (Spot, f64)) -> Piece {
        let is_turned = (from.0.1, from.0.0) > (to.0.1, to.0.0);
        let [(a, low), (b, high)] = if is_turned { [to, from] } else { [from, to] };
        Piece { ends: [a, b], set, line, heights: [low.to_bits(), high.to_bits()] }
    }

    pub(super) fn record(&self, times: u64) -> Record {
        let [a, b] = self.ends.map(word);
        [a, b, (self.set as u64) << 32 | self.line as u64, self.heights[0], self.heights[1], times]
    }

    pub(super) fn of_record([a, b, of, from, to, times]: Record) -> Counted {
        let (set, line) = ((of >> 32) as usize, of as u32 as usize);
        (Piece { ends: [spot(a), spot(b)], set, line, heights: [from, to] }, times)
    }

    /// The row of cells that its first place is in.
    pub(super) fn row(&self) -> i64 {
        self.ends[0].1 >> 2
    }

    /// Its own heights at both ends.
    pub(super) fn heights(&self) -> [f64; 2] {
        self.heights.map(f64::from_bits)
    }

    /// The height at the place of the piece that is nearest to another.
    pub(super) fn height_near(&self, (x, y): Spot) -> f64 {
        let [(ax, ay), (bx, by)] = self.ends;
        let all = (bx - ax).pow(2) + (by - ay).pow(2);
        let done = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)).max(0).min(all);
        let [from, to] = self.heights();
        between((from, to), (done.into(), all.into()))
    }
}

/// A height between two, where a share of the way, a fraction, is done.
pub(super) fn between((from, to): (f64, f64), (done, all): (i128, i128)) -> f64 {
    if done == all {
        return to;
    }
    from + (to - from) * (done as f64 / all as f64)
}
