//! Stretches that are in several strips, put together from their parts once all strips have passed.
//!
//! A part waits in temporary files, its places and the edges that begin at them. In memory is which parts are next to each other. At the
//! end this tells of each part which stretch it is of and where in it; so places and edges are sorted by stretches, and come out
//! stretch by stretch.

use std::iter::Peekable;

use super::edges::{Edge, EdgeRecord};
use super::follow::Stretch;
use super::required::SetBits;
use crate::base::external::{Queue, Scratch, ScratchError, Sorted, Sorter};

/// Bytes of each of the two sorts; tests go to the file.
const SORT_BYTES: usize = if cfg!(test) { 1 << 10 } else { 16 << 20 };

/// An end of a part: the number of the part twice, and one more for its last place.
pub(super) type End = u32;

/// Stands for an end where a stretch ends.
const NONE: End = End::MAX;

/// Parts of stretches while strips pass.
///
/// Memory: 16 bytes for each part, and the sorts'.
pub(super) struct Parts<'s> {
    scratch: &'s Scratch,
    parts: Vec<Known>,
    /// Places with heights of the line's own, part by part.
    places: Queue<'s, 2>,
    /// Twice the part's number, and one more where the edge is on the surface, with the edge.
    edges: Queue<'s, 5>,
}

/// What is known of a part.
#[derive(Debug, Clone, Copy)]
struct Known {
    /// How many places it has.
    count: u32,
    sets: SetBits,
    /// The ends of others that its ends are joined to.
    joined: [End; 2],
}

/// Where a part is in a stretch.
#[derive(Debug, Clone, Copy)]
struct Seat {
    stretch: u32,
    /// The number of its first place in the stretch.
    first: u64,
    is_turned: bool,
}

impl<'s> Parts<'s> {
    pub(super) fn new(scratch: &'s Scratch) -> Parts<'s> {
        Parts { scratch, parts: Vec::new(), places: Queue::new(scratch), edges: Queue::new(scratch) }
    }

    /// Takes a part, with heights of the line's own or without, and gives its number.
    pub(super) fn add(&mut self, places: &[u64], levels: &[f64], sets: SetBits) -> Result<u32, ScratchError> {
        let levels = levels.iter().copied().chain(std::iter::repeat(f64::NAN));
        places.iter().zip(levels).try_for_each(|(place, level)| self.places.push([*place, level.to_bits()]))?;
        self.parts.push(Known { count: places.len() as u32, sets, joined: [NONE; 2] });
        Ok(self.parts.len() as u32 - 1)
    }

    /// Joins two ends at one place.
    pub(super) fn join(&mut self, a: End, b: End) {
        for (end, other) in [(a, b), (b, a)] {
            self.parts[end as usize / 2].joined[end as usize % 2] = other;
        }
    }

    /// Takes an edge that begins at a place of a part. It may come more than once.
    pub(super) fn add_edge(&mut self, part: u32, edge: &Edge) -> Result<(), ScratchError> {
        let [a, b, from, to] = edge.record();
        self.edges.push([u64::from(part) << 1 | u64::from(edge.is_on_surface), a, b, from, to])
    }

    /// All stretches, once all parts are there.
    pub(super) fn stretches(self) -> Result<Stretches<'s>, ScratchError> {
        let (seats, kinds) = seats(&self.parts);
        let mut places = Sorter::new(self.scratch, SORT_BYTES);
        let mut records = self.places.into_records();
        for (part, seat) in self.parts.iter().zip(&seats) {
            for (at, record) in (0..u64::from(part.count)).zip(&mut records) {
                let at = if seat.is_turned { u64::from(part.count) - 1 - at } else { at };
                let [place, level] = record?;
                places.push([u64::from(seat.stretch), seat.first + at, place, level])?;
            }
        }
        drop(records);
        let mut edges = Sorter::new(self.scratch, SORT_BYTES);
        for record in self.edges.into_records() {
            let [of, a, b, from, to] = record?;
            let stretch = u64::from(seats[(of >> 1) as usize].stretch);
            edges.push([stretch << 1 | of & 1, a, b, from, to])?;
        }
        let kinds = kinds.into_iter();
        Ok(Stretches { kinds, next: 0, places: places.finish()?.peekable(), edges: edges.finish()?.peekable() })
    }
}

/// Where each part is, and of each stretch the sets and whether it is a ring.
fn seats(parts: &[Known]) -> (Vec<Seat>, Vec<(SetBits, bool)>) {
    const NOWHERE: Seat = Seat { stretch: u32::MAX, first: 0, is_turned: false };
    let mut seats = vec![NOWHERE; parts.len()];
    let mut kinds = Vec::new();
    // What has an end, then rings.
    for is_ring in [false, true] {
        for begin in 0..parts.len() {
            let end = parts[begin].joined.iter().position(|joined| *joined == NONE);
            if seats[begin].stretch != NOWHERE.stretch || !is_ring && end.is_none() {
                continue;
            }
            let (mut part, mut is_turned, mut first) = (begin, end == Some(1), 0);
            loop {
                seats[part] = Seat { stretch: kinds.len() as u32, first, is_turned };
                first += u64::from(parts[part].count) - 1;
                let next = parts[part].joined[usize::from(!is_turned)];
                if next == NONE || next as usize / 2 == begin {
                    break;
                }
                (part, is_turned) = (next as usize / 2, next % 2 == 1);
            }
            kinds.push((parts[begin].sets, is_ring));
        }
    }
    (seats, kinds)
}

/// Stretches one after the other, each with the edges that begin at its places.
pub(super) struct Stretches<'s> {
    kinds: std::vec::IntoIter<(SetBits, bool)>,
    next: u64,
    places: Peekable<Sorted<'s, 4>>,
    edges: Peekable<Sorted<'s, 5>>,
}

impl Stretches<'_> {
    /// The next one.
    pub(super) fn next(&mut self) -> Result<Option<(Stretch, Vec<Edge>)>, ScratchError> {
        let Some((sets, is_ring)) = self.kinds.next() else { return Ok(None) };
        let mut stretch = Stretch { sets, is_ring, ..Stretch::default() };
        let mut last = None;
        let is_of = |record: &Result<[u64; 4], _>| record.as_ref().map_or(true, |record| record[0] == self.next);
        while let Some(record) = self.places.next_if(is_of) {
            let [_, at, place, level] = record?;
            let level = f64::from_bits(level);
            // Two parts have a place in common; one of them may not know how high it is.
            if last.replace(at) == Some(at) {
                stretch.levels.pop_if(|known| known.is_nan()).iter().for_each(|_| stretch.levels.push(level));
            } else {
                stretch.places.push(place);
                stretch.levels.push(level);
            }
        }
        let mut edges: Vec<Edge> = Vec::new();
        let is_of = |record: &Result<[u64; 5], _>| record.as_ref().map_or(true, |record| record[0] >> 1 == self.next);
        while let Some(record) = self.edges.next_if(is_of) {
            let [of, a, b, from, to] = record?;
            let (edge, record): (Edge, EdgeRecord) = (Edge::of_record([a, b, from, to], of & 1 == 1), [a, b, from, to]);
            if edges.last().is_none_or(|last| last.record() != record) {
                edges.push(edge);
            }
        }
        self.next += 1;
        Ok(Some((stretch, edges)))
    }
}
