//! What lines ask of a mesh: their segments, and their heights.

use std::collections::BTreeMap;

use num_rational::BigRational;

use super::noding::noded;
use super::pieces::Piece;
use super::{Spot, places};
use crate::base::{LineKind, LineSet};
use crate::verify::VerifyError;
use crate::verify::exact::rational;

/// All lines that a mesh is to have as edges, on the lattice of the raster.
#[derive(Debug)]
pub struct RequiredLines {
    pub(super) sets: Vec<Set>,
    /// Each once, with the sets that it is of.
    pub(super) segments: Vec<([Spot; 2], Vec<usize>)>,
    /// Heights of lines' own, by place.
    pub(super) levels: BTreeMap<Spot, f64>,
    /// Samples beside lines with heights, by row and column, with the least and the largest of these heights.
    near: Vec<((i64, i64), [f64; 2])>,
}

/// What edges along the lines of a set are held to.
#[derive(Debug)]
pub(super) struct Set {
    /// In cells.
    pub(super) shift: f64,
    pub(super) has_heights: bool,
}

impl RequiredLines {
    /// Lines over a raster of this many samples, at the tolerance that the mesh is judged by: lines that meet have one height there, within it.
    ///
    /// # Errors
    /// The kind of the lines, and [`VerifyError`]: they are too far away or too many, or have two heights at a place.
    pub fn new(
        sets: &[LineSet],
        (width, height): (usize, usize),
        tolerance: f64,
    ) -> Result<RequiredLines, (LineKind, VerifyError)> {
        let size = (width as i64, height as i64);
        let mut pieces = Vec::new();
        for (number, set) in sets.iter().enumerate() {
            places::cut((number, set), size, &mut pieces).map_err(|error| (set.kind, error))?;
        }
        let pieces = noded(pieces);
        let mut of: BTreeMap<[Spot; 2], Vec<usize>> = BTreeMap::new();
        for piece in &pieces {
            let numbers = of.entry(piece.ends).or_default();
            if !numbers.contains(&piece.set) {
                numbers.push(piece.set);
            }
        }
        let levels = levels(&pieces, sets, tolerance)?;
        let near = near(&levels, size);
        let sets = sets.iter().map(|set| Set { shift: set.shift, has_heights: set.lines.heights().is_some() });
        Ok(RequiredLines { sets: sets.collect(), segments: of.into_iter().collect(), levels, near })
    }

    /// Whether lines have heights of their own.
    pub(in crate::verify) fn have_heights(&self) -> bool {
        !self.levels.is_empty()
    }

    /// The samples of some rows that are beside lines with heights: row, column, and the least and the largest of these.
    pub(in crate::verify) fn near(&self, rows: std::ops::Range<i64>) -> &[((i64, i64), [f64; 2])] {
        let before = |row: i64| self.near.partition_point(|((at, _), _)| *at < row);
        &self.near[before(rows.start)..before(rows.end)]
    }
}

/// The heights at all places of lines that have some: where there are several, the middle of the least and the largest.
fn levels(pieces: &[Piece], sets: &[LineSet], tolerance: f64) -> Result<BTreeMap<Spot, f64>, (LineKind, VerifyError)> {
    // By rows, then by columns, so that it is always the same place that is told of.
    let mut ranges: BTreeMap<(i64, i64), [(f64, &Piece); 2]> = BTreeMap::new();
    for piece in pieces.iter().filter(|piece| sets[piece.set].lines.heights().is_some()) {
        for ((x, y), height) in piece.ends.into_iter().zip(piece.heights()) {
            let [low, high] = ranges.entry((y, x)).or_insert([(height, piece); 2]);
            if height < low.0 {
                *low = (height, piece);
            }
            if height > high.0 {
                *high = (height, piece);
            }
        }
    }
    let middle = |((y, x), [(low, of_low), (high, of_high)]): ((i64, i64), [(f64, &Piece); 2])| {
        let apart: BigRational = rational(high) - rational(low);
        if apart > rational(tolerance) {
            let (column, row) = (x as f64 / 4.0, y as f64 / 4.0);
            let feature = |piece: &Piece| sets[piece.set].lines.feature(piece.line);
            let (heights, features) = ([low, high], [feature(of_low), feature(of_high)]);
            let kinds = [sets[of_low.set].kind, sets[of_high.set].kind];
            return Err((kinds[0], VerifyError::TwoHeights { column, row, heights, features, kinds }));
        }
        Ok(((x, y), low + (high - low) / 2.0))
    };
    ranges.into_iter().map(middle).collect()
}

/// The samples with a place no farther than a cell away, across or down.
fn near(levels: &BTreeMap<Spot, f64>, (width, height): (i64, i64)) -> Vec<((i64, i64), [f64; 2])> {
    let around = |quarters: i64, count: i64| {
        let first = (quarters - 4).div_euclid(4);
        (first..=first + 2).filter(move |at| (4 * at - quarters).abs() <= 4 && (0..count).contains(at))
    };
    let mut samples: BTreeMap<(i64, i64), [f64; 2]> = BTreeMap::new();
    for (&(x, y), &level) in levels {
        for row in around(y, height) {
            for column in around(x, width) {
                let [low, high] = samples.entry((row, column)).or_insert([level; 2]);
                (*low, *high) = (low.min(level), high.max(level));
            }
        }
    }
    samples.into_iter().collect()
}
