//! Heights of lines' own, row by row: at their places, and beside samples.

use std::collections::BTreeMap;

use num_rational::BigRational;

use super::Spot;
use super::lakes::Shores;
use super::pieces::Counted;
use super::rowed::Rowed;
use super::words::{ROW_OF_PLACE, ROW_OF_SAMPLE, word};
use crate::base::external::{Scratch, ScratchError};
use crate::base::{LineKind, LineSet};
use crate::verify::VerifyError;
use crate::verify::exact::rational;

/// A height at a place, and the line or the lake that has it.
type Owned = (f64, (LineKind, u64));

/// The heights that lines have at a place, and lakes.
type Both = (Vec<Owned>, Vec<Owned>);

/// The heights at all places of lines that have some: where there are several, the middle of the least and the largest. All places of
/// any line that are in lakes have theirs.
///
/// Memory while they are found: what two rows of cells have.
pub(super) struct Levels<'a> {
    sets: &'a [LineSet],
    shores: &'a Shores,
    /// Whether any line has heights, or any place may be in a lake.
    are_some: bool,
    tolerance: BigRational,
    /// Samples across and down.
    size: (i64, i64),
    /// By rows, then by columns, so that it is always the same place that is told of.
    found: BTreeMap<(i64, i64), Both>,
    /// Samples by row and column, with the least and the largest height of a line beside them.
    beside: BTreeMap<(i64, i64), [f64; 2]>,
    /// Places and heights.
    places: Rowed<2>,
    /// Samples, with the least and the largest height.
    samples: Rowed<3>,
}

impl<'a> Levels<'a> {
    pub(super) fn new(
        (sets, shores): (&'a [LineSet], &'a Shores),
        tolerance: f64,
        size: (i64, i64),
        scratch: &Scratch,
    ) -> Levels<'a> {
        let (places, samples) = (Rowed::new(scratch, ROW_OF_PLACE), Rowed::new(scratch, ROW_OF_SAMPLE));
        let (found, beside) = (BTreeMap::new(), BTreeMap::new());
        let are_some = shores.len() > 0 || sets.iter().any(|set| set.lines.have_heights());
        Levels { sets, shores, are_some, tolerance: rational(tolerance), size, found, beside, places, samples }
    }

    /// Takes the pieces of the next row of cells.
    ///
    /// # Errors
    /// The kind of the line that has the least height, where heights at a place are not within the tolerance of each other.
    pub(super) fn take(&mut self, row: i64, pieces: &[Counted]) -> Result<(), (LineKind, VerifyError)> {
        if !self.are_some {
            return Ok(());
        }
        for (piece, _) in pieces {
            let set = &self.sets[piece.set];
            for ((x, y), height) in piece.ends.into_iter().zip(piece.heights()) {
                let lakes = self.shores.at((x, y)).map(|lake| self.shores.lake(lake));
                let flooded: Vec<Owned> = lakes.map(|(f, h)| (h, (LineKind::Lakes, f))).collect();
                let own = set.lines.have_heights();
                if own || !flooded.is_empty() {
                    let (lines, lakes) = self.found.entry((y, x)).or_default();
                    lines.extend(own.then(|| (height, (set.kind, set.lines.feature(piece.line)))));
                    lakes.extend(flooded);
                }
            }
        }
        // Places on the line to the next row wait for what that has.
        let next = self.found.split_off(&(4 * row + 4, i64::MIN));
        for ((y, x), both) in std::mem::replace(&mut self.found, next) {
            let level = self.level((x, y), &both)?;
            self.put((x, y), level).map_err(|error| (self.sets[0].kind, error.into()))?;
        }
        // Samples of the row above have seen all places around them.
        self.put_samples(row).map_err(|error| (self.sets[0].kind, error.into()))
    }

    /// The one height of a place.
    fn level(&self, (x, y): Spot, (lines, lakes): &Both) -> Result<f64, (LineKind, VerifyError)> {
        let order = |a: &&Owned, b: &&Owned| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        let all = || lines.iter().chain(lakes);
        let (Some(&(low, of_low)), Some(&(high, of_high))) = (all().min_by(order), all().max_by(order)) else {
            unreachable!("a place with a height");
        };
        let is_level = lakes.iter().all(|(height, _)| *height == lakes[0].0);
        if low != high && rational(high) - rational(low) > self.tolerance || !is_level {
            let (column, row) = (x as f64 / 4.0, y as f64 / 4.0);
            let (heights, features, kinds) = ([low, high], [of_low.1, of_high.1], [of_low.0, of_high.0]);
            return Err((kinds[0], VerifyError::TwoHeights { column, row, heights, features, kinds }));
        }
        Ok(lakes.first().map_or(low + (high - low) / 2.0, |lake| lake.0))
    }

    /// Puts a place away, and adds it to the samples no farther than a cell away, across and down.
    fn put(&mut self, (x, y): Spot, level: f64) -> Result<(), ScratchError> {
        let around = |quarters: i64, count: i64| {
            let first = (quarters - 4).div_euclid(4);
            (first..=first + 2).filter(move |at| (4 * at - quarters).abs() <= 4 && (0..count).contains(at))
        };
        for row in around(y, self.size.1) {
            for column in around(x, self.size.0) {
                let [low, high] = self.beside.entry((row, column)).or_insert([level; 2]);
                (*low, *high) = (low.min(level), high.max(level));
            }
        }
        self.places.push([word((x, y)), level.to_bits()])
    }

    /// Puts samples of the rows before one away.
    fn put_samples(&mut self, row: i64) -> Result<(), ScratchError> {
        let next = self.beside.split_off(&(row, i64::MIN));
        for ((row, column), [low, high]) in std::mem::replace(&mut self.beside, next) {
            self.samples.push([word((column, row)), low.to_bits(), high.to_bits()])?;
        }
        Ok(())
    }

    /// All of them, once all rows have been taken: places, and samples beside them.
    pub(super) fn finish(mut self) -> Result<(Rowed<2>, Rowed<3>), ScratchError> {
        self.put_samples(i64::MAX)?;
        self.places.finish()?;
        self.samples.finish()?;
        Ok((self.places, self.samples))
    }
}
