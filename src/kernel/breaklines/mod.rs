//! Breaklines: lines that the mesh has as edges.
//!
//! In come lines in columns and rows with fractions; out come edges that a mesh must have, the *chain* of a line, and heights of
//! their ends. `places` cuts a line where it crosses rows and columns of samples and rounds each of these places to the lattice of
//! quarter cells; `noding` makes one plane graph of all lines, by iterated snap rounding (Halperin & Packer 2002). So far the lines
//! and the raster's size decide alone: [`Breaklines`]. `graph` says what of that lies on the ground and which places must be ends of
//! edges; between two of those `links` finds the fewest edges, by `wall` within the tolerance of the raster's surface and by
//! `obstacles` off all other lines; `reach` tells at once of many that they may be used. [`Chains`] has the edges of a whole raster, and lends those of a tile.
//!
//! What holds of the chain, and how `verify` judges it by code of its own: docs/breaklines.md.

mod chains;
mod graph;
mod links;
mod noding;
mod obstacles;
mod places;
mod reach;
mod wall;

#[cfg(test)]
mod constrained_tests;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::base::Polylines;

pub use chains::{ChainCounts, Chains, TileChains};
pub use graph::{Pieces, Surroundings, surroundings, tile_of};
pub use links::{Thinning, Untenable, thin};

/// A place on the lattice of quarter cells of a raster, by rows, then by columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place {
    /// Down, in quarter cells.
    pub y: i64,
    /// Across, in quarter cells.
    pub x: i64,
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
    /// Their segments on the lattice.
    pub segments: u64,
    /// The largest distance from a line to the place on the lattice that stands for it, before lines are joined to nodes, in cells.
    pub largest_rounding: f64,
}

/// Lines on the lattice of a raster: no two segments have more than an end in common, and no place is nearer to the midst of a
/// segment than half a step.
#[derive(Debug, Clone, PartialEq)]
pub struct Breaklines {
    segments: Arc<Vec<Segment>>,
    /// In parts of a cell ([`FINE`]).
    shift: i64,
    counts: LineCounts,
}

/// Why lines cannot be put on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum LinesError {
    /// They are too long in all.
    #[error("expected at most {} pieces of lines between rows and columns, found more", Polylines::MAX_SEGMENTS)]
    TooMany,
    /// A vertex is farther away than numbers go.
    #[error("expected lines near the raster, found a vertex at column {column}, row {row}")]
    TooFar {
        /// With fractions.
        column: f64,
        /// With fractions.
        row: f64,
    },
    /// The largest shift.
    #[error("expected a shift from 0 to {max} cells, found {0}", max = Polylines::MAX_SHIFT)]
    Shift(f64),
}

impl Breaklines {
    /// Lines over a raster of this many samples. Their chain may be `shift` cells from their places; parts of a cell below
    /// 1/65536 do not count.
    ///
    /// # Errors
    /// [`LinesError`].
    pub fn new(lines: &Polylines, size: (usize, usize), shift: f64) -> Result<Breaklines, LinesError> {
        if !(0.0..=Polylines::MAX_SHIFT).contains(&shift) {
            return Err(LinesError::Shift(shift));
        }
        let (segments, counts) = places::segments(lines, size)?;
        let segments = noding::node(segments);
        let counts = LineCounts { segments: segments.len() as u64, ..counts };
        Ok(Breaklines { segments: Arc::new(segments), shift: (shift * FINE as f64).floor() as i64, counts })
    }

    /// All segments, in their order, each once.
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// What became of the lines.
    pub fn counts(&self) -> LineCounts {
        self.counts
    }

    /// Whether nothing of them lies on the raster.
    pub fn is_empty(&self) -> bool {
        self.segments.is_empty()
    }

    /// The memory that they and their chains take.
    pub fn bytes(&self) -> u64 {
        const PER_SEGMENT: u64 = 256;
        self.segments.len() as u64 * PER_SEGMENT
    }

    /// What of them decides a mesh, the same on every machine.
    pub fn named(&self) -> String {
        let mut hasher = crc32fast::Hasher::new();
        let numbers = self.segments.iter().flatten().flat_map(|p| [p.x, p.y]);
        numbers.for_each(|number| hasher.update(&number.to_le_bytes()));
        format!("{} segments with checksum {:08x}, shift {}/{FINE}", self.segments.len(), hasher.finalize(), self.shift)
    }
}
