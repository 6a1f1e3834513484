//! Where an edge crosses rows and columns of samples.

use super::grid::STEPS;
use super::triangle::divide;

/// What an edge crosses within a row of cells, its last line included and its first one not: neither samples nor the edge's ends
/// are crossings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Crossed {
    /// The row of samples below the cells.
    pub(super) row: i64,
    /// The columns that it crosses between that row and the row above: first and last, the first after the last if there
    /// is none.
    pub(super) columns: (i64, i64),
    /// It crosses the row itself between this column and the next.
    pub(super) in_row: Option<i64>,
}

/// Walks down an edge, one row of cells after the other. From row to row it moves by the same fraction of a column, so whole
/// part and rest are added up, without a division.
#[derive(Debug)]
pub(super) struct Walk {
    upper: (i64, i64),
    lower: (i64, i64),
    /// The next row of samples below cells that it meets, and the last one.
    row: i64,
    last: i64,
    /// Where it enters these cells.
    entry: Place,
    /// Where it crosses the line above them, or would.
    column: i64,
    rest: i64,
    /// What the next line adds to both.
    column_step: i64,
    rest_step: i64,
    divisor: i64,
}

/// Between two columns, or on the first of them.
#[derive(Debug, Clone, Copy)]
struct Place {
    column: i64,
    is_whole: bool,
}

impl Place {
    fn of(x: i64) -> Place {
        Place { column: x.div_euclid(STEPS), is_whole: x.rem_euclid(STEPS) == 0 }
    }

    /// The columns that lie strictly between two places.
    fn columns_between(self, other: Place) -> (i64, i64) {
        (self.column + 1, other.column - i64::from(other.is_whole))
    }
}

/// The end of an edge that a walk begins at: the upper one, or of two in one line the left one.
pub(super) fn begins(p: (i64, i64), q: (i64, i64)) -> bool {
    (p.1, p.0) < (q.1, q.0)
}

impl Walk {
    /// Along the part of an edge in cells above these rows of samples, first and first one after. `upper` [`begins`] it.
    /// Coordinates are below 2⁴¹.
    pub(super) fn new(upper: (i64, i64), lower: (i64, i64), rows: (i64, i64)) -> Walk {
        let (run, rise) = (lower.0 - upper.0, lower.1 - upper.1);
        let row = rows.0.max(upper.1.div_euclid(STEPS) + 1);
        let last = (rows.1 - 1).min(-(-lower.1).div_euclid(STEPS));
        let mut walk = Walk {
            upper,
            lower,
            row,
            last,
            entry: Place::of(upper.0),
            column: 0,
            rest: 0,
            column_step: 0,
            rest_step: 0,
            divisor: 1,
        };
        let line = STEPS * (row - 1);
        // Between two lines there is nothing more to know.
        if row <= last && (line > upper.1 || line + STEPS < lower.1) {
            walk.divisor = STEPS * rise;
            let at_line = i128::from(rise) * i128::from(upper.0) + i128::from(run) * i128::from(line - upper.1);
            (walk.column, walk.rest) = divide_wide(at_line, walk.divisor);
            let (step, rest) = divide(run, rise);
            (walk.column_step, walk.rest_step) = (step, STEPS * rest);
            if line > upper.1 {
                walk.entry = walk.place();
            }
        }
        walk
    }

    fn place(&self) -> Place {
        Place { column: self.column, is_whole: self.rest == 0 }
    }
}

/// The quotient by a positive number, rounded down, and what is left over. Most numerators are small.
fn divide_wide(numerator: i128, divisor: i64) -> (i64, i64) {
    match i64::try_from(numerator) {
        Ok(numerator) => divide(numerator, divisor),
        Err(_) => {
            let divisor = i128::from(divisor);
            (numerator.div_euclid(divisor) as i64, numerator.rem_euclid(divisor) as i64)
        }
    }
}

impl Iterator for Walk {
    type Item = Crossed;

    #[inline]
    fn next(&mut self) -> Option<Crossed> {
        let row = self.row;
        if row > self.last {
            return None;
        }
        let goes_on = STEPS * row < self.lower.1;
        let mut exit = Place::of(self.lower.0);
        if goes_on {
            self.column += self.column_step;
            self.rest += self.rest_step;
            if self.rest >= self.divisor {
                self.column += 1;
                self.rest -= self.divisor;
            }
            exit = self.place();
        }
        let columns = match self.lower.0 >= self.upper.0 {
            true => self.entry.columns_between(exit),
            false => exit.columns_between(self.entry),
        };
        self.entry = exit;
        self.row += 1;
        Some(Crossed { row, columns, in_row: (goes_on && !exit.is_whole).then_some(exit.column) })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Column by column, row by row, by signs of exact products.
    fn naive(upper: (i64, i64), lower: (i64, i64), row: i64) -> Crossed {
        let (run, rise) = (lower.0 - upper.0, lower.1 - upper.1);
        let side =
            |x: i64, y: i64| i128::from(run) * i128::from(y - upper.1) - i128::from(rise) * i128::from(x - upper.0);
        let (left, right) = (upper.0.min(lower.0), upper.0.max(lower.0));
        // A column is crossed strictly between two samples if these lie to different sides.
        let crosses = |&c: &i64| {
            let x = STEPS * c;
            let (above, below) = (side(x, STEPS * (row - 1)), side(x, STEPS * row));
            left < x && x < right && above.signum() * below.signum() < 0
        };
        let columns: Vec<i64> = (left / STEPS - 2..right / STEPS + 2).filter(crosses).collect();
        let (first, last) = (columns.first().copied(), columns.last().copied());
        assert!(columns.is_empty() || columns.len() as i64 == last.unwrap() - first.unwrap() + 1);
        let y = STEPS * row;
        let in_row = (upper.1 < y && y < lower.1)
            .then(|| {
                (left / STEPS - 2..right / STEPS + 2)
                    .find(|c| side(STEPS * c, y).signum() * side(STEPS * (c + 1), y).signum() < 0)
            })
            .flatten();
        Crossed { row, columns: first.zip(last).unwrap_or((1, 0)), in_row }
    }

    fn same(found: Crossed, expected: Crossed) -> bool {
        let is_none = |(first, last): (i64, i64)| first > last;
        let columns = found.columns == expected.columns || is_none(found.columns) && is_none(expected.columns);
        columns && (found.row, found.in_row) == (expected.row, expected.in_row)
    }

    proptest! {
        #[test]
        fn crossings_are_those_of_each_row_and_column_by_itself(
            p in (-20i64..60, -20i64..60), q in (-20i64..60, -20i64..60), first in -9i64..20, rows in 1i64..20,
        ) {
            prop_assume!(p != q);
            let (upper, lower) = if begins(p, q) { (p, q) } else { (q, p) };
            let mut found = Walk::new(upper, lower, (first, first + rows)).peekable();
            for row in first..first + rows {
                let expected = naive(upper, lower, row);
                match found.next_if(|crossed| crossed.row == row) {
                    Some(crossed) => prop_assert!(same(crossed, expected), "{:?} {:?}", crossed, expected),
                    None => prop_assert!(same(Crossed { row, columns: (1, 0), in_row: None }, expected), "{:?}", expected),
                }
            }
            prop_assert_eq!(found.next(), None);
        }
    }

    #[test]
    fn far_edges_are_exact() {
        let far = 1 << 40;
        // Three rows lower over all that way, from between two rows to between two others.
        let crossed: Vec<Crossed> = Walk::new((-far, 1), (far, 14), (0, 9)).collect();
        let column = |y: i128| ((2 * i128::from(far) * (y - 1)).div_euclid(13) as i64 - far).div_euclid(STEPS);
        let lines: Vec<Option<i64>> = crossed.iter().map(|found| found.in_row).collect();
        assert_eq!(lines, [Some(column(4)), Some(column(8)), Some(column(12)), None]);
        assert_eq!(crossed[1].columns, (column(4) + 1, column(8)));
        assert_eq!(crossed[3].columns, (column(12) + 1, far / STEPS - 1));
    }
}
