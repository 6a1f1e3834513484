//! Lines that become edges of the mesh: in memory, or beside it where there are many.

mod error;
mod shelved;

#[cfg(test)]
pub(super) mod tests;

use std::ops::Range;
use std::sync::Arc;

use crate::base::external::{Scratch, ScratchError};
use crate::base::features::FeatureSet;
use crate::base::lattice::STEPS;
use crate::base::tiling::TileGrid;
use crate::base::{LineKind, LineSet, Polylines, Window};
use crate::kernel::breaklines::strips::{Cutting, LONGEST, PieceRecord, Summary};
use crate::kernel::breaklines::{Breaklines, Inside, LineCounts, LinesError, SetBits, TwoHeights};
use shelved::{Shelved, Sorting};

pub(crate) use error::LinesFailure;

/// How far around a window segments decide what is in it, in cells: unbound cells and samples beside lines.
const AROUND: usize = Polylines::MAX_SHIFT as usize + 4;

/// The lines of a run, on the lattice.
#[derive(Debug)]
pub struct Lines(Held);

#[derive(Debug)]
enum Held {
    Memory(Arc<Breaklines>),
    Shelved(Box<Shelved>, Summary),
}

impl From<Breaklines> for Lines {
    fn from(lines: Breaklines) -> Lines {
        Lines(Held::Memory(Arc::new(lines)))
    }
}

impl Lines {
    /// The most segments that are held in memory, but for what bounds an inside: lines with lakes or a cutline are always in memory.
    pub(crate) const IN_MEMORY: usize = 1 << 20;

    /// Lines over a raster of this many samples. More segments than `in_memory` go to temporary files.
    ///
    /// # Errors
    /// [`LinesFailure`].
    pub(crate) fn new(
        asked: &[LineSet],
        size: (usize, usize),
        scratch: Scratch,
        in_memory: usize,
    ) -> Result<Lines, LinesFailure> {
        let has_inside = asked.iter().any(|set| set.kind.has_inside());
        let is_bound = has_inside || size.0.max(size.1) > LONGEST;
        let most = if is_bound { Polylines::MAX_SEGMENTS } else { in_memory };
        let mut cutting = Cutting::new();
        let (mut pieces, mut sorting): (Vec<PieceRecord>, Option<Sorting>) = (Vec::new(), None);
        for set in asked {
            let of_kind = |error| LinesFailure::Lattice(set.kind, error);
            cutting.begin(set).map_err(of_kind)?;
            let mut take = |piece: PieceRecord| {
                if let Some(sorting) = &mut sorting {
                    return Ok(sorting.push(piece)?);
                }
                pieces.push(piece);
                if pieces.len() > most {
                    if is_bound {
                        return Err(Stopped::Lattice(LinesError::TooMany));
                    }
                    let begun = sorting.insert(Sorting::new(&scratch));
                    std::mem::take(&mut pieces).into_iter().try_for_each(|piece| begun.push(piece))?;
                }
                Ok(())
            };
            let feature = |line: usize| set.lines.feature(line);
            for some in set.lines.pieces() {
                let (first, lines) = some?;
                cutting.cut(&lines, (first, &feature), size, &mut take).map_err(|stopped| match stopped {
                    Stopped::Lattice(error) => of_kind(error),
                    Stopped::Scratch(error) => error.into(),
                })?;
            }
        }
        let held = match sorting {
            None => {
                let lines = cutting.in_memory(pieces, asked, size);
                Held::Memory(Arc::new(lines.map_err(|(kind, error)| LinesFailure::Lattice(kind, error))?))
            }
            Some(sorting) => {
                let (shelved, told) = sorting.finish(cutting.finish(asked, size), size)?;
                Held::Shelved(Box::new(shelved), told)
            }
        };
        Ok(Lines(held))
    }

    /// All of what is known of them, but for segments and heights where these are elsewhere.
    fn told(&self) -> &Breaklines {
        match &self.0 {
            Held::Memory(lines) => lines,
            Held::Shelved(_, summary) => &summary.lines,
        }
    }

    /// See [`Breaklines::counts`].
    pub fn counts(&self) -> impl Iterator<Item = (LineKind, LineCounts)> {
        self.told().counts()
    }

    /// How many sets of lines there are.
    pub(super) fn set_count(&self) -> usize {
        self.told().set_count()
    }

    /// See [`Breaklines::counting`].
    pub(super) fn counting(&self, bits: SetBits) -> SetBits {
        self.told().counting(bits)
    }

    /// The sets whose lines are soft.
    pub(super) fn soft_sets(&self) -> SetBits {
        self.told().soft_sets()
    }

    /// What they ask of a run.
    pub fn features(&self) -> FeatureSet {
        self.told().features()
    }

    /// Whether lines have heights of their own.
    pub fn have_heights(&self) -> bool {
        self.told().have_heights()
    }

    /// See [`Breaklines::height_range`].
    pub fn height_range(&self) -> Option<[f64; 2]> {
        match &self.0 {
            Held::Memory(lines) => lines.height_range(),
            Held::Shelved(_, summary) => summary.range,
        }
    }

    /// Makes sure that lines which have a place in common have heights there that are within the tolerance of each other.
    ///
    /// # Errors
    /// [`TwoHeights`].
    pub fn check_heights(&self, tolerance: f64) -> Result<(), TwoHeights> {
        self.told().check_heights(tolerance)
    }

    /// Where the mesh is to be, if that is not all of the ground.
    pub(super) fn inside(&self) -> Option<&Arc<Inside>> {
        self.told().inside()
    }

    /// See [`Breaklines::leave_nothing`].
    pub fn leave_nothing(&self) -> bool {
        self.told().leave_nothing()
    }

    /// The share of a raster that the mesh is to cover, where there are outlines that it ends at.
    pub(super) fn share_inside(&self) -> Option<f64> {
        self.told().share_inside()
    }

    /// How many samples lie in lakes, those without a height among them.
    pub fn in_lakes(&self) -> u64 {
        self.told().in_lakes()
    }

    /// What of them decides a mesh, the same on every machine and wherever they are held: see [`Breaklines::named`].
    pub fn named(&self) -> [String; 2] {
        match &self.0 {
            Held::Memory(lines) => lines.named(),
            Held::Shelved(_, summary) => summary.named.clone(),
        }
    }

    /// The memory that they and their chains take in a run over the tiles of a grid.
    pub fn bytes(&self, grid: &TileGrid) -> u64 {
        match &self.0 {
            Held::Memory(lines) => lines.bytes(),
            Held::Shelved(shelved, _) => shelved.bytes(grid),
        }
    }

    /// Lines that are the same in a window, and in what is beside it: those near to it at the least.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(super) fn near(&self, window: Window) -> Result<Arc<Breaklines>, ScratchError> {
        match &self.0 {
            Held::Memory(lines) => Ok(lines.clone()),
            Held::Shelved(shelved, _) => {
                let steps = |from: usize, count: usize| {
                    let (first, after) = (from.saturating_sub(AROUND), from + count + AROUND);
                    first as i64 * i64::from(STEPS)..after as i64 * i64::from(STEPS)
                };
                shelved.lines(steps(window.row, window.height), steps(window.column, window.width))
            }
        }
    }

    /// Lines that are the same in rows of the lattice, and in the cells beside them.
    ///
    /// # Errors
    /// [`ScratchError`].
    pub(super) fn in_rows(&self, rows: &Range<i64>) -> Result<Arc<Breaklines>, ScratchError> {
        match &self.0 {
            Held::Memory(lines) => Ok(lines.clone()),
            Held::Shelved(shelved, _) => {
                let around = (AROUND as i64) * i64::from(STEPS);
                shelved.lines((rows.start - around).max(0)..rows.end.saturating_add(around), 0..i64::MAX)
            }
        }
    }
}

/// Why cutting stopped.
enum Stopped {
    Lattice(LinesError),
    Scratch(ScratchError),
}

impl From<LinesError> for Stopped {
    fn from(error: LinesError) -> Stopped {
        Stopped::Lattice(error)
    }
}

impl From<ScratchError> for Stopped {
    fn from(error: ScratchError) -> Stopped {
        Stopped::Scratch(error)
    }
}
