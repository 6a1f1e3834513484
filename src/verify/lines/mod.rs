//! Breaklines: whether edges of the mesh follow them.
//!
//! What a line is on the lattice is reckoned here again from the layer, by code of its own: `places` cuts lines at rows and columns
//! and rounds, `noding` joins them. `heights` reads the samples around them; a segment counts that lies in a cell with four. `graph`
//! then makes *stretches* of them, from where lines end or meet to where they do again, and `follow` looks in each for a way of
//! edges of the mesh from its first place to its last: between places of the stretch, all those passed over within the shift, and the
//! edge within the tolerance of the raster's bilinear surface at its ends and where it crosses rows and columns. Where lines have
//! heights of their own (`required`), the ends are held to these, and the edge to those of all places that it passes over.
//!
//! Places are whole numbers of quarter cells and comparisons are exact. Memory: some 400 bytes for each segment of the lines.

mod follow;
mod graph;
mod heights;
mod inside;
mod lakes;
mod noding;
mod pieces;
mod places;
mod required;
mod unbound;

#[cfg(test)]
mod tests;

use std::collections::HashMap;

use serde::Serialize;

use super::VerifyError;
use super::exact::rational;
use super::finding::{Finding, MapPlace, VertexPlace};
use super::grid::Grid;
use crate::base::Band;
use crate::base::control::CancelToken;
use crate::formats::MeshReader;
use follow::Wall;
use graph::stretches;
use heights::Samples;

pub(super) use inside::Inside;
pub(super) use places::MAX_SEGMENTS;
pub use required::RequiredLines;
pub(super) use unbound::Unbound;

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
    let segments: Vec<[Spot; 2]> = lines.segments.iter().map(|(segment, _)| *segment).collect();
    let mut spots: Vec<Spot> = segments.iter().flatten().copied().collect();
    spots.sort_unstable();
    spots.dedup();
    let number = |spot: Spot| spots.binary_search(&spot).ok().map(|i| i as u32);

    let mut heights = vec![None; spots.len()];
    let mut vertices = HashMap::new();
    let mut not_level = Finding::default();
    let mut surfaces = vec![None; lines.shores.len()];
    mesh.for_each_vertex(|vertex, [x, y, z]| {
        cancel.check()?;
        for lake in grid.lattice(x, y).into_iter().flat_map(|spot| lines.shores.at(spot)) {
            let (height, level) = (grid.frame.height(z), lines.shores.lake(lake).1);
            let is_first = *surfaces[lake].get_or_insert(height) == height;
            let is_near = height.is_finite() && {
                let (off, most) = (rational(height) - rational(level), rational(max_error));
                -&most <= off && off <= most
            };
            if !is_first || !is_near {
                not_level.add(|| VertexPlace { vertex, x, y });
                break;
            }
        }
        if let Some(spot) = grid.lattice(x, y).and_then(number) {
            heights[spot as usize] = Some(grid.frame.height(z)).filter(|z| z.is_finite());
            vertices.insert(vertex, spot);
        }
        Ok::<(), VerifyError>(())
    })?;
    let mut edges = Vec::new();
    mesh.for_each_face(|_, corners| {
        let on_lines = corners.map(|corner| vertices.get(&corner).copied());
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if let (Some(a), Some(b)) = (on_lines[a], on_lines[b]) {
                edges.push((a.min(b), a.max(b)));
            }
        }
        cancel.check().map_err(VerifyError::from)
    })?;
    drop(vertices);
    edges.sort_unstable();
    edges.dedup();

    let at = |i: u32| spots[i as usize];
    let samples = Samples::read(raster, &segments, edges.iter().map(|&(a, b)| [at(a), at(b)]), cancel)?;
    let is_ground = |segment: [Spot; 2]| samples.has_cell(segment, |cell| lines.asks(segment, cell));
    let on_ground: Vec<_> = lines.segments.iter().filter(|(segment, _)| is_ground(*segment)).collect();
    let mut beside: HashMap<Spot, Vec<Spot>> = HashMap::new();
    for &(a, b) in &edges {
        beside.entry(at(a)).or_default().push(at(b));
        beside.entry(at(b)).or_default().push(at(a));
    }
    let height = |spot: Spot| number(spot).and_then(|i| heights[i as usize]);
    let wall = Wall { samples: &samples, tolerance: max_error, lines, height: &height };
    let mut verdict = LinesVerdict {
        segments: segments.len() as u64,
        off_ground: (segments.len() - on_ground.len()) as u64,
        stretches: 0,
        edges: 0,
        broken: Finding::default(),
        lakes: lines.shores.len() as u64,
        not_level,
    };
    for (stretch, sets) in stretches(on_ground.into_iter()) {
        cancel.check()?;
        verdict.stretches += 1;
        match wall.follow(&stretch, sets, &beside) {
            Ok(edges) => verdict.edges += edges,
            Err(reached) => verdict.broken.add(|| StretchPlace {
                from: grid.map(stretch[0]),
                reached: grid.map(stretch[reached]),
                to: grid.map(stretch[stretch.len() - 1]),
            }),
        }
    }
    Ok(verdict)
}
