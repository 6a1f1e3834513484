//! The samples around lines.

use std::ops::Range;

use super::Spot;
use crate::base::control::CancelToken;
use crate::base::{Band, Window};
use crate::verify::{HeightReader, VerifyError};

/// Samples by row and column, with their heights: NaN where there is none. Memory: 24 bytes for each.
#[derive(Debug)]
pub(super) struct Samples {
    places: Vec<(i64, i64)>,
    heights: Vec<f64>,
}

/// The cells that hold a segment, by column and row of their upper left corners.
pub(super) fn cells([a, b]: [Spot; 2]) -> impl Iterator<Item = (i64, i64)> {
    let around = |p: i64, q: i64| (p.min(q) >> 2) - 1..=p.min(q) >> 2;
    let holds = |first: i64, p: i64, q: i64| 4 * first <= p.min(q) && p.max(q) <= 4 * first + 4;
    let columns = around(a.0, b.0).filter(move |&c| holds(c, a.0, b.0));
    columns.flat_map(move |c| around(a.1, b.1).filter(move |&r| holds(r, a.1, b.1)).map(move |r| (c, r)))
}

fn corners((column, row): (i64, i64)) -> [(i64, i64); 4] {
    [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)]
}

impl Samples {
    /// Reads the corners of all cells that hold a segment, and the samples beside all places where an edge crosses rows or columns, in
    /// some rows and between each and the next.
    pub(super) fn read(
        raster: &Band,
        segments: &[[Spot; 2]],
        (edges, rows): (&[[Spot; 2]], &Range<i64>),
        cancel: &CancelToken,
    ) -> Result<Samples, VerifyError> {
        let (width, height) = (raster.width() as i64, raster.height() as i64);
        let mut places: Vec<(i64, i64)> = segments.iter().flat_map(|&s| cells(s)).flat_map(corners).collect();
        for &[a, b] in edges {
            for_each_crossing(a, b, |crossing| {
                let (row, column) = crossing.sample;
                if rows.contains(&row) {
                    places.extend([
                        (row, column),
                        if crossing.is_column { (row + 1, column) } else { (row, column + 1) },
                    ]);
                }
            });
        }
        places.retain(|&(row, column)| (0..height).contains(&row) && (0..width).contains(&column));
        places.sort_unstable();
        places.dedup();
        let mut reader = HeightReader::new(raster);
        let (mut heights, mut line) = (Vec::with_capacity(places.len()), Vec::new());
        for of_row in places.chunk_by(|a, b| a.0 == b.0) {
            cancel.check()?;
            let (row, first, last) = (of_row[0].0, of_row[0].1, of_row[of_row.len() - 1].1);
            let window =
                Window { column: first as usize, row: row as usize, width: (last - first + 1) as usize, height: 1 };
            line.resize(window.len(), 0.0);
            reader.read(window, &mut line)?;
            heights.extend(of_row.iter().map(|(_, column)| line[(column - first) as usize]));
        }
        Ok(Samples { places, heights })
    }

    /// The height of a sample, if it has one.
    pub(super) fn height(&self, row: i64, column: i64) -> Option<f64> {
        let found = self.places.binary_search(&(row, column)).ok();
        found.map(|i| self.heights[i]).filter(|height| !height.is_nan())
    }

    /// Whether a cell with four heights holds a segment, of those that count.
    pub(super) fn has_cell(&self, segment: [Spot; 2], counts: impl Fn((i64, i64)) -> bool) -> bool {
        let is_whole = |cell| corners(cell).into_iter().all(|(row, column)| self.height(row, column).is_some());
        cells(segment).any(|cell| is_whole(cell) && counts(cell))
    }
}

/// Where an edge crosses a row or a column, or is on it where it ends.
pub(super) struct Crossing {
    /// Row and column of the sample before it.
    pub(super) sample: (i64, i64),
    /// How far it is from there to the next sample: a fraction.
    pub(super) part: (i64, i64),
    /// Which share of the edge is before it, of the same denominator.
    pub(super) done: i64,
    /// Whether it is on a column.
    pub(super) is_column: bool,
}

/// Visits where an edge crosses columns and rows, strictly between its ends.
pub(super) fn for_each_crossing(a: Spot, b: Spot, mut visit: impl FnMut(Crossing)) {
    for is_column in [true, false] {
        let split = |(x, y): Spot| if is_column { (x, y) } else { (y, x) };
        let ((ax, ay), (bx, by)) = (split(a), split(b));
        let run = (bx - ax).abs();
        for line in (ax.min(bx) >> 2) + 1..(ax.max(bx) + 3) >> 2 {
            let done = (4 * line - ax).abs();
            // In quarter cells, as a fraction over `run`.
            let along = ay * (run - done) + by * done;
            let before = along.div_euclid(4 * run);
            let sample = if is_column { (before, line) } else { (line, before) };
            visit(Crossing { sample, part: (along - 4 * run * before, 4 * run), done: 4 * done, is_column });
        }
    }
}
