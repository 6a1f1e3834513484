//! A rectangle of samples.

/// A rectangle of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Window {
    /// First column.
    pub column: usize,
    /// First row.
    pub row: usize,
    /// Samples across.
    pub width: usize,
    /// Samples down.
    pub height: usize,
}

impl Window {
    /// How many samples it holds.
    pub fn len(&self) -> usize {
        self.width * self.height
    }

    /// Whether it holds none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether it has a surface, and lies in a raster of this size.
    pub fn is_usable_in(&self, (width, height): (usize, usize)) -> bool {
        let inside = |first: usize, count: usize, all: usize| first.checked_add(count).is_some_and(|end| end <= all);
        inside(self.column, self.width, width)
            && inside(self.row, self.height, height)
            && self.width >= 2
            && self.height >= 2
    }

    /// The smallest window that holds all samples between places, which are columns and rows with fractions, in a raster of this
    /// size.
    ///
    /// # Errors
    /// How many columns and rows are between them, where one of the two is less than 2.
    pub fn between(places: &[(f64, f64)], (width, height): (usize, usize)) -> Result<Window, (usize, usize)> {
        let range = |of: fn(&(f64, f64)) -> f64| {
            let values = places.iter().map(of);
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (columns, rows) = (inside(range(|p| p.0), width), inside(range(|p| p.1), height));
        let window = Window { column: columns.0, row: rows.0, width: columns.1, height: rows.1 };
        if columns.1 < 2 || rows.1 < 2 { Err((columns.1, rows.1)) } else { Ok(window) }
    }
}

/// How far outside of a box a sample may be and count as inside, in cells: decimals are rounded.
const ROUNDING_CELLS: f64 = 1e-6;

/// The whole numbers from 0 to `all` − 1 in a range: the first, and how many.
fn inside((low, high): (f64, f64), all: usize) -> (usize, usize) {
    // Saturates where the box is far away.
    let first = (low - ROUNDING_CELLS).ceil().max(0.0) as i64;
    let last = (high + ROUNDING_CELLS).floor().min(all as f64 - 1.0) as i64;
    (first as usize, usize::try_from(last.saturating_sub(first).saturating_add(1)).unwrap_or(0))
}

/// As `--window` takes it.
impl std::fmt::Display for Window {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{},{},{},{}", self.column, self.row, self.width, self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_samples_in_a_range() {
        let cases = [
            ((-3.0, 9.0), (0, 5)),
            ((1.0, 3.0), (1, 3)),
            ((1.0 + 1e-9, 3.0 - 1e-9), (1, 3)),
            ((1.1, 3.9), (2, 2)),
            ((1.1, 2.9), (2, 1)),
            ((-1e300, 1e300), (0, 5)),
        ];
        for (range, expected) in cases {
            assert_eq!(inside(range, 5), expected, "{range:?}");
        }
        for nowhere in [(7.0, 9.0), (-9.0, -7.0), (f64::INFINITY, f64::NEG_INFINITY)] {
            assert_eq!(inside(nowhere, 5).1, 0, "{nowhere:?}");
        }
    }

    #[test]
    fn a_window_reaches_no_farther_than_the_raster() {
        let usable = |column, row, width, height| Window { column, row, width, height }.is_usable_in((5, 4));
        assert!(usable(0, 0, 5, 4) && usable(3, 2, 2, 2));
        assert!(!usable(3, 2, 3, 2) && !usable(3, 2, 2, 1) && !usable(usize::MAX, 0, 2, 2));
    }
}
