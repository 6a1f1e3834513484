//! Some rows of samples, surveyed by one thread.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use super::counting::{Block, Counting};
use super::grid::MapCell;
use super::histogram::{Bins, Histogram};
use super::slopes::{Cell, Class, FROM, Slopes};
use crate::verify::ObservedRows;

/// Samples of a piece, and its columns, about.
const SAMPLES: usize = 1 << 15;
const COLUMNS: usize = 1 << 11;

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

/// Tallies that no thread has at the moment.
pub(super) struct Tallies {
    tolerance: f64,
    idle: Mutex<Vec<Tally>>,
}

/// What some rows come to, as far as it depends on the order.
pub(super) struct Piece {
    pub(super) sum: f64,
    /// By slope, as far as the tally does not know it.
    pub(super) classes: [Class; FROM.len()],
    /// The squares of the map that it goes through, row by row, and the column and the row of the first.
    pub(super) cells: Vec<MapCell>,
    pub(super) first: (usize, usize),
    /// Squares in a row of them.
    pub(super) across: usize,
}

impl Tally {
    /// Samples after which a tally is added up, so that 32 bits hold what it counts.
    const MANY: u64 = 1 << 30;

    fn new(tolerance: f64) -> Tally {
        Tally { histogram: Histogram::new(tolerance), low: 0, high: 0, samples: 0 }
    }
}

impl Tallies {
    pub(super) fn new(tolerance: f64) -> Tallies {
        Tallies { tolerance, idle: Mutex::default() }
    }

    fn take(&self) -> Tally {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        idle.unwrap_or_else(|| Tally::new(self.tolerance))
    }

    fn put_back(&self, tally: Tally) {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(tally);
    }

    /// Those that have counted enough, to be added up.
    pub(super) fn full(&mut self) -> impl Iterator<Item = Tally> {
        let idle = self.idle.get_mut().unwrap_or_else(PoisonError::into_inner);
        idle.extract_if(.., |tally| tally.samples >= Tally::MANY)
    }

    /// All of them.
    pub(super) fn all(self) -> Vec<Tally> {
        self.idle.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Piece {
    /// The pieces of these rows, in order; `above` are the heights of the row above the first one, or none, and `side` samples make
    /// the side of a square of the map.
    pub(super) fn all_of(
        rows: &ObservedRows<'_>,
        above: &[f64],
        measure: &Measure,
        side: usize,
        tallies: &Tallies,
    ) -> Vec<Piece> {
        let (width, count) = (rows.width, rows.heights.len() / rows.width);
        let across = COLUMNS.next_multiple_of(side);
        let down = (SAMPLES / across.min(width)).max(1);
        let in_row = width.div_ceil(across);
        let cells: Vec<Cell> = (0..count).map(|at| measure.slopes.cell(rows.first_row + at)).collect();
        // There is none above the first row: it is level along columns.
        let above = if above.is_empty() { &rows.heights[..width] } else { above };
        let piece = |index: usize| {
            let (left, top) = (index % in_row * across, index / in_row * down);
            let (columns, lines) = (left..(left + across).min(width), top..(top + down).min(count));
            let mut tally = tallies.take();
            tally.samples += (columns.len() * lines.len()) as u64;
            let block = Block { rows, above, cells: &cells, measure, side, columns, lines };
            let mut counting = Counting::new(Piece::new(&block), tally);
            pulp::Arch::new().dispatch(Take { counting: &mut counting, block: &block });
            let (piece, tally) = counting.finish();
            tallies.put_back(tally);
            piece
        };
        (0..in_row * count.div_ceil(down)).into_par_iter().map(piece).collect()
    }

    fn new(block: &Block<'_>) -> Piece {
        let Block { rows, side, columns, lines, .. } = block;
        let first = (columns.start / side, (rows.first_row + lines.start) / side);
        let last = ((columns.end - 1) / side, (rows.first_row + lines.end - 1) / side);
        let across = last.0 - first.0 + 1;
        let cells = vec![MapCell::default(); across * (last.1 - first.1 + 1)];
        Piece { sum: 0.0, classes: [Class::default(); FROM.len()], cells, first, across }
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
