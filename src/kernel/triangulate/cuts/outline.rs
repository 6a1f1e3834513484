//! The samples that rays of a sweep read.

use super::frame::Frame;

/// The samples of a triangle over an edge, as a span of columns for each row. Its apex need not be on the lattice, so
/// samples on its sides may be rounded in or out.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    first_row: i32,
    last_row: i32,
    /// The lines that bound the columns from the left, and those from the right; one of them twice.
    left: [Line; 2],
    right: [Line; 2],
    last_column: f64,
}

/// The columns of a line, by rows.
#[derive(Debug, Clone, Copy)]
struct Line {
    at_0: f64,
    slope: f64,
}

impl Line {
    #[inline(always)]
    fn column(&self, row: f64) -> f64 {
        self.at_0 + self.slope * row
    }
}

const NUDGE: f64 = 1e-7;

impl Outline {
    /// No samples.
    pub(super) const EMPTY: Outline = {
        let line = Line { at_0: 0.0, slope: 0.0 };
        Outline { first_row: 0, last_row: -1, left: [line; 2], right: [line; 2], last_column: 0.0 }
    };

    /// The triangle with an apex at this column and row to the left of the edge, within a tile of this size.
    #[inline(always)]
    pub(super) fn new(frame: &Frame, apex: (f64, f64), (width, height): (usize, usize)) -> Outline {
        let (a, b) = (frame.place(0.0, 0.0), frame.place(1.0, 0.0));
        let (mut left, mut right) = ([None; 2], [None; 2]);
        // Walking a → b → apex has the inside to its left: sides that run down the rows bound it from the right.
        for (p, q) in [(a, b), (b, apex), (apex, a)] {
            let down = q.1 - p.1;
            let slope = (q.0 - p.0) / down;
            let line = Some(Line { at_0: p.0 - slope * p.1, slope });
            let side = match down {
                d if d > 0.0 => &mut right,
                d if d < 0.0 => &mut left,
                _ => continue,
            };
            side[usize::from(side[0].is_some())] = line;
        }
        let (Some(l), Some(r)) = (left[0], right[0]) else { return Outline::EMPTY };
        let (top, bottom) = (a.1.min(b.1).min(apex.1), a.1.max(b.1).max(apex.1));
        Outline {
            first_row: ((top - NUDGE).ceil() as i32).max(0),
            last_row: ((bottom + NUDGE).floor() as i32).min(height as i32 - 1),
            left: [l, left[1].unwrap_or(l)],
            right: [r, right[1].unwrap_or(r)],
            last_column: (width - 1) as f64,
        }
    }

    /// First and last of the rows that may hold samples.
    #[inline(always)]
    pub(super) fn rows(&self) -> (i32, i32) {
        (self.first_row, self.last_row)
    }

    /// First and last column of the samples in a row; empty if the first is greater.
    #[inline(always)]
    pub(super) fn columns(&self, row: i32) -> (i32, i32) {
        if row < self.first_row || row > self.last_row {
            return (1, 0);
        }
        let row = f64::from(row);
        let left = self.left[0].column(row).max(self.left[1].column(row)).max(0.0);
        let right = self.right[0].column(row).min(self.right[1].column(row)).min(self.last_column);
        // Where this is below −1 the conversion rounds up, but stays below 0.
        ((left + (1.0 - NUDGE)) as i32, if right < -NUDGE { -1 } else { (right + NUDGE) as i32 })
    }
}
