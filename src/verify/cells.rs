//! The ground of one row of cells, as its quarter rows see it.

use super::crossing::{Crossing, Side, Span};
use super::grid::STEPS;
use super::ground::state::{STRIP, VALID};

/// A side of the ground: x on the line above the cells, and the steps to the right from one quarter row to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct End {
    x: i64,
    step: i64,
}

impl End {
    fn side(self, quarter: i64) -> Side {
        let at = |line: i64| Crossing::at(self.x + self.step * line);
        Side { top: at(quarter), bottom: at(quarter + 1) }
    }
}

/// The ground of a row of cells from left to right, and its *core*: the cells all of whose corners are beyond the strip,
/// which are whole. Neighbours along a side are one.
#[derive(Debug, Default)]
pub(super) struct CellRow {
    ground: Vec<(End, End)>,
    core: Vec<(End, End)>,
}

impl CellRow {
    /// From the states of the samples above and below; half cells are left out where `is_crossed` says so of their columns.
    pub(super) fn new(above: &[u8], below: &[u8], is_crossed: impl Fn(usize) -> bool) -> CellRow {
        let mut row = CellRow::default();
        for (column, (upper, lower)) in above.windows(2).zip(below.windows(2)).enumerate() {
            let corners = [upper[0], upper[1], lower[0], lower[1]];
            let x = STEPS * column as i64;
            let (left, right) = (End { x, step: 0 }, End { x: x + STEPS, step: 0 });
            let cell = match corners.map(|s| s & VALID != 0) {
                [true, true, true, true] => (left, right),
                _ if is_crossed(column) => continue,
                // Half cells: the diagonal rises from the left, or falls.
                [false, true, true, true] => (End { x: x + STEPS, step: -1 }, right),
                [true, true, true, false] => (left, End { x: x + STEPS, step: -1 }),
                [true, false, true, true] => (left, End { x, step: 1 }),
                [true, true, false, true] => (End { x, step: 1 }, right),
                _ => continue,
            };
            push(&mut row.ground, cell);
            if corners.iter().all(|s| s & (VALID | STRIP) == VALID) {
                push(&mut row.core, cell);
            }
        }
        row
    }

    pub(super) fn ground(&self, quarter: i64) -> Vec<Span> {
        spans(&self.ground, quarter)
    }

    pub(super) fn core(&self, quarter: i64) -> Vec<Span> {
        spans(&self.core, quarter)
    }

    /// Twice the core's area, in lattice steps squared.
    pub(super) fn core_double_area(&self) -> i64 {
        self.core.iter().map(|(left, right)| 2 * STEPS * (right.x - left.x)).sum()
    }
}

fn spans(ends: &[(End, End)], quarter: i64) -> Vec<Span> {
    ends.iter().map(|(left, right)| Span { left: left.side(quarter), right: right.side(quarter) }).collect()
}

/// Adds a cell, to the one before it where they share a side.
fn push(spans: &mut Vec<(End, End)>, (left, right): (End, End)) {
    match spans.last_mut() {
        Some((_, end)) if *end == left && left.step == 0 => *end = right,
        _ => spans.push((left, right)),
    }
}
