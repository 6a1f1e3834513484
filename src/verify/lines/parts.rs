//! Stretches of lines from where they end or meet to where they do again, as far as they are in a strip: rows of cells over the whole
//! width. Segments are in the strip of their first place by rows.

use std::ops::Range;

use super::required::{Segment, SetBits};
use super::words::word;

/// A part of a stretch, as long as its segments are in one strip.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    /// Words.
    pub(super) places: Vec<u64>,
    pub(super) sets: SetBits,
    /// Whether the stretch may go on at the first place, and at the last.
    pub(super) goes_on: [bool; 2],
    /// Whether it is a whole ring that meets no other line.
    pub(super) is_ring: bool,
}

/// A segment from one of its ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Way {
    from: u64,
    to: u64,
    sets: SetBits,
    /// Whether the segment is in the strip.
    is_own: bool,
}

/// The segments of a strip, and those of the strip above that end on its first line.
///
/// Memory: some 50 bytes for each segment.
#[derive(Debug)]
pub(super) struct Graph {
    /// In order: those from one place are next to each other.
    ways: Vec<Way>,
    /// The first word of the next strip.
    after: u64,
}

impl Graph {
    /// Of segments in a strip and above it, and of the first word of the next strip.
    pub(super) fn new(own: &[Segment], above: &[Segment], after: u64) -> Graph {
        let both = |&([a, b], sets): &Segment| {
            let way = |from, to| Way { from, to, sets, is_own: true };
            let [a, b] = [word(a), word(b)];
            [way(a, b), way(b, a)]
        };
        let from_above = |&([a, b], sets): &Segment| Way { from: word(b), to: word(a), sets, is_own: false };
        let mut ways: Vec<Way> = own.iter().flat_map(both).chain(above.iter().map(from_above)).collect();
        ways.sort_unstable();
        Graph { ways, after }
    }

    /// All ways from the place that one is from.
    fn beside(&self, way: usize) -> Range<usize> {
        let is_same = |at: &usize| self.ways[*at].from == self.ways[way].from;
        let before = (0..way).rev().take_while(is_same).count();
        way - before..way + 1 + (way + 1..self.ways.len()).take_while(is_same).count()
    }

    /// Whether no stretch ends where these ways begin: there are two, and they are of the same sets.
    fn is_passed(&self, ways: Range<usize>) -> bool {
        let ways = &self.ways[ways];
        ways.len() == 2 && ways[0].sets == ways[1].sets
    }

    /// The same of a place on the strip's first line.
    pub(super) fn goes_on(&self, place: u64) -> bool {
        let first = self.ways.partition_point(|way| way.from < place);
        self.ways.get(first).is_some_and(|way| way.from == place) && self.is_passed(self.beside(first))
    }

    /// Whether a part goes on at the place that a way is from.
    fn is_inner(&self, way: usize) -> bool {
        let ways = self.beside(way);
        self.ways[way].from < self.after && self.ways[ways.clone()].iter().all(|way| way.is_own) && self.is_passed(ways)
    }

    /// The parts of all stretches. Those that are whole go the way that comes first by rows, and rings begin at their first place.
    pub(super) fn parts(&self, mut take: impl FnMut(Part)) {
        let mut taken = vec![false; self.ways.len()];
        // What begins at an end, then rings.
        for is_ring in [false, true] {
            for first in 0..self.ways.len() {
                if taken[first] || !self.ways[first].is_own || !is_ring && self.is_inner(first) {
                    continue;
                }
                let Way { from, sets, .. } = self.ways[first];
                let (mut places, mut way) = (vec![from], first);
                let last = loop {
                    let Way { from, to, .. } = self.ways[way];
                    let back = self.ways.partition_point(|way| (way.from, way.to) < (to, from));
                    (taken[way], taken[back]) = (true, true);
                    places.push(to);
                    let ways = self.beside(back);
                    let other = ways.start + ways.end - 1 - back;
                    if !self.is_inner(back) || taken[other] {
                        break back;
                    }
                    way = other;
                };
                let may_go_on =
                    |way: usize| !is_ring && (self.ways[way].from >= self.after || self.is_passed(self.beside(way)));
                take(Part { places, sets, goes_on: [may_go_on(first), may_go_on(last)], is_ring });
            }
        }
    }
}
