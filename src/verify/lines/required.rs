//! What lines ask of a mesh: their segments, and their heights.

use std::collections::BTreeMap;

use num_rational::BigRational;

use super::inside::Inside;
use super::lakes::Shores;
use super::noding::{Counted, noded};
use super::pieces::Piece;
use super::{Spot, places};
use crate::base::features::FeatureSet;
use crate::base::{LineKind, LineSet};
use crate::verify::VerifyError;
use crate::verify::exact::rational;

/// Sets of lines by their numbers, as bits.
pub(super) type SetBits = u16;

/// All lines that a mesh is to have as edges, on the lattice of the raster.
#[derive(Debug)]
pub struct RequiredLines {
    pub(super) sets: Vec<Set>,
    features: FeatureSet,
    /// Each once, with the sets that it is of.
    pub(super) segments: Vec<([Spot; 2], SetBits)>,
    /// Heights of lines' own, by place.
    pub(super) levels: BTreeMap<Spot, f64>,
    /// Samples beside lines with heights, by row and column, with the least and the largest of these heights.
    near: Vec<((i64, i64), [f64; 2])>,
    pub(super) shores: Shores,
    inside: Option<Inside>,
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
        let mut pieces = noded(pieces);
        let shores = shores(&mut pieces, sets).map_err(|error| (LineKind::Lakes, error))?;
        let inside = inside(&mut pieces, sets, size);
        let bits = |of: &[Counted]| of.iter().fold(0, |bits, (piece, _)| bits | 1 << piece.set);
        let of_segments = pieces.chunk_by(|a, b| a.0.ends == b.0.ends);
        let segments = of_segments.map(|of| (of[0].0.ends, bits(of))).collect();
        let levels = levels(pieces.iter().map(|(piece, _)| piece), sets, &shores, tolerance)?;
        let near = near(&levels, size);
        let features = LineSet::features(sets.iter().map(|set| (set.kind, set.lines.have_heights())));
        let sets = sets.iter().map(|set| Set { shift: set.shift, has_heights: set.lines.have_heights() });
        Ok(RequiredLines { sets: sets.collect(), features, segments, levels, near, shores, inside })
    }

    /// What is inside of outlines that the mesh is to end at; `None` where there are none.
    pub(in crate::verify) fn inside(&self) -> Option<&Inside> {
        self.inside.as_ref()
    }

    /// Whether a segment asks for an edge where a cell that holds it is ground.
    pub(super) fn asks(&self, segment: [Spot; 2], cell: (i64, i64)) -> bool {
        self.inside.as_ref().is_none_or(|inside| inside.asks(segment, cell))
    }

    /// What they ask of a run.
    pub(in crate::verify) fn features(&self) -> FeatureSet {
        self.features
    }

    /// Whether lines have heights of their own.
    pub(in crate::verify) fn have_heights(&self) -> bool {
        !self.levels.is_empty()
    }

    /// The samples of some rows that are in lakes: row, columns, height. Some may be there twice.
    pub(in crate::verify) fn flooded(
        &self,
        rows: std::ops::Range<i64>,
    ) -> impl Iterator<Item = (i64, std::ops::Range<i64>, f64)> {
        self.shores.samples(rows)
    }

    /// The samples of some rows that are beside lines with heights: row, column, and the least and the largest of these.
    pub(in crate::verify) fn near(&self, rows: std::ops::Range<i64>) -> &[((i64, i64), [f64; 2])] {
        let before = |row: i64| self.near.partition_point(|((at, _), _)| *at < row);
        &self.near[before(rows.start)..before(rows.end)]
    }
}

/// The lakes of all sets; each feature is one. Takes away what an outline runs over an even number of times: it bounds nothing.
fn shores(pieces: &mut Vec<Counted>, sets: &[LineSet]) -> Result<Shores, VerifyError> {
    let Some(number) = sets.iter().position(|set| set.kind == LineKind::Lakes) else { return Ok(Shores::default()) };
    let lines = &sets[number].lines;
    let mut lakes: Vec<(u64, f64)> = Vec::new();
    let mut of_line = Vec::new();
    for line in 0..lines.lines().len() {
        let level = lines.heights().and_then(|heights| heights[line].first().copied());
        match lakes.last() {
            Some((feature, _)) if *feature == lines.feature(line) => {}
            _ => lakes.push((lines.feature(line), level.unwrap_or(0.0))),
        }
        of_line.push(lakes.len() - 1);
    }
    let mut times: BTreeMap<([Spot; 2], usize), u32> = BTreeMap::new();
    for (piece, more) in pieces.iter().filter(|(piece, _)| piece.set == number) {
        *times.entry((piece.ends, of_line[piece.line])).or_default() += more;
    }
    times.retain(|_, times| *times % 2 == 1);
    pieces.retain(|(piece, _)| piece.set != number || times.contains_key(&(piece.ends, of_line[piece.line])));
    Shores::new(lakes, times.into_keys())
}

/// The inside of the outlines that the mesh is to end at; each feature is a polygon. Takes away what of them is not on its border, and what
/// is on the raster's rim.
fn inside(pieces: &mut Vec<Counted>, sets: &[LineSet], (width, height): (i64, i64)) -> Option<Inside> {
    let number = sets.iter().position(|set| set.kind == LineKind::Cutline)?;
    let features: BTreeMap<u64, usize> = {
        let lines = &sets[number].lines;
        let all: std::collections::BTreeSet<u64> = (0..lines.lines().len()).map(|line| lines.feature(line)).collect();
        all.into_iter().zip(0..).collect()
    };
    let mut times: BTreeMap<([Spot; 2], usize), u32> = BTreeMap::new();
    for (piece, more) in pieces.iter().filter(|(piece, _)| piece.set == number) {
        *times.entry((piece.ends, features[&sets[number].lines.feature(piece.line)])).or_default() += more;
    }
    let odd: Vec<_> = times.into_iter().filter(|(_, times)| times % 2 == 1).map(|(side, _)| side).collect();
    let inside = Inside::new(&odd, (width - 1, height - 1));
    let ends: std::collections::BTreeSet<[Spot; 2]> = odd.into_iter().map(|(ends, _)| ends).collect();
    pieces.retain(|(piece, _)| piece.set != number || ends.contains(&piece.ends) && inside.is_border(piece.ends));
    Some(inside)
}

/// A height at a place, and the line or the lake that has it.
type Owned = (f64, (LineKind, u64));

/// The heights at all places of lines that have some: where there are several, the middle of the least and the largest. All places of
/// any line that are in lakes have theirs.
fn levels<'p>(
    pieces: impl Iterator<Item = &'p Piece>,
    sets: &[LineSet],
    shores: &Shores,
    tolerance: f64,
) -> Result<BTreeMap<Spot, f64>, (LineKind, VerifyError)> {
    // By rows, then by columns, so that it is always the same place that is told of.
    let mut found: BTreeMap<(i64, i64), (Vec<Owned>, Vec<Owned>)> = BTreeMap::new();
    for piece in pieces {
        let set = &sets[piece.set];
        for ((x, y), height) in piece.ends.into_iter().zip(piece.heights()) {
            let flooded: Vec<Owned> =
                shores.at((x, y)).map(|lake| shores.lake(lake)).map(|(f, h)| (h, (LineKind::Lakes, f))).collect();
            let own = set.lines.have_heights();
            if own || !flooded.is_empty() {
                let (lines, lakes) = found.entry((y, x)).or_default();
                lines.extend(own.then(|| (height, (set.kind, set.lines.feature(piece.line)))));
                lakes.extend(flooded);
            }
        }
    }
    let one = |((y, x), (lines, lakes)): ((i64, i64), (Vec<Owned>, Vec<Owned>))| {
        let order = |a: &&Owned, b: &&Owned| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let all = || lines.iter().chain(&lakes);
        let (Some(&(low, of_low)), Some(&(high, of_high))) = (all().min_by(order), all().max_by(order)) else {
            unreachable!("a place with a height");
        };
        let apart: BigRational = rational(high) - rational(low);
        let is_level = lakes.iter().all(|(height, _)| *height == lakes[0].0);
        if apart > rational(tolerance) || !is_level {
            let (column, row) = (x as f64 / 4.0, y as f64 / 4.0);
            let (heights, features, kinds) = ([low, high], [of_low.1, of_high.1], [of_low.0, of_high.0]);
            return Err((kinds[0], VerifyError::TwoHeights { column, row, heights, features, kinds }));
        }
        Ok(((x, y), lakes.first().map_or(low + (high - low) / 2.0, |lake| lake.0)))
    };
    found.into_iter().map(one).collect()
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
