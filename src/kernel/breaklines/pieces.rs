//! Pieces of lines between two places, with what is known of them.

use super::{Place, Segment};

/// A piece of a line between two places of one closed cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    /// The lower place first.
    pub(super) ends: Segment,
    /// The number of its set.
    pub(super) set: u8,
    /// Which line of the set it is of, where lines have heights of their own or are a cutline; else 0.
    pub(super) line: u32,
    /// Its own heights at both ends; else 0.
    pub(super) heights: [f64; 2],
    /// How often its line runs over it.
    pub(super) times: u32,
}

impl Piece {
    /// Of a set and a line, between two places with heights.
    pub(super) fn new((set, line): (u8, u32), [a, b]: [(Place, f64); 2]) -> Piece {
        let [a, b] = if a.0 <= b.0 { [a, b] } else { [b, a] };
        Piece { ends: [a.0, b.0], set, line, heights: [a.1, b.1], times: 1 }
    }

    /// In which order pieces are; those that are the same but for how often have equal keys.
    pub(super) fn key(&self) -> (Segment, u8, u32, [u64; 2]) {
        (self.ends, self.set, self.line, self.heights.map(f64::to_bits))
    }

    /// What becomes of it where it is led through these places, from its first end to its last.
    pub(super) fn led<'a>(&'a self, way: &'a [Place]) -> impl Iterator<Item = Piece> + 'a {
        let ([a, b], of) = (self.ends, (self.set, self.line));
        let along = move |p: Place| (p.x - a.x) * (b.x - a.x) + (p.y - a.y) * (b.y - a.y);
        let all = along(b);
        let height = move |p: Place| part_way(self.heights, i128::from(along(p).clamp(0, all)), all.into());
        let part = move |p: Place, q: Place| Piece::new(of, [(p, height(p)), (q, height(q))]);
        way.windows(2).map(move |pair| Piece { times: self.times, ..part(pair[0], pair[1]) })
    }
}

/// The height between two at a share of the way: at both ends the end's own.
pub(super) fn part_way([from, to]: [f64; 2], done: i128, all: i128) -> f64 {
    if done == all { to } else { from + (to - from) * (done as f64 / all as f64) }
}
