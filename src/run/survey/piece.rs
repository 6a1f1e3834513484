//! Some rows of samples, surveyed by one thread.

use std::sync::{Mutex, PoisonError};

use super::counting::Counting;
use super::grid::Square;
use super::histogram::{Bins, Histogram};
use super::line::Block;
use super::slopes::{Cell, Class, FROM, Slopes};
use crate::verify::{ObservedRows, RowObserver};

/// What errors are held against.
pub(super) struct Measure {
    pub(super) tolerance: f64,
    pub(super) slopes: Slopes,
    pub(super) bins: Bins,
}

impl Measure {
    /// Nine tenths of the tolerance.
    pub(super) fn nearly(&self) -> f32 {
        (0.9 * self.tolerance) as f32
    }
}

/// What comes out the same in whatever order samples are counted: a thread counts into the same for piece after piece.
pub(super) struct Tally {
    pub(super) histogram: Histogram,
    /// Samples below −ε and above ε.
    pub(super) low: u64,
    pub(super) high: u64,
    /// Samples of all pieces, at least those that were counted.
    samples: u64,
}

/// What some rows come to, as far as it depends on the order.
#[derive(Default)]
pub(super) struct Piece {
    /// The first of the rows.
    pub(super) row: usize,
    pub(super) sum: f64,
    /// By slope, as far as the tally does not know it.
    pub(super) classes: [Class; FROM.len()],
    /// The squares of the map that they go through, row by row.
    pub(super) squares: Vec<Square>,
}

impl Tally {
    /// Samples after which a tally is added up, so that 32 bits hold what it counts.
    const MANY: u64 = 1 << 30;

    fn new(tolerance: f64) -> Tally {
        Tally { histogram: Histogram::new(tolerance), low: 0, high: 0, samples: 0 }
    }
}

impl Piece {
    /// One of nothing, in the place of one that has been used.
    fn renewed(self, rows: &ObservedRows<'_>, side: usize) -> Piece {
        let Piece { mut squares, .. } = self;
        let (row, count) = (rows.first_row, rows.heights.len() / rows.width);
        let down = (row + count - 1) / side - row / side + 1;
        squares.clear();
        squares.resize(rows.width.div_ceil(side) * down, Square::default());
        Piece { row, squares, ..Piece::default() }
    }
}

/// Counts rows, each by the thread that has judged it.
pub(super) struct Counter {
    pub(super) measure: Measure,
    /// The side of a square of the map.
    side: usize,
    desk: Mutex<Desk>,
}

/// What no thread has at the moment.
#[derive(Default)]
struct Desk {
    tallies: Vec<Tally>,
    /// Those that are done, in any order.
    pieces: Vec<Piece>,
    /// Those that have been used.
    used: Vec<Piece>,
}

impl Counter {
    pub(super) fn new(measure: Measure, side: usize) -> Counter {
        Counter { measure, side, desk: Mutex::default() }
    }

    fn desk(&mut self) -> &mut Desk {
        self.desk.get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// Hands the pieces that are done to `add`, in the order of their rows.
    pub(super) fn add_pieces(&mut self, add: impl FnMut(&Piece)) {
        let Desk { pieces, used, .. } = self.desk();
        pieces.sort_unstable_by_key(|piece| piece.row);
        pieces.iter().for_each(add);
        used.append(pieces);
    }

    /// Tallies that have counted enough, to be added up.
    pub(super) fn full(&mut self) -> impl Iterator<Item = Tally> {
        self.desk().tallies.extract_if(.., |tally| tally.samples >= Tally::MANY)
    }

    /// All of them.
    pub(super) fn all(&mut self) -> Vec<Tally> {
        std::mem::take(&mut self.desk().tallies)
    }
}

impl RowObserver for Counter {
    fn rows(&self, rows: &ObservedRows<'_>) {
        let Counter { measure, side, .. } = self;
        let desk = || self.desk.lock().unwrap_or_else(PoisonError::into_inner);
        let (tally, used) = {
            let mut desk = desk();
            (desk.tallies.pop(), desk.used.pop())
        };
        let mut tally = tally.unwrap_or_else(|| Tally::new(measure.tolerance));
        tally.samples += rows.heights.len() as u64;
        let piece = used.unwrap_or_default().renewed(rows, *side);
        let cells: Vec<Cell> =
            (rows.first_row..).take(rows.heights.len() / rows.width).map(|row| measure.slopes.cell(row)).collect();
        let block = Block { rows, cells: &cells, measure, side: *side };
        let mut counting = Counting::new(piece, tally);
        pulp::Arch::new().dispatch(Take { counting: &mut counting, block: &block });
        let (piece, tally) = counting.finish();
        let mut desk = desk();
        desk.pieces.push(piece);
        desk.tallies.push(tally);
    }
}

/// Counting a block, compiled for the processor. Not a closure: those are not always inlined into what is.
struct Take<'a, 'r> {
    counting: &'a mut Counting,
    block: &'a Block<'r>,
}

impl pulp::NullaryFnOnce for Take<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.counting.take(self.block);
    }
}
