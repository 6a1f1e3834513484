//! Lakes: what lies inside of their outlines on the lattice.
//!
//! Between two neighbouring rows of lattice places no segment begins, ends or crosses another. So there a lake is a row of trapezoids,
//! from an odd segment of its outline to the next one. A segment is odd if the outline runs over it an odd number of times.

use super::{LinesError, Place, Segment};
use crate::base::lattice::STEPS;

const CELL: i64 = STEPS as i64;

/// A multiple of the extents that a segment may have, by which places in the middle of rows and on them are whole numbers.
pub(super) const PARTS: i64 = 24;

/// A part of a lake between two rows of lattice places.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Trapezoid {
    /// The upper row.
    row: i64,
    left: Segment,
    right: Segment,
    lake: u32,
}

/// All lakes of a raster.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Lakes {
    /// By rows, then from the left to the right.
    trapezoids: Vec<Trapezoid>,
    /// Samples of the closed lakes, by rows, then by first columns.
    runs: Vec<Run>,
    /// The number of its feature, and its height.
    lakes: Vec<(u64, f64)>,
}

/// Samples of a row in a lake.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Run {
    row: u32,
    pub(super) first: u32,
    pub(super) last: u32,
    pub(super) height: f64,
}

/// Where a segment is at a row, or in the middle to the next (`half` is 1), in parts of a step.
pub(super) fn across([a, b]: Segment, row: i64, half: i64) -> i64 {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    PARTS * a.x + dx * (2 * (row - a.y) + half) * (PARTS / 2 / dy)
}

/// The segments that are odd, of lakes by number, in order. A lake has no shore elsewhere.
pub(super) fn odd(outlines: impl Iterator<Item = (Segment, u32, u32)>) -> Vec<(Segment, u32)> {
    let mut sides: Vec<(Segment, u32, u32)> = outlines.collect();
    sides.sort_unstable();
    let groups = sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
    let is_odd = |group: &&[(Segment, u32, u32)]| group.iter().map(|(_, _, times)| times).sum::<u32>() % 2 == 1;
    groups.filter(is_odd).map(|group| (group[0].0, group[0].1)).collect()
}

impl Lakes {
    /// Lakes by feature and height, and the segments of their outlines: each with the number of its lake and how often it is run over.
    ///
    /// # Errors
    /// [`LinesError::Overlap`].
    pub(super) fn new(
        lakes: Vec<(u64, f64)>,
        outlines: impl Iterator<Item = (Segment, u32, u32)>,
    ) -> Result<Lakes, LinesError> {
        let mut crossings: Vec<(i64, i64, u32, Segment)> = Vec::new();
        for (segment, lake) in odd(outlines) {
            let rows = segment[0].y..segment[1].y;
            crossings.extend(rows.map(|row| (row, across(segment, row, 1), lake, segment)));
        }
        crossings.sort_unstable();
        let mut found = Lakes { lakes, ..Lakes::default() };
        let mut open: Vec<(u32, Segment)> = Vec::new();
        for group in crossings.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            for &(row, _, lake, right) in group {
                match open.iter().position(|(of, _)| *of == lake) {
                    Some(i) => {
                        let (_, left) = open.swap_remove(i);
                        found.trapezoids.push(Trapezoid { row, left, right, lake });
                    }
                    None => open.push((lake, right)),
                }
            }
            if let [(a, _), (b, _), ..] = open[..] {
                let features = [a.min(b), a.max(b)].map(|lake| found.lakes[lake as usize].0);
                return Err(LinesError::Overlap { features });
            }
        }
        found.trapezoids.sort_unstable_by_key(|t| (t.row, across(t.left, t.row, 1)));
        found.find_runs();
        Ok(found)
    }

    fn find_runs(&mut self) {
        let cell = PARTS * CELL;
        let on = |t: &Trapezoid, line: i64| {
            let (left, right) = (across(t.left, line, 0), across(t.right, line, 0));
            let (first, last) = ((left + cell - 1).div_euclid(cell), right.div_euclid(cell));
            let height = self.lakes[t.lake as usize].1;
            (first <= last).then_some(Run { row: (line / CELL) as u32, first: first as u32, last: last as u32, height })
        };
        let lines = |t: &Trapezoid| [t.row, t.row + 1].into_iter().filter(|line| line % CELL == 0);
        let runs = self.trapezoids.iter().flat_map(|t| lines(t).filter_map(|line| on(t, line)));
        let mut runs: Vec<Run> = runs.collect();
        runs.sort_unstable_by_key(|run| (run.row, run.first, run.last));
        // Those above and below a row overlap; where they are of lakes that touch, these have one height.
        runs.dedup_by(|next, run| {
            let joins = next.row == run.row && next.first <= run.last && next.height == run.height;
            if joins {
                run.last = run.last.max(next.last);
            }
            joins
        });
        self.runs = runs;
    }

    pub(super) fn is_empty(&self) -> bool {
        self.lakes.is_empty()
    }

    /// How many samples are inside.
    pub(super) fn samples(&self) -> u64 {
        self.runs.iter().map(|run| u64::from(run.last - run.first + 1)).sum()
    }

    /// The lakes that a place is in or on: their features and heights.
    pub(super) fn at(&self, place: Place) -> impl Iterator<Item = (u64, f64)> {
        let x = PARTS * place.x;
        [place.y - 1, place.y].into_iter().flat_map(move |row| {
            let of_row = &self.trapezoids[self.trapezoids.partition_point(|t| t.row < row)..];
            let of_row = &of_row[..of_row.partition_point(|t| t.row == row)];
            let begun = &of_row[..of_row.partition_point(|t| across(t.left, place.y, 0) <= x)];
            let there = begun.iter().rev().take_while(move |t| across(t.right, place.y, 0) >= x);
            there.map(|t| self.lakes[t.lake as usize])
        })
    }

    /// The runs of samples in a row, as far as they reach into a range of columns.
    pub(super) fn runs(&self, row: u32, columns: std::ops::Range<u32>) -> impl Iterator<Item = Run> {
        let from = self.runs.partition_point(|run| run.row < row);
        let of_row = self.runs[from..].iter().take_while(move |run| run.row == row);
        let reach = of_row.filter(move |run| run.first < columns.end && run.last >= columns.start);
        reach.copied()
    }

    pub(super) fn bytes(&self) -> u64 {
        (size_of_val(self.trapezoids.as_slice()) + size_of_val(self.runs.as_slice())) as u64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(places: &[(i64, i64)]) -> Vec<Segment> {
        let place = |&(x, y): &(i64, i64)| Place { y, x };
        let next = places.iter().cycle().skip(1);
        places.iter().zip(next).map(|(p, q)| [place(p).min(place(q)), place(p).max(place(q))]).collect()
    }

    fn lakes(rings: &[(u32, Vec<Segment>)]) -> Result<Lakes, LinesError> {
        let count = rings.iter().map(|(lake, _)| lake + 1).max().unwrap_or(0);
        let of = rings.iter().flat_map(|(lake, ring)| ring.iter().map(|segment| (*segment, *lake, 1)));
        Lakes::new((0..count).map(|lake| (u64::from(lake) + 70, f64::from(lake))).collect(), of)
    }

    #[test]
    fn samples_of_the_closed_lake_are_inside_and_those_of_islands_are_not() {
        let lake = ring(&[
            (0, 0),
            (4, 0),
            (8, 0),
            (12, 0),
            (12, 4),
            (12, 8),
            (12, 12),
            (8, 12),
            (4, 12),
            (0, 12),
            (0, 8),
            (0, 4),
        ]);
        let island = ring(&[(5, 5), (7, 5), (7, 7), (5, 7)]);
        let found = lakes(&[(0, lake.clone()), (0, island)]).unwrap();
        let runs: Vec<_> = found.runs.iter().map(|run| (run.row, run.first, run.last)).collect();
        assert_eq!(runs, [(0, 0, 3), (1, 0, 3), (2, 0, 3), (3, 0, 3)]);
        assert_eq!(found.samples(), 16);
        let is_in = |x, y| found.at(Place { y, x }).count() > 0;
        assert!(is_in(0, 0) && is_in(12, 12) && is_in(5, 6) && is_in(1, 1) && !is_in(6, 6) && !is_in(13, 5));
        // What is run over twice bounds nothing.
        let twice = lakes(&[(0, lake.clone()), (0, lake.clone())]).unwrap();
        assert_eq!((twice.samples(), twice.trapezoids.len()), (0, 0));
        assert_eq!(lakes(&[(0, lake.clone()), (1, lake)]), Err(LinesError::Overlap { features: [70, 71] }));
    }

    #[test]
    fn lakes_may_touch_but_not_overlap() {
        let left = ring(&[(0, 0), (4, 0), (4, 4), (0, 4)]);
        let right = ring(&[(4, 0), (8, 0), (8, 4), (4, 4)]);
        let found = lakes(&[(0, left.clone()), (1, right.clone())]).unwrap();
        let of =
            |x, y| found.at(Place { y, x }).map(|(feature, _)| feature).collect::<std::collections::BTreeSet<u64>>();
        assert_eq!(of(4, 2).into_iter().collect::<Vec<_>>(), [70, 71]);
        assert_eq!((of(3, 2).len(), of(9, 2).len()), (1, 0));
        let inner = ring(&[(1, 1), (3, 1), (3, 3), (1, 3)]);
        assert_eq!(lakes(&[(0, left), (1, right), (2, inner)]), Err(LinesError::Overlap { features: [70, 72] }));
    }
}
