//! Breaklines: whether edges of the mesh follow them.
//!
//! What a line is on the lattice is reckoned here again from the layer, by code of its own: `places` cuts lines at rows and columns
//! and rounds, `noding` joins them, and `required` has the result. Then `edges` takes the edges of the mesh that may be along lines, and
//! `strips` holds them against lines a few rows at a time. `heights` reads the samples around them; a segment counts that lies in a cell
//! with four. `parts` makes *stretches* of segments, from where lines end or meet to where they do again; `joined` puts together those that
//! are in several strips. `follow` looks in each for a way of edges of the mesh from its first place to its last: between places of the
//! stretch, all those passed over within the shift, and the edge within the tolerance of the raster's bilinear surface at its ends and
//! where it crosses rows and columns (`wall`). Where lines have heights of their own (`levels`), the ends are held to these, and the edge
//! to those of all places that it passes over.
//!
//! Places are whole numbers of quarter cells and comparisons are exact. Memory is bounded, some 130 MiB at the most, but for outlines
//! that have an inside ([`RequiredLines`]); for lines that have more than 131,072 segments in a few rows, some 200 bytes for each; for
//! stretches, of which one is in memory as a whole, some 50 bytes for each segment; and for 16 bytes for each time that a line
//! passes from one strip to the next.

mod edges;
mod finder;
mod follow;
mod heights;
mod inside;
mod joined;
mod lakes;
mod levels;
mod noding;
mod outlines;
mod parts;
mod pieces;
mod places;
mod required;
mod rowed;
mod strips;
mod unbound;
mod wall;
mod words;

#[cfg(test)]
mod oracle;
#[cfg(test)]
mod tests;

use serde::Serialize;

use super::VerifyError;
use super::exact::rational;
use super::finding::{Finding, MapPlace, VertexPlace};
use super::grid::Grid;
use crate::base::Band;
use crate::base::control::CancelToken;
use crate::formats::MeshReader;
use edges::edges_beside;
use finder::Finder;
use joined::Parts;
use strips::Strips;

pub(super) use inside::Inside;
pub(super) use places::MAX_SEGMENTS;
pub use required::RequiredLines;
pub(super) use unbound::Unbound;
pub(super) use words::LONGEST;

/// A place in quarter cells: across, down.
pub(super) type Spot = (i64, i64);

/// What was found out about lines.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LinesVerdict {
    /// Segments of the lines between rows and columns, each once.
    pub segments: u64,
    /// Those that lie in no cell with four heights, or outside of the cutline that the mesh is to end at; nothing is asked of the mesh there.
    pub off_ground: u64,
    /// Stretches of lines between places where they end or meet.
    pub stretches: u64,
    /// Edges of the mesh that follow them: as few as are needed.
    pub edges: u64,
    /// Stretches that no edges follow within shift and tolerance.
    pub broken: Finding<StretchPlace>,
    /// Lakes.
    pub lakes: u64,
    /// Vertices in or on lakes that are not as high as the first of the lake, or farther than the tolerance from its height. Where there
    /// are none, and edges follow the outlines, lakes are level: no face crosses an outline.
    pub not_level: Finding<VertexPlace>,
}

impl std::fmt::Display for LinesVerdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let LinesVerdict { segments, off_ground, stretches, edges, .. } = self;
        write!(
            f,
            "breaklines: {segments} segments, {off_ground} off the ground; {edges} edges follow {stretches} stretches"
        )?;
        if self.lakes > 0 { write!(f, "; {} lakes", self.lakes) } else { Ok(()) }
    }
}

/// A stretch of a line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StretchPlace {
    /// Where it begins.
    pub from: MapPlace,
    /// The last place that edges reach.
    pub reached: MapPlace,
    /// Where it ends.
    pub to: MapPlace,
}

impl std::fmt::Display for StretchPlace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "from {} to {}, followed up to {}", self.from, self.to, self.reached)
    }
}

/// Judges whether edges of a mesh follow lines, within this distance of their own heights, or else of the raster's surface.
///
/// # Errors
/// [`VerifyError`]: the raster or the mesh cannot be read, lines are too far away or too many, or on cancellation.
pub fn verify_lines(
    raster: &Band,
    mesh: &mut dyn MeshReader,
    max_error: f64,
    lines: &RequiredLines,
    cancel: &CancelToken,
) -> Result<LinesVerdict, VerifyError> {
    let grid = Grid::of(raster, mesh);
    let mut levels =
        LakeLevels { lines, max_error, surfaces: vec![None; lines.shores.len()], found: Finding::default() };
    let see = |vertex, [x, y, z]: [f64; 3], spot| levels.see(spot, grid.frame.height(z), VertexPlace { vertex, x, y });
    let edges = edges_beside(mesh, (&grid, lines), see, lines.scratch(), cancel)?;
    let finder = Finder::new((&grid, lines), max_error);
    let strips = Strips::new((raster, lines), edges, (Parts::new(lines.scratch()), finder), cancel);
    let found = strips.pass()?;
    Ok(LinesVerdict {
        segments: lines.segment_count(),
        off_ground: found.off_ground,
        stretches: found.stretches,
        edges: found.edges,
        broken: found.broken,
        lakes: lines.shores.len() as u64,
        not_level: levels.found,
    })
}

/// Whether lakes are level.
struct LakeLevels<'a> {
    lines: &'a RequiredLines,
    max_error: f64,
    /// The height of the first vertex in each lake.
    surfaces: Vec<Option<f64>>,
    found: Finding<VertexPlace>,
}

impl LakeLevels<'_> {
    /// Judges a vertex.
    fn see(&mut self, spot: Spot, height: f64, vertex: VertexPlace) {
        for lake in self.lines.shores.at(spot) {
            let level = self.lines.shores.lake(lake).1;
            let is_first = *self.surfaces[lake].get_or_insert(height) == height;
            let is_near = height.is_finite() && {
                let (off, most) = (rational(height) - rational(level), rational(self.max_error));
                -&most <= off && off <= most
            };
            if !is_first || !is_near {
                return self.found.add(|| vertex);
            }
        }
    }
}
