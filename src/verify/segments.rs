//! Stretches of a line that edges follow, added up.

use rayon::prelude::*;

use super::finding::{Finding, MapPlace};
use super::grid::{Grid, STEPS};

/// A side or a diagonal of a cell, seen as a part of the ground's boundary: which of its quarters edges have yet to
/// follow, and on which side of it the ground lies.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Segment(u8);

/// The segments that begin at a sample. Each has a direction in which it is passed through: with growing columns, or, where
/// they are the same, growing rows.
pub(super) type Segments = [Segment; 4];

/// To the sample to the right.
pub(super) const ALONG_ROW: usize = 0;
/// To the sample below.
pub(super) const ALONG_COLUMN: usize = 1;
/// To the sample to the right and below.
pub(super) const FALLING: usize = 2;
/// From the sample below to that to the right.
pub(super) const RISING: usize = 3;

impl Segment {
    const QUARTERS: u8 = 0x0f;
    const FORWARD: u8 = 0x10;
    const BACKWARD: u8 = 0x20;
    const DOUBLED: u8 = 0x40;

    /// A segment with ground to either side: to the positive one (where the rows lie for somebody who walks along the
    /// columns: in (column, row) that is a positive turn), or to the other.
    pub(super) fn beside(positive: bool, negative: bool) -> Segment {
        match (positive, negative) {
            (true, false) => Segment(Segment::QUARTERS | Segment::FORWARD),
            (false, true) => Segment(Segment::QUARTERS | Segment::BACKWARD),
            _ => Segment(0),
        }
    }

    /// Lays an edge along some quarters, with its face on the side that its direction tells. False where the ground does not
    /// end, or not on that side.
    fn lay(&mut self, quarters: u8, forward: bool) -> bool {
        let side = if forward { Segment::FORWARD } else { Segment::BACKWARD };
        if self.0 & side == 0 {
            return false;
        }
        if self.0 & quarters != quarters {
            self.0 |= Segment::DOUBLED;
        }
        self.0 &= !quarters;
        true
    }

    /// Whether some of it has not been followed.
    fn is_open(self) -> bool {
        self.0 & Segment::QUARTERS != 0
    }

    /// Whether some of it has been followed more than once.
    fn is_doubled(self) -> bool {
        self.0 & Segment::DOUBLED != 0
    }
}

/// How the edges of one face follow the ground's boundary.
#[derive(Debug, Default)]
pub(super) struct BoundaryFindings {
    pub(super) gaps: Finding<MapPlace>,
    pub(super) doubled: Finding<MapPlace>,
}

/// The segments of some rows.
pub(super) struct SegmentRows<'g> {
    pub(super) grid: Grid,
    /// The first row.
    pub(super) first: i64,
    /// How many.
    pub(super) rows: i64,
    pub(super) segments: &'g mut [Segments],
}

/// A way along segments of one kind, in lattice steps from where it begins in the segments' own direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Track {
    kind: usize,
    begin: (i64, i64),
    steps: i64,
    /// Whether it runs in the segments' own direction.
    forward: bool,
}

impl Track {
    /// From one lattice point to another with coordinates from 0 on; `None` where that is not along sides or diagonals of
    /// cells.
    pub(super) fn new(from: (i64, i64), to: (i64, i64)) -> Option<Track> {
        let (run, rise) = (to.0 - from.0, to.1 - from.1);
        let on_line = |offset: i64| offset.rem_euclid(STEPS) == 0;
        let kind = match (run, rise) {
            (0, 0) => return None,
            (_, 0) if on_line(from.1) => ALONG_ROW,
            (0, _) if on_line(from.0) => ALONG_COLUMN,
            _ if run == rise && on_line(from.0 - from.1) => FALLING,
            _ if run == -rise && on_line(from.0 + from.1) => RISING,
            _ => return None,
        };
        let forward = (run, rise) > (0, 0);
        let begin = if forward { from } else { to };
        Some(Track { kind, begin, steps: run.abs().max(rise.abs()), forward })
    }

    /// The first and the last row at which its segments begin.
    pub(super) fn rows(&self) -> (i64, i64) {
        let (y, end) = (self.begin.1, self.steps - 1);
        match self.kind {
            ALONG_ROW => (y / STEPS, y / STEPS),
            RISING => ((y - 1 - end) / STEPS, (y - 1) / STEPS),
            _ => (y / STEPS, (y + end) / STEPS),
        }
    }

    /// The steps, first and first after, in segments of rows from `first` to before `after`.
    fn within(&self, first: i64, after: i64) -> (i64, i64) {
        let y = self.begin.1;
        let (from, to) = match self.kind {
            ALONG_ROW if (first..after).contains(&(y / STEPS)) => (0, self.steps),
            ALONG_ROW => (0, 0),
            RISING => (y - STEPS * after, y - STEPS * first),
            _ => (STEPS * first - y, STEPS * after - y),
        };
        (from.max(0), to.min(self.steps))
    }

    /// The sample at which the segment with a step begins, and which quarter of it the step is.
    fn segment(&self, step: i64) -> ((i64, i64), i64) {
        let (x, y) = self.begin;
        let ((x, y), along) = match self.kind {
            ALONG_ROW => ((x + step, y), x + step),
            ALONG_COLUMN => ((x, y + step), y + step),
            FALLING => ((x + step, y + step), x + step),
            _ => ((x + step, y - step - 1), x + step),
        };
        ((x / STEPS, y / STEPS), along % STEPS)
    }
}

/// Samples of a row that are passed over together where no segment begins at them.
const PIECE: usize = 64;

/// Whether no segment begins at any of these samples.
fn is_blank(samples: &[Segments]) -> bool {
    samples.as_flattened().iter().fold(0, |all, segment| all | segment.0) == 0
}

/// Segments of a row: how many, and the first one's column and kind.
#[derive(Debug, Clone, Copy, Default)]
struct Laid {
    count: u64,
    first: Option<(usize, usize)>,
}

impl Laid {
    /// Also those of a sample, by kinds.
    fn and(self, column: usize, kinds: [bool; 4]) -> Laid {
        let first = self.first.or_else(|| kinds.iter().position(|is| *is).map(|kind| (column, kind)));
        Laid { count: self.count + kinds.iter().filter(|is| **is).count() as u64, first }
    }
}

impl SegmentRows<'_> {
    /// Lays a track along its segments in these rows. True where the ground's boundary does not run along all of it.
    pub(super) fn lay(&mut self, track: &Track) -> bool {
        let (mut step, after) = track.within(self.first, self.first + self.rows);
        let mut astray = false;
        while step < after {
            let ((column, row), quarter) = track.segment(step);
            let steps = (STEPS - quarter).min(after - step);
            let quarters = ((1u8 << steps) - 1) << quarter;
            let index = ((row - self.first) * self.grid.width + column) as usize;
            astray |= !self.segments[index][track.kind].lay(quarters, track.forward);
            step += steps;
        }
        astray
    }

    /// Finds the segments of the boundary that no edge has followed, and those that several have.
    pub(super) fn tell(&self, found: &mut BoundaryFindings) {
        let width = self.grid.width as usize;
        let rows = self.segments.par_chunks(width).map(|row| {
            // Most rows have nothing but the first and the last segment, most pieces nothing.
            let pieces = row.chunks(PIECE).enumerate().filter(|(_, piece)| !is_blank(piece));
            let all = pieces.flat_map(|(at, piece)| (at * PIECE..).zip(piece));
            all.fold([Laid::default(); 2], |found, (column, segments)| {
                let open = segments.map(Segment::is_open);
                let doubled = segments.map(Segment::is_doubled);
                [found[0].and(column, open), found[1].and(column, doubled)]
            })
        });
        for (row, [gaps, doubled]) in rows.collect::<Vec<_>>().into_iter().enumerate() {
            let place = |laid: Laid| laid.first.map(|(column, kind)| self.place(row * width + column, kind));
            found.gaps.add_all(gaps.count, || place(gaps).expect("there is one"));
            found.doubled.add_all(doubled.count, || place(doubled).expect("there is one"));
        }
    }

    /// Where a segment begins.
    fn place(&self, index: usize, kind: usize) -> MapPlace {
        let (row, column) = (self.first + index as i64 / self.grid.width, index as i64 % self.grid.width);
        self.grid.map((STEPS * column, STEPS * (row + i64::from(kind == RISING))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_run_along_sides_and_diagonals_alone() {
        let track = |from, to| Track::new(from, to).map(|t| (t.kind, t.begin, t.steps, t.forward, t.rows()));
        assert_eq!(track((3, 4), (9, 4)), Some((ALONG_ROW, (3, 4), 6, true, (1, 1))));
        assert_eq!(track((8, 12), (8, 3)), Some((ALONG_COLUMN, (8, 3), 9, false, (0, 2))));
        assert_eq!(track((5, 1), (9, 5)), Some((FALLING, (5, 1), 4, true, (0, 1))));
        assert_eq!(track((9, 3), (4, 8)), Some((RISING, (4, 8), 5, false, (0, 1))));
        for (from, to) in
            [((3, 5), (9, 5)), ((3, 1), (3, 9)), ((0, 0), (8, 4)), ((1, 0), (5, 4)), ((1, 4), (5, 0)), ((4, 4), (4, 4))]
        {
            assert_eq!(track(from, to), None, "{from:?} {to:?}");
        }
    }

    #[test]
    fn steps_are_quarters_of_segments_whichever_rows_are_looked_at() {
        let t = |from, to| Track::new(from, to).expect("a track");
        for track in [t((3, 8), (18, 8)), t((8, 3), (8, 17)), t((2, 6), (13, 17)), t((2, 18), (13, 7))] {
            let all: Vec<_> = (0..track.steps).map(|s| track.segment(s)).collect();
            let (first, last) = track.rows();
            let mut seen = Vec::new();
            for row in first..=last {
                let (from, after) = track.within(row, row + 1);
                assert!(from < after && all[from as usize..after as usize].iter().all(|((_, r), _)| *r == row));
                seen.extend(from..after);
            }
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..track.steps));
            let (from, after) = track.within(last + 1, last + 9);
            assert!(from >= after);
        }
    }
}
