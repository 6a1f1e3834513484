//! What lines ask of a mesh: their segments, and their heights.

use std::ops::Range;
use std::path::Path;

use super::inside::Inside;
use super::lakes::Shores;
use super::levels::Levels;
use super::noding::{ByRow, noded};
use super::outlines::Outlines;
use super::pieces::Piece;
use super::rowed::Rowed;
use super::words::{self, ROW_OF_PLACE, spot, word};
use super::{Spot, places};
use crate::base::control::CancelToken;
use crate::base::external::{Scratch, ScratchError, Sorter};
use crate::base::features::FeatureSet;
use crate::base::{LineKind, LineSet};
use crate::verify::VerifyError;

/// Sets of lines by their numbers, as bits.
pub(super) type SetBits = u16;

/// A segment, its first place by rows first, and the sets that it is of.
pub(super) type Segment = ([Spot; 2], SetBits);

/// Bytes of the sort of pieces; tests go to the file.
const PIECE_BYTES: usize = if cfg!(test) { 1 << 10 } else { 16 << 20 };

/// All lines that a mesh is to have as edges, on the lattice of the raster.
///
/// Memory: 16 MiB, or 24 where lines have heights; more is in temporary files, some 130 bytes for each segment while they are joined, then 16.
/// Outlines that have an inside take some 250 bytes of memory for each of their segments.
#[derive(Debug)]
pub struct RequiredLines {
    pub(super) sets: Vec<Set>,
    features: FeatureSet,
    /// Each once: its first place, and how far it is to the other, with the sets that it is of.
    segments: Rowed<2>,
    /// Sets that have any.
    with_segments: SetBits,
    /// Heights of lines' own, by place.
    levels: Rowed<2>,
    /// Samples beside lines with heights, with the least and the largest of these heights.
    near: Rowed<3>,
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
    /// Lines over a raster of this many samples, at the tolerance that the mesh is judged by: lines that meet have one height there, within
    /// it. Temporary files are made in a folder, or else in the system's place for them.
    ///
    /// # Errors
    /// The kind of the lines, and [`VerifyError`]: they are too far away or too many, or have two heights at a place; temporary files
    /// fail, or the caller asked to stop.
    pub fn new(
        sets: &[LineSet],
        (width, height): (usize, usize),
        tolerance: f64,
        temp_dir: Option<&Path>,
        cancel: &CancelToken,
    ) -> Result<RequiredLines, (LineKind, VerifyError)> {
        let scratch = Scratch::new(temp_dir, cancel.clone());
        let size = (width as i64, height as i64);
        let first_kind = sets.first().map_or(LineKind::Breaklines, |set| set.kind);
        let of_all = |error: ScratchError| (first_kind, VerifyError::from(error));
        words::check(size).map_err(|error| (first_kind, error))?;
        let mut sorter = Sorter::new(&scratch, PIECE_BYTES);
        for (number, set) in sets.iter().enumerate() {
            let mut take = |piece: Piece| Ok(sorter.push(piece.record(1))?);
            places::cut((number, set), size, &mut take).map_err(|error| (set.kind, error))?;
        }
        let noded = noded(sorter.finish().map_err(of_all)?, size.1, &scratch).map_err(of_all)?;
        let (outlines, noded) = Outlines::of(noded, sets, &scratch).map_err(of_all)?;
        let shores = outlines.shores(sets).map_err(|error| (LineKind::Lakes, error))?;
        let inside = outlines.inside(sets, size);
        // What is inside of a cutline bounds nothing, nor does the raster's rim.
        let bounds = |piece: &Piece| {
            let is_border = || inside.as_ref().is_none_or(|inside| inside.is_border(piece.ends));
            outlines.have(piece) && (sets[piece.set].kind != LineKind::Cutline || is_border())
        };
        let mut segments = Rowed::new(&scratch, ROW_OF_PLACE);
        let mut levels = Levels::new((sets, &shores), tolerance, size, &scratch);
        let mut by_row = ByRow::new(noded.into_records());
        let mut with_segments = 0;
        for row in 0..size.1 {
            let mut pieces = by_row.pieces(row).map_err(of_all)?;
            pieces.retain(|(piece, _)| bounds(piece));
            for of in pieces.chunk_by(|a, b| a.0.ends == b.0.ends) {
                let bits = of.iter().fold(0, |bits, (piece, _)| bits | 1 << piece.set);
                with_segments |= bits;
                segments.push(record((of[0].0.ends, bits))).map_err(of_all)?;
            }
            levels.take(row, &pieces)?;
        }
        segments.finish().map_err(of_all)?;
        let (levels, near) = levels.finish().map_err(of_all)?;
        let features = LineSet::features(sets.iter().map(|set| (set.kind, set.lines.have_heights())));
        let sets = sets.iter().map(|set| Set { shift: set.shift, has_heights: set.lines.have_heights() });
        Ok(RequiredLines { sets: sets.collect(), features, segments, with_segments, levels, near, shores, inside })
    }

    /// Whether lines of a set, by its number, have a length on the lattice of the raster.
    pub fn has_segments(&self, set: usize) -> bool {
        self.with_segments & 1 << set != 0
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
        self.levels.count() > 0
    }

    /// The samples of some rows that are in lakes: row, columns, height. Some may be there twice.
    pub(in crate::verify) fn flooded(&self, rows: Range<i64>) -> impl Iterator<Item = (i64, Range<i64>, f64)> {
        self.shores.samples(rows)
    }

    /// The samples of some rows that are beside lines with heights: row, column, and the least and the largest of these.
    pub(in crate::verify) fn near(
        &self,
        rows: Range<i64>,
    ) -> Result<impl Iterator<Item = ((i64, i64), [f64; 2])> + use<>, ScratchError> {
        let of = |[sample, low, high]: [u64; 3]| {
            let (column, row) = spot(sample);
            ((row, column), [low, high].map(f64::from_bits))
        };
        Ok(self.near.of(rows)?.into_iter().map(of))
    }

    /// How many segments there are.
    pub(super) fn segment_count(&self) -> u64 {
        self.segments.count()
    }

    /// The segments whose first places are in some rows of cells.
    pub(super) fn segments(&self, rows: Range<i64>) -> Result<impl Iterator<Item = Segment> + use<>, ScratchError> {
        Ok(self.segments.of(rows)?.into_iter().map(segment))
    }

    /// Rows of cells from the first of some on, so few that they have no more than a number of segments, or else a few.
    pub(super) fn strip(&self, rows: Range<i64>, most: usize) -> Range<i64> {
        self.segments.some(rows, most)
    }

    /// The heights at places of lines in some rows of cells, by place.
    pub(super) fn levels(&self, rows: Range<i64>) -> Result<Vec<(u64, f64)>, ScratchError> {
        Ok(self.levels.of(rows)?.into_iter().map(|[place, height]| (place, f64::from_bits(height))).collect())
    }

    /// Where temporary files are made.
    pub(super) fn scratch(&self) -> &Scratch {
        self.segments.scratch()
    }
}

/// Bits for the sets of a segment.
const SETS: u32 = SetBits::BITS;

fn record(([a, b], sets): Segment) -> [u64; 2] {
    [word(a), (word(b) - word(a)) << SETS | u64::from(sets)]
}

fn segment([first, other]: [u64; 2]) -> Segment {
    ([spot(first), spot(first + (other >> SETS))], other as SetBits)
}
