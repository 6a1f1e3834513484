//! The samples of a triangle, one row after the other.

use super::grid::STEPS;
use super::triangle::{RowSpan, Triangle, divide};

/// The samples that a triangle holds of one row after the other, from a first row on: what [`Triangle::row_span`] says of
/// each.
///
/// From row to row a side moves by the same fraction of a column, so whole part and rest are added up, without a division.
pub(super) enum Spans {
    /// Of corners below [`Triangle::is_small`]'s limit, where 64 bits hold every product.
    Stepped([Side; 3]),
    /// Of others, row by row anew.
    Anew(Triangle, i64),
}

/// A side of a triangle. With n = rise · px + run · (y − py), a sample of row y is to the inner side where
/// n − rise · x > 0, and on it where that is 0, as in [`Triangle::row_span`]; x = [`STEPS`] · column.
pub(super) struct Side {
    /// Which end of the span it is, of a side that is not along the row.
    end: End,
    /// n / ([`STEPS`] · |rise|), rounded down; n itself of a side along the row.
    column: i64,
    /// What is left over.
    rest: i64,
    /// What the next row adds to both.
    column_step: i64,
    rest_step: i64,
    divisor: i64,
}

enum End {
    Left,
    Right,
    Along,
}

impl Side {
    fn new(p: (i64, i64), q: (i64, i64), row: i64) -> Side {
        let (run, rise) = (q.0 - p.0, q.1 - p.1);
        let (at_row, step) = (rise * p.0 + run * (STEPS * row - p.1), STEPS * run);
        if rise == 0 {
            return Side { end: End::Along, column: at_row, rest: 0, column_step: step, rest_step: 0, divisor: 1 };
        }
        let divisor = STEPS * rise.abs();
        let end = if rise > 0 { End::Right } else { End::Left };
        let ((column, rest), (column_step, rest_step)) = (divide(at_row, divisor), divide(step, divisor));
        Side { end, column, rest, column_step, rest_step, divisor }
    }

    fn advance(&mut self) {
        self.column += self.column_step;
        self.rest += self.rest_step;
        if self.rest >= self.divisor {
            self.column += 1;
            self.rest -= self.divisor;
        }
    }
}

impl Spans {
    /// From row `first` on, which is one of the triangle's [`Triangle::rows`].
    pub(super) fn new(triangle: &Triangle, first: i64) -> Spans {
        let [a, b, c] = triangle.corners;
        match triangle.is_small() {
            true => Spans::Stepped([(a, b), (b, c), (c, a)].map(|(p, q)| Side::new(p, q, first))),
            false => Spans::Anew(*triangle, first),
        }
    }

    /// The span of the next row of `width` samples; `None` where it is empty.
    pub(super) fn next(&mut self, width: i64) -> Option<RowSpan> {
        let sides = match self {
            Spans::Stepped(sides) => sides,
            Spans::Anew(triangle, row) => {
                *row += 1;
                return triangle.row_span(*row - 1, width);
            }
        };
        let (mut closed, mut interior) = ((0, width - 1), (0, width - 1));
        for side in sides {
            let on_side = i64::from(side.rest == 0);
            match side.end {
                End::Right => {
                    closed.1 = closed.1.min(side.column);
                    interior.1 = interior.1.min(side.column - on_side);
                }
                End::Left => {
                    closed.0 = closed.0.max(-side.column);
                    interior.0 = interior.0.max(-side.column + on_side);
                }
                End::Along if side.column < 0 => closed.1 = -1,
                End::Along if side.column == 0 => interior = (0, -1),
                End::Along => {}
            }
            side.advance();
        }
        (closed.0 <= closed.1).then_some(RowSpan { closed, interior })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn spans_are_those_of_each_row_by_itself(
            corners in prop_oneof![
                proptest::array::uniform3((-40i64..80, -40i64..80)),
                proptest::array::uniform3((-1i64 << 27..1 << 27, -1i64 << 27..1 << 27)),
            ],
            start in 0f64..1.0,
        ) {
            let Some(triangle) = Triangle::new(0, corners, [0.0; 3]) else { return Ok(()) };
            let ys = corners.map(|c| c.1);
            let (low, high) = (ys.iter().min().unwrap(), ys.iter().max().unwrap());
            let (first, last) = (-(-low).div_euclid(STEPS), high.div_euclid(STEPS));
            let first = first + (start * (last + 1 - first) as f64) as i64;
            let mut spans = Spans::new(&triangle, first);
            prop_assert!(matches!(spans, Spans::Stepped(_)));
            for row in (first..=last).take(50) {
                prop_assert_eq!(spans.next(17), triangle.row_span(row, 17), "row {}", row);
            }
        }
    }
}
