//! Breaklines: lines that the mesh has as edges.
//!
//! In come lines in columns and rows with fractions; out come edges that a mesh must have, the *chain* of a line, and heights of
//! their ends. `places` cuts a line where it crosses rows and columns of samples and rounds each of these places to the lattice of
//! quarter cells; `noding` makes one plane graph of all lines, by iterated snap rounding (Halperin & Packer 2002). So far the lines
//! and the raster's size decide alone: [`Breaklines`]. `graph` says what of that lies on the ground and which places must be ends of
//! edges; between two of those `links` finds the fewest edges, by `wall` within the tolerance of the raster's surface and by
//! `obstacles` off all other lines; `reach` tells at once of many that they may be used. [`Chains`] has the edges of some tiles, and
//! [`TileChains`] those that lie in one. Where lines have heights of their own (`levels`), samples beside them are eased (`beside`): the surface may be
//! anywhere between the sample and the line. `unbound` says where edges are too near for a limit on straying. Outlines that the mesh
//! ends at bound an `inside`: lines outside of it ask for nothing.
//!
//! What holds of the chain, and how `verify` judges it by code of its own: docs/breaklines.md.

mod beside;
mod chains;
mod graph;
mod inside;
mod lakes;
mod levels;
mod links;
mod noding;
mod obstacles;
mod outlines;
mod pieces;
mod places;
mod reach;
pub(crate) mod strips;
mod unbound;
mod wall;

#[cfg(test)]
mod constrained_tests;
#[cfg(test)]
mod inside_tests;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use self::beside::Beside;
use self::levels::Levels;
use self::outlines::{take_inside, take_lakes};
use crate::base::features::FeatureSet;
use crate::base::lattice::STEPS;
use crate::base::plainly::Plainly;
use crate::base::{LineKind, LineSet, LineType, PointSet, Polylines, Tile, Window};

pub(crate) use chains::type_of;
pub use chains::{ChainCounts, Chains, End, PlacedEdge, TileChains};
pub use graph::{Pieces, Stretch, Surroundings, surroundings, tile_of};
pub(crate) use inside::Inside;
pub use levels::TwoHeights;
pub use links::{ChainEdge, Thinning, Untenable, thin};

/// A place on the lattice of quarter cells of a raster, by rows, then by columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// Down, in quarter cells.
    pub y: i64,
    /// Across, in quarter cells.
    pub x: i64,
}

impl Place {
    /// Column and row, with fractions.
    fn cells(self) -> (f64, f64) {
        let cells = |along: i64| along as f64 / f64::from(STEPS);
        (cells(self.x), cells(self.y))
    }
}

/// A piece of a line between two places of one closed cell, the lower place first.
pub type Segment = [Place; 2];

/// Parts of a cell that lines are read in: vertices are rounded to these, and the largest shift is a number of these.
pub const FINE: i64 = 1 << 16;

/// What became of lines.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct LineCounts {
    /// Lines in the layer.
    pub lines: u64,
    /// Those of which nothing lies on the raster: outside of it, or without a length on the lattice.
    pub left_out: u64,
    /// Their segments on the lattice; those that lines of several sets of a kind share count in the first.
    pub segments: u64,
    /// The largest distance from a line to the place on the lattice that stands for it, before lines are joined to nodes, in cells.
    pub largest_rounding: f64,
}

/// Lines on the lattice of a raster: no two segments have more than an end in common, and no place is nearer to the midst of a
/// segment than half a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Breaklines {
    segments: Arc<Vec<Segment>>,
    /// The sets that each is of, as bits.
    of: Arc<Vec<SetBits>>,
    sets: Vec<Set>,
    levels: Arc<Levels>,
    beside: Arc<Beside>,
    /// Where the mesh is to be, if that is not all of the ground.
    inside: Option<Arc<Inside>>,
}

/// Sets of lines by their numbers, as bits.
pub type SetBits = u8;

/// What is known of a set of lines.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Set {
    kind: LineKind,
    line_type: LineType,
    /// In parts of a cell ([`FINE`]).
    shift: i64,
    has_heights: bool,
    counts: LineCounts,
}

impl Set {
    /// Of lines of which nothing is known yet.
    fn new(set: &LineSet) -> Result<Set, LinesError> {
        if !(0.0..=Polylines::MAX_SHIFT).contains(&set.shift) {
            return Err(LinesError::Shift(set.shift));
        }
        let (kind, has_heights) = (set.kind, set.lines.have_heights());
        let counts = LineCounts { lines: set.lines.count() as u64, ..LineCounts::default() };
        let line_type = set.lines.line_type();
        Ok(Set { kind, line_type, shift: (set.shift * FINE as f64).floor() as i64, has_heights, counts })
    }
}

/// Why lines cannot be put on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LinesError {
    /// They are too long in all.
    #[error("expected at most {} pieces of lines between rows and columns, found more", Polylines::MAX_SEGMENTS)]
    TooMany,
    /// A vertex is farther away than numbers go.
    #[error("expected lines near the raster, found a vertex at column {}, row {}", Plainly(*column), Plainly(*row))]
    TooFar {
        /// With fractions.
        column: f64,
        /// With fractions.
        row: f64,
    },
    /// The largest shift.
    #[error("expected a shift from 0 to {max} cells, found {0}", max = Polylines::MAX_SHIFT)]
    Shift(f64),
    /// A height of a line's own is none.
    #[error("expected heights of lines from -1e30 to 1e30, found {} in feature {feature}", Plainly(*height))]
    Height {
        /// The feature.
        feature: u64,
        /// What it has.
        height: f64,
    },
    /// Two lakes have ground in common.
    #[error("expected lakes apart from each other, found features {} and {} that overlap", features[0], features[1])]
    Overlap {
        /// Theirs.
        features: [u64; 2],
    },
}

impl Breaklines {
    /// Lines over a raster of this many samples, eight sets at the most. Their chains may be a set's shift from their places;
    /// parts of a cell below 1/65536 do not count.
    ///
    /// # Errors
    /// The kind of the lines, and [`LinesError`].
    pub fn new(asked: &[LineSet], size: (usize, usize)) -> Result<Breaklines, (LineKind, LinesError)> {
        let (pieces, sets) = cut(asked, size)?;
        Breaklines::of_pieces(pieces, sets, asked, size)
    }

    /// Of pieces that are not noded.
    fn of_pieces(
        pieces: Vec<pieces::Piece>,
        mut sets: Vec<Set>,
        asked: &[LineSet],
        size: (usize, usize),
    ) -> Result<Breaklines, (LineKind, LinesError)> {
        let mut pieces = noding::node(pieces);
        let lakes = take_lakes(asked, &mut pieces).map_err(|error| (LineKind::Lakes, error))?;
        let inside = take_inside(asked, &mut pieces, size).map(Arc::new);
        let (segments, of) = noding::with_sets(&pieces);
        of.iter().for_each(|bits| count(*bits, &mut sets));
        let levels = Levels::new(&pieces, &lakes, |piece| {
            let set = &asked[usize::from(piece.set)];
            let has_heights = sets[usize::from(piece.set)].has_heights;
            has_heights.then(|| (set.kind, set.lines.feature(piece.line as usize)))
        });
        let beside = Beside::of_lines(&levels, lakes, (&segments, &of), &sets, size);
        let (segments, of, levels, beside) = (Arc::new(segments), Arc::new(of), Arc::new(levels), Arc::new(beside));
        Ok(Breaklines { segments, of, sets, levels, beside, inside })
    }

    /// All segments, in their order, each once.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// What kinds of lines there are, and what became of those of each.
    pub fn counts(&self) -> impl Iterator<Item = (LineKind, LineCounts)> {
        self.sets.iter().map(|set| (set.kind, set.counts))
    }

    /// What they ask of a run.
    pub fn features(&self) -> FeatureSet {
        LineSet::features(self.sets.iter().map(|set| (set.kind, set.has_heights)))
    }

    /// Whether lines have heights of their own.
    pub fn have_heights(&self) -> bool {
        self.sets.iter().any(|set| set.has_heights)
    }

    /// The height of lines' own at a place, if a line with heights has it.
    pub fn height_at(&self, place: Place) -> Option<f64> {
        self.levels.at(place)
    }

    /// The least and the largest of those heights; `None` where there are none.
    pub fn height_range(&self) -> Option<[f64; 2]> {
        self.levels.range()
    }

    /// The sets that a segment is of.
    pub fn sets_of(&self, segment: Segment) -> SetBits {
        self.segments.binary_search(&segment).map_or(0, |i| self.of[i])
    }

    /// The segments whose lower place is in some rows of the lattice.
    pub fn segments_in(&self, rows: std::ops::Range<i64>) -> &[Segment] {
        let before = |row: i64| self.segments.partition_point(|[low, _]| low.y < row);
        &self.segments[before(rows.start)..before(rows.end)]
    }

    /// Which sets count what these have in common: the first of each kind.
    pub fn counting(&self, bits: SetBits) -> SetBits {
        counting(bits, &self.sets)
    }

    /// The sets whose lines are soft.
    pub fn soft_sets(&self) -> SetBits {
        let bits = (0..).zip(&self.sets).map(|(number, set)| u8::from(set.line_type == LineType::Soft) << number);
        bits.fold(0, |all, bit| all | bit)
    }

    /// How many sets of lines there are.
    pub fn set_count(&self) -> usize {
        self.sets.len()
    }

    /// Makes sure that lines which have a place in common have heights there that are within the tolerance of each other.
    ///
    /// # Errors
    /// [`TwoHeights`].
    pub fn check_heights(&self, tolerance: f64) -> Result<(), TwoHeights> {
        self.levels.check(tolerance)
    }

    /// Eases the samples of a tile that are beside lines with heights of their own, so that engines may keep to the lines. `points`
    /// are vertices and keep their heights.
    pub fn ease(&self, tile: &mut Tile, window: Window, points: Option<&PointSet>, tolerance: f64) {
        if self.have_heights() {
            self.beside.ease(tile, window, points, tolerance);
        }
    }

    /// Marks the cells of a tile that are so near to lines that nothing limits there how far the surface strays between samples.
    pub fn unbind(&self, tile: &mut Tile, window: Window) {
        unbound::mark(tile, window, &self.segments, self.unbound_cells());
    }

    /// How many cells around those that lines run in are unbound: as many as edges may be from lines; at the least one where samples
    /// beside lines are eased.
    fn unbound_cells(&self) -> i64 {
        let cells = self.sets.iter().map(|set| ((set.shift + FINE - 1) / FINE).max(i64::from(set.has_heights)));
        cells.max().unwrap_or(0)
    }

    /// Where the mesh is to be, if that is not all of the ground.
    pub(crate) fn inside(&self) -> Option<&Arc<Inside>> {
        self.inside.as_ref()
    }

    /// The share of a raster that the mesh is to cover, where there are outlines that it ends at.
    pub(crate) fn share_inside(&self) -> Option<f64> {
        self.inside.as_ref().map(|inside| inside.share())
    }

    /// Whether there are outlines that the mesh ends at, and nothing is inside of them.
    pub fn leave_nothing(&self) -> bool {
        self.inside.as_ref().is_some_and(|inside| inside.is_empty())
    }

    /// Takes the ground of a tile away that is outside of the outlines that the mesh ends at, but for what is next to them.
    pub fn cut(&self, tile: &mut Tile, window: Window) {
        if let Some(inside) = &self.inside {
            inside.cut(tile, window);
        }
    }

    /// What the way from one end of a segment to the other has to its left ([`crate::base::lattice::orient`] > 0): `None` where the segment is
    /// not on the border of the inside.
    fn has_inside_to_left(&self, [from, to]: [Place; 2]) -> Option<bool> {
        let [a, b] = [from.min(to), from.max(to)];
        let side = self.inside.as_ref()?.side([a, b])?;
        // On the way down that is what has smaller columns, on the way to the right what has larger rows.
        let is_left_of_way = (side == 0) == (a.y < b.y);
        Some(is_left_of_way == (from == a))
    }

    /// How far edges may be from the places of all of these sets, in parts of a cell.
    fn shift_of(&self, bits: SetBits) -> i64 {
        let shifts = (0..).zip(&self.sets).filter(|(number, _)| bits & 1 << number != 0).map(|(_, set)| set.shift);
        shifts.min().unwrap_or(0)
    }

    /// Whether one of these sets has heights of its own.
    fn has_own(&self, bits: SetBits) -> bool {
        (0..).zip(&self.sets).any(|(number, set)| bits & 1 << number != 0 && set.has_heights)
    }

    /// How many samples lie in lakes, those without a height among them.
    pub fn in_lakes(&self) -> u64 {
        self.beside.in_lakes()
    }

    /// The memory that they and their chains take.
    pub fn bytes(&self) -> u64 {
        const PER_SEGMENT: u64 = 320;
        let inside = self.inside.as_ref().map_or(0, |inside| inside.bytes());
        self.segments.len() as u64 * PER_SEGMENT + self.levels.bytes() + self.beside.bytes() + inside
    }

    /// What of them decides a mesh, the same on every machine: what sets there are, and what is in them.
    pub fn named(&self) -> [String; 2] {
        let mut hasher = crc32fast::Hasher::new();
        self.segments.iter().flatten().for_each(|place| hash_place(&mut hasher, *place));
        self.of.iter().for_each(|bits| hasher.update(&[*bits]));
        self.levels.hash(&mut hasher);
        self.named_as(self.segments.len() as u64, hasher.finalize())
    }

    fn named_as(&self, segments: u64, checksum: u32) -> [String; 2] {
        let named = |set: &Set| {
            let soft = if set.line_type == LineType::Soft { "soft " } else { "" };
            format!("{soft}{} with shift {}/{FINE}", set.kind.name(), set.shift)
        };
        let sets: Vec<String> = self.sets.iter().map(named).collect();
        [sets.join(", "), format!("{segments} with checksum {checksum:08x}")]
    }
}

/// Of sets that have something in common, the first of each kind.
fn counting(bits: SetBits, sets: &[Set]) -> SetBits {
    let has = |number: usize| bits >> number & 1 == 1;
    let is_first = |&number: &usize| has(number) && !(0..number).any(|i| has(i) && sets[i].kind == sets[number].kind);
    (0..sets.len()).filter(is_first).fold(0, |all, number| all | 1 << number)
}

/// Counts a segment of these sets.
fn count(bits: SetBits, sets: &mut [Set]) {
    let first = counting(bits, sets);
    (0..).zip(sets).for_each(|(number, set)| set.counts.segments += u64::from(first >> number & 1));
}

/// The pieces of all sets, in no order.
fn cut(asked: &[LineSet], size: (usize, usize)) -> Result<(Vec<pieces::Piece>, Vec<Set>), (LineKind, LinesError)> {
    let (mut pieces, mut sets) = (Vec::new(), Vec::new());
    for (number, set) in (0..).zip(asked) {
        let mut found = Set::new(set).map_err(|error| (set.kind, error))?;
        let feature = |line: usize| set.lines.feature(line);
        let mut take = |more: &mut Vec<_>| {
            pieces.append(more);
            if pieces.len() > Polylines::MAX_SEGMENTS { Err(LinesError::TooMany) } else { Ok(()) }
        };
        places::cut((number, set.kind), &set.lines, (0, &feature), size, &mut found.counts, &mut take)
            .map_err(|error| (set.kind, error))?;
        sets.push(found);
    }
    Ok((pieces, sets))
}

fn hash_place(hasher: &mut crc32fast::Hasher, place: Place) {
    [place.x, place.y].into_iter().for_each(|number| hasher.update(&number.to_le_bytes()));
}
