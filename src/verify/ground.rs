//! The ground, found from the samples that have a height: every cell with four of them, and the triangle of the three in
//! every cell with three (a half cell).

use rayon::prelude::*;

use super::finding::{Finding, SamplePlace};
use super::grid::{Grid, STEPS};
use super::row::mark;
use super::samples::{Samples, flag};
use super::segments::{ALONG_COLUMN, ALONG_ROW, FALLING, RISING, Segment, SegmentRows, Segments};

/// What is known of a sample, bit by bit.
pub(super) mod state {
    /// It has a height or is bridged.
    pub(in super::super) const VALID: u8 = 1;
    /// It lies in a closed triangle.
    pub(in super::super) const COVERED: u8 = 2;
    /// It is bridged.
    pub(in super::super) const BRIDGED: u8 = 4;
    /// It may be bare.
    pub(in super::super) const STRIP: u8 = 8;
    /// The mesh is to end at outlines.
    pub(in super::super) const CUT: u8 = 16;
    /// It is outside of them.
    pub(in super::super) const OUTSIDE: u8 = 32;
}
use state::{BRIDGED, COVERED, CUT, OUTSIDE, STRIP, VALID};

/// What the ground comes to, and where it is bare.
#[derive(Debug, Default)]
pub(super) struct GroundFindings {
    /// Samples of the ground that have a height, less those that are trimmed.
    pub(super) checked: u64,
    /// Samples without a height that are not bridged.
    pub(super) nodata: u64,
    /// Those that are.
    pub(super) bridged: u64,
    /// Samples of the ground with a height that may be bare and are.
    pub(super) trimmed: u64,
    /// Samples with a height in no cell of the ground.
    pub(super) without_ground: Finding<SamplePlace>,
    /// Samples of the ground in no triangle.
    pub(super) uncovered: Finding<SamplePlace>,
    /// Twice the area of the ground, in lattice steps squared.
    pub(super) double_area: i128,
}

/// Takes rows of samples band by band, and settles each row once the next is known: what of it is ground, what is bare,
/// and along which segments the ground ends there.
///
/// Memory use is constant: five bytes for each sample of a band and of two rows more.
#[derive(Debug)]
pub(super) struct Ground {
    grid: Grid,
    /// Of the samples held: the row above the first unsettled one, and all rows from that on. Above the raster's first
    /// row and below its last there are rows without heights.
    states: Vec<u8>,
    segments: Vec<Segments>,
    /// The first row that was not settled before the latest call.
    row: i64,
    /// The rows that the latest call settled.
    settled: usize,
    /// Whether the mesh is to end at outlines.
    is_cut: bool,
    pub(super) found: GroundFindings,
}

impl Ground {
    pub(super) fn new(grid: Grid, is_cut: bool) -> Ground {
        let states = vec![0; grid.width as usize];
        Ground { grid, states, segments: Vec::new(), row: 0, settled: 0, is_cut, found: GroundFindings::default() }
    }

    /// Takes the next rows, and their marks ([`mark::COVERED`]). Gives the rows that are settled by that.
    pub(super) fn settle(&mut self, samples: Samples<'_>, marks: &[u8]) -> Settled<'_> {
        let heights = samples.heights;
        let width = self.grid.width as usize;
        let cut = if self.is_cut { CUT } else { 0 };
        // Of the row above the first unsettled one only the heights are asked for.
        self.states.drain(..self.settled * width);
        self.row += self.settled as i64;
        let held = self.states.len();
        // Room for the row below the last one; growing by doubling would take twice as much.
        self.states.reserve_exact(heights.len() + width);
        self.states.resize(held + heights.len(), 0);
        let states =
            self.states[held..].par_chunks_mut(width).zip(heights.par_chunks(width)).zip(marks.par_chunks(width));
        states.enumerate().for_each(|(row, ((states, heights), marks))| {
            for ((state, height), mark) in states.iter_mut().zip(heights).zip(marks) {
                *state = if height.is_nan() { 0 } else { VALID } | if mark & mark::COVERED != 0 { COVERED } else { 0 };
            }
            let Some(flags) = samples.flags else { return };
            for (state, flags) in states.iter_mut().zip(&flags[row * width..]) {
                if flags & flag::BRIDGED != 0 && *state & VALID == 0 {
                    *state |= VALID | BRIDGED;
                }
                if flags & flag::NEAR != 0 {
                    *state |= STRIP;
                }
                if flags & flag::OUTSIDE != 0 {
                    *state |= OUTSIDE;
                }
                *state |= cut;
            }
        });
        let last = self.row + (self.states.len() / width) as i64 - 1 == self.grid.height;
        if last {
            self.states.extend(std::iter::repeat_n(0, width));
        }
        let rows = (self.states.len() / width).saturating_sub(2);
        self.segments.reserve_exact((rows * width).saturating_sub(self.segments.len()));
        self.segments.resize(rows * width, Segments::default());
        // All are looked at, as vectors.
        let is_full =
            |row: &[u8]| row.iter().fold(true, |full, s| full & (s & (VALID | BRIDGED | STRIP | OUTSIDE) == VALID));
        let full: Vec<bool> = self.states.par_chunks(width).map(is_full).collect();
        let states = &self.states;
        let line = |row: usize| &states[row * width..(row + 1) * width];
        let settled: Vec<Row> = self
            .segments
            .par_chunks_mut(width)
            .enumerate()
            .map(|(i, segments)| {
                segments.fill(Segments::default());
                match full[i] && full[i + 1] && full[i + 2] {
                    true => full_row(line(i + 1), segments),
                    false => any_row([line(i), line(i + 1), line(i + 2)], segments),
                }
            })
            .collect();
        for (row, found) in (self.row..).zip(settled) {
            self.found.add(&self.grid, row, &found);
        }
        self.settled = rows;
        let first = self.row;
        let segments = SegmentRows { grid: self.grid, first, rows: rows as i64, segments: &mut self.segments };
        Settled { first, states: &self.states[width..], segments }
    }
}

/// Rows whose ground is known.
pub(super) struct Settled<'g> {
    /// The first of them.
    pub(super) first: i64,
    /// The states of their samples, and of those of the row below them.
    pub(super) states: &'g [u8],
    /// Where the ground ends, for edges to be laid along.
    pub(super) segments: SegmentRows<'g>,
}

/// What one row, and the cells below it, add to the findings: columns of samples.
#[derive(Debug, Default)]
struct Row {
    checked: u64,
    nodata: u64,
    bridged: u64,
    trimmed: u64,
    without_ground: Columns,
    uncovered: Columns,
    double_area: i64,
}

#[derive(Debug, Default)]
struct Columns {
    count: u64,
    first: i64,
}

impl Columns {
    fn add(&mut self, column: usize) {
        if self.count == 0 {
            self.first = column as i64;
        }
        self.count += 1;
    }
}

impl GroundFindings {
    fn add(&mut self, grid: &Grid, row: i64, found: &Row) {
        self.checked += found.checked;
        self.nodata += found.nodata;
        self.bridged += found.bridged;
        self.trimmed += found.trimmed;
        self.double_area += i128::from(found.double_area);
        let place = |columns: &Columns| grid.sample(columns.first, row);
        self.without_ground.add_all(found.without_ground.count, || place(&found.without_ground));
        self.uncovered.add_all(found.uncovered.count, || place(&found.uncovered));
    }
}

/// Twice the area of a half cell.
const HALF: i64 = STEPS * STEPS;

/// A row in the midst of rows that have heights everywhere: the ground ends at the raster's first and last column alone.
fn full_row(here: &[u8], segments: &mut [Segments]) -> Row {
    let last = here.len() - 1;
    segments[0][ALONG_COLUMN] = Segment::beside(false, true);
    segments[last][ALONG_COLUMN] = Segment::beside(true, false);
    let mut row = Row { checked: here.len() as u64, double_area: 2 * HALF * last as i64, ..Row::default() };
    if here.iter().fold(COVERED, |all, s| all & s) == 0 {
        here.iter().enumerate().filter(|(_, s)| **s & COVERED == 0).for_each(|(column, _)| row.uncovered.add(column));
    }
    row
}

/// A row between two others: the segments that begin at its samples, to the right and below.
fn any_row([above, here, below]: [&[u8]; 3], segments: &mut [Segments]) -> Row {
    let mut row = Row::default();
    let width = here.len();
    let count = |upper: &[u8], lower: &[u8], column: usize| {
        let [a, b, c, d] = [upper[column], upper[column + 1], lower[column], lower[column + 1]].map(|s| s & VALID);
        a + b + c + d
    };
    // Heights of the cells around a sample: to the left above and below, to the right above and below.
    let (mut left_above, mut left_below) = (0, 0);
    for column in 0..width {
        let (right_above, right_below) = match column + 1 < width {
            true => (count(above, here, column), count(here, below, column)),
            false => (0, 0),
        };
        let valid = |s: u8| s & VALID != 0;
        let ground = [left_above, left_below, right_above, right_below].iter().any(|&heights| heights >= 3);
        match (valid(here[column]), ground) {
            (false, _) => row.nodata += 1,
            (true, _) if here[column] & OUTSIDE != 0 => row.nodata += 1,
            // What the mesh is to cover, and does, is seen between samples: it may be nothing of the cells around this one.
            (true, _) if here[column] & (CUT | COVERED) == CUT => row.without_ground.add(column),
            (true, _) if here[column] & CUT != 0 => row.checked += 1,
            (true, false) => row.without_ground.add(column),
            (true, true) => {
                let state = here[column];
                let count = match (state & BRIDGED != 0, state & (STRIP | COVERED)) {
                    (true, _) => &mut row.bridged,
                    (false, STRIP) => &mut row.trimmed,
                    (false, _) => &mut row.checked,
                };
                *count += 1;
                if state & (STRIP | COVERED) == 0 {
                    row.uncovered.add(column);
                }
            }
        }
        let segments = &mut segments[column];
        // A cell with three heights or more has ground along each side between two of them.
        if valid(here[column]) && valid(below[column]) {
            segments[ALONG_COLUMN] = Segment::beside(left_below >= 3, right_below >= 3);
        }
        if column + 1 < width && valid(here[column]) && valid(here[column + 1]) {
            segments[ALONG_ROW] = Segment::beside(right_below >= 3, right_above >= 3);
        }
        match right_below {
            4 => row.double_area += 2 * HALF,
            3 => {
                row.double_area += HALF;
                let missing = |s: u8| !valid(s);
                if missing(here[column]) || missing(below[column + 1]) {
                    segments[RISING] = Segment::beside(missing(here[column]), missing(below[column + 1]));
                } else {
                    segments[FALLING] = Segment::beside(missing(here[column + 1]), missing(below[column]));
                }
            }
            _ => {}
        }
        (left_above, left_below) = (right_above, right_below);
    }
    row
}
