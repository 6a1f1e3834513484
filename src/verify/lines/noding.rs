//! Lines that cross are joined at places of the lattice, until nothing changes.
//!
//! Hot places are ends of segments, and the places nearest to where two cross. A segment goes through all hot places whose square it
//! meets, half a step around each, lower and right sides left out; in the order of their shadows on it. All of that is done to all
//! segments at once, in *rounds*.
//!
//! A segment and what it is led through lie in one closed cell. So what becomes of a row of cells in a round is known from that row
//! and from those above and below, as they were before the round: rows pass from the first to the last, and each round runs two rows
//! behind the one before. Nothing is left out and nothing comes too early, so pieces are those that rounds over the whole raster make.
//! A row is looked at where the round before has changed it or one next to it; elsewhere the same would come out again.

use std::collections::VecDeque;
use std::sync::{Arc, OnceLock};

use super::Spot;
use super::pieces::{Counted, Piece, Record};
use crate::base::external::{Queue, Scratch, ScratchError, Sorted};

/// Rounds that follow each other as rows pass. If the last one changes something, rows pass once more.
const ROUNDS: usize = if cfg!(test) { 2 } else { 8 };

/// Pieces joined, each once and in the order of their rows of cells, of pieces in that order.
///
/// Memory: some 250 bytes for each piece in three rows of cells, in each round that changes them.
pub(super) fn noded<'s>(sorted: Sorted<'s, 6>, rows: i64, scratch: &'s Scratch) -> Result<Queue<'s, 6>, ScratchError> {
    let (mut queue, mut is_done) = pass(sorted, rows, scratch)?;
    while !is_done {
        (queue, is_done) = pass(queue.into_records(), rows, scratch)?;
    }
    Ok(queue)
}

/// All rounds once, and whether the last has changed nothing.
fn pass<'s>(
    records: impl Iterator<Item = Result<Record, ScratchError>>,
    rows: i64,
    scratch: &'s Scratch,
) -> Result<(Queue<'s, 6>, bool), ScratchError> {
    let mut rounds: Vec<Round> = (0..ROUNDS).map(|_| Round::default()).collect();
    let (mut queue, mut is_done) = (Queue::new(scratch), true);
    let mut by_row = ByRow::new(records);
    // As many empty rows at the end as there are rounds: each is a row behind.
    for row in 0..rows + ROUNDS as i64 {
        let mut passing = Passing { row: Arc::new(Row::of(by_row.pieces(row)?)), is_new: true };
        for (behind, round) in (1..).zip(&mut rounds) {
            passing = round.take(passing, row - behind);
        }
        is_done &= !passing.is_new;
        passing.row.pieces.iter().try_for_each(|(piece, times)| queue.push(piece.record(*times)))?;
    }
    Ok((queue, is_done))
}

/// Pieces by rows of cells, of records in that order.
pub(super) struct ByRow<I: Iterator> {
    records: std::iter::Peekable<I>,
}

impl<I: Iterator<Item = Result<Record, ScratchError>>> ByRow<I> {
    pub(super) fn new(records: I) -> Self {
        ByRow { records: records.peekable() }
    }

    /// Those of a row, each once, in order; rows are asked for one after the other.
    pub(super) fn pieces(&mut self, row: i64) -> Result<Vec<Counted>, ScratchError> {
        let mut pieces = Vec::new();
        let is_of_row = |record: &Result<Record, _>| {
            record.as_ref().map_or(true, |record| Piece::of_record(*record).0.row() == row)
        };
        while let Some(record) = self.records.next_if(is_of_row) {
            pieces.push(Piece::of_record(record?));
        }
        Ok(counted(pieces))
    }
}

/// The pieces whose first places are in a row of cells.
#[derive(Debug, Default)]
struct Row {
    pieces: Vec<Counted>,
    hot: OnceLock<Vec<Spot>>,
}

impl Row {
    fn of(pieces: Vec<Counted>) -> Row {
        Row { pieces, hot: OnceLock::new() }
    }

    /// The hot places that its pieces make, in order; they are in the closed row of cells.
    fn hot(&self) -> &[Spot] {
        self.hot.get_or_init(|| hot_places(&self.pieces))
    }
}

/// A row on its way through the rounds, and whether the round before has changed it.
#[derive(Debug, Default)]
struct Passing {
    row: Arc<Row>,
    is_new: bool,
}

/// One round over all rows: it holds the last two that came.
#[derive(Debug, Default)]
struct Round {
    last: VecDeque<Passing>,
    /// Of the row that was led last, what has come to lie on the line to the next.
    come: Vec<Counted>,
}

impl Round {
    /// Takes the next row and gives the one above it, of this number.
    fn take(&mut self, below: Passing, number: i64) -> Passing {
        self.last.push_back(below);
        let [above, here, below] = match self.last.make_contiguous() {
            [here, below] => [None, Some(&*here), Some(&*below)],
            [above, here, below] => [Some(&*above), Some(&*here), Some(&*below)],
            _ => return Passing::default(),
        };
        let (Some(here), Some(below)) = (here, below) else { unreachable!("two rows at the least") };
        let come = std::mem::take(&mut self.come);
        let is_near = |passing: Option<&Passing>| passing.is_some_and(|passing| passing.is_new);
        let is_led = !here.row.pieces.is_empty() && [above, Some(here), Some(below)].into_iter().any(is_near);
        let mut pieces = come;
        if is_led {
            let hot = hot_around(above.map(|above| &*above.row), &here.row, &below.row, number);
            let (here_still, gone) = led_once(&here.row.pieces, &hot, number);
            pieces.extend(here_still);
            self.come = gone;
        } else if !pieces.is_empty() {
            pieces.extend_from_slice(&here.row.pieces);
        }
        let row = here.row.clone();
        let is_same = !is_led && pieces.is_empty() || {
            pieces = counted(pieces);
            pieces == row.pieces
        };
        if self.last.len() == 3 {
            self.last.pop_front();
        }
        if is_same { Passing { row, is_new: false } } else { Passing { row: Arc::new(Row::of(pieces)), is_new: true } }
    }
}

/// Pieces in order, each once.
pub(super) fn counted(mut all: Vec<Counted>) -> Vec<Counted> {
    all.sort_unstable();
    all.dedup_by(|more, piece| {
        let is_same = more.0 == piece.0;
        if is_same {
            piece.1 += more.1;
        }
        is_same
    });
    all
}

/// The ends of pieces, and the places nearest to where two of one cell cross; in order.
pub(super) fn hot_places(pieces: &[Counted]) -> Vec<Spot> {
    let mut hot: Vec<Spot> = pieces.iter().flat_map(|(piece, _)| piece.ends).collect();
    let cell = |[a, b]: [Spot; 2]| (a.0.min(b.0) >> 2, a.1.min(b.1) >> 2);
    let mut by_cell: Vec<(Spot, [Spot; 2])> = pieces.iter().map(|(piece, _)| (cell(piece.ends), piece.ends)).collect();
    by_cell.sort_unstable();
    by_cell.dedup();
    for of_cell in by_cell.chunk_by(|s, t| s.0 == t.0) {
        for (i, &(_, s)) in of_cell.iter().enumerate() {
            hot.extend(of_cell[..i].iter().filter_map(|&(_, t)| meeting(s, t)));
        }
    }
    hot.sort_unstable();
    hot.dedup();
    hot
}

/// The hot places in a closed row of cells.
fn hot_around(above: Option<&Row>, here: &Row, below: &Row, number: i64) -> Vec<Spot> {
    let [top, bottom] = [4 * number, 4 * number + 4];
    let above = above.map_or(&[][..], Row::hot).iter().filter(|spot| spot.1 == top);
    let below = below.hot().iter().filter(|spot| spot.1 == bottom);
    let mut hot: Vec<Spot> = here.hot().iter().chain(above).chain(below).copied().collect();
    hot.sort_unstable();
    hot.dedup();
    hot
}

/// The pieces of a row of cells led through hot places: those that are still in the row, and those on the line below it.
fn led_once(pieces: &[Counted], hot: &[Spot], number: i64) -> (Vec<Counted>, Vec<Counted>) {
    let (mut here, mut gone) = (Vec::with_capacity(pieces.len()), Vec::new());
    let mut way = Vec::new();
    for (piece, times) in pieces {
        lead(piece, hot, &mut way);
        let part = |pair: &[Spot]| {
            let [from, to] = [pair[0], pair[1]].map(|spot| (spot, piece.height_near(spot)));
            Piece::new((piece.set, piece.line), from, to)
        };
        for part in way.windows(2).map(part) {
            let parts = if part.row() == number { &mut here } else { &mut gone };
            parts.push((part, *times));
        }
    }
    (here, gone)
}

/// The place nearest to where two segments cross, if they do so strictly inside of both; of two the one on the right, or below.
fn meeting([a, b]: [Spot; 2], [c, d]: [Spot; 2]) -> Option<Spot> {
    let ((ux, uy), (vx, vy), (wx, wy)) = ((b.0 - a.0, b.1 - a.1), (d.0 - c.0, d.1 - c.1), (c.0 - a.0, c.1 - a.1));
    // a + s/n·u = c + t/n·v
    let (mut n, mut s, mut t) = (ux * vy - uy * vx, wx * vy - wy * vx, wx * uy - wy * ux);
    if n < 0 {
        (n, s, t) = (-n, -s, -t);
    }
    let is_inside = |share: i64| 0 < share && share < n;
    let nearest = |over: i64| (2 * over + n).div_euclid(2 * n);
    (is_inside(s) && is_inside(t)).then(|| (a.0 + nearest(ux * s), a.1 + nearest(uy * s)))
}

/// The places that a piece is led through, both ends among them.
pub(super) fn lead(piece: &Piece, hot: &[Spot], way: &mut Vec<Spot>) {
    let [a, b] = piece.ends;
    let u = (b.0 - a.0, b.1 - a.1);
    way.clear();
    way.extend([a, b]);
    let (left, right) = (a.0.min(b.0), a.0.max(b.0));
    let near = hot[hot.partition_point(|spot| spot.0 < left)..].iter().take_while(|spot| spot.0 <= right);
    let is_between = |spot: &&Spot| (a.1..=b.1).contains(&spot.1) && **spot != a && **spot != b;
    way.extend(near.filter(is_between).filter(|spot| meets(a, u, **spot)));
    if way.len() > 2 {
        way.sort_by_key(|p| ((p.0 - a.0) * u.0 + (p.1 - a.1) * u.1, p.1, p.0));
    }
}

/// Whether a + share·u is in the square of a place for a share from 0 to 1. If so, then at one where the segment ends or comes to a
/// side's line, or in the middle between two such.
fn meets(a: Spot, u: Spot, place: Spot) -> bool {
    let mut shares = [(0, 1); 6];
    shares[1] = (1, 1);
    let mut count = 2;
    for (from, run, at) in [(a.0, u.0, place.0), (a.1, u.1, place.1)] {
        for side in [2 * at - 1, 2 * at + 1] {
            let over = (side - 2 * from) * run.signum();
            if run != 0 && (0..=2 * run.abs()).contains(&over) {
                shares[count] = (over, 2 * run.abs());
                count += 1;
            }
        }
    }
    let is_in = |(over, under): (i64, i64)| {
        [(a.0, u.0, place.0), (a.1, u.1, place.1)].into_iter().all(|(from, run, at)| {
            let doubled = 2 * (from * under + run * over);
            ((2 * at - 1) * under..(2 * at + 1) * under).contains(&doubled)
        })
    };
    let shares = &shares[..count];
    let middles = shares.iter().flat_map(|p| shares.iter().map(move |q| (p.0 * q.1 + q.0 * p.1, 2 * p.1 * q.1)));
    shares.iter().copied().chain(middles).any(is_in)
}
