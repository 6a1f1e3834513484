//! Edges: matched, overused, folded.

use super::VerifyError;
use super::boundary::{BoundaryEdge, EDGE_WORDS};
use super::finding::{EdgePlace, Finding};
use super::grid::Grid;
use super::pace::Pace;
use super::rim;
use super::vertices::VertexStore;
use crate::base::external::{Scratch, Sorted, Sorter};

/// Bytes of the sort of edges that may be on the ground's boundary.
const BOUNDARY_BYTES: usize = 4 << 20;

/// How the faces hang together.
#[derive(Debug, Default)]
pub(super) struct EdgeFindings {
    pub(super) unmatched: Finding<EdgePlace>,
    pub(super) overused: Finding<EdgePlace>,
    pub(super) same_direction: Finding<EdgePlace>,
}

/// Matches the edges, sorted, of all faces: two faces share an edge in opposite directions, or it may lie on the ground's
/// boundary, or where the ground is trimmed, which is found out when the rows of the raster pass. Gives the latter by rows.
///
/// A T-junction shows as unmatched edges: the long one on one side, the short ones on the other.
pub(super) fn match_edges<'s>(
    edges: Sorted<'_, 3>,
    vertices: &mut VertexStore<'_>,
    grid: &Grid,
    trims: bool,
    scratch: &'s Scratch,
    pace: &mut Pace<'_>,
) -> Result<(EdgeFindings, Sorted<'s, EDGE_WORDS>), VerifyError> {
    let mut found = EdgeFindings::default();
    let mut boundary = Sorter::new(scratch, BOUNDARY_BYTES);
    let mut edges = edges.peekable();
    while let Some(first) = edges.next() {
        let [low, high, first] = first?;
        let mut uses = [0u64; 2];
        uses[(first & 1) as usize] += 1;
        pace.tick()?;
        while let Some(same) = edges.next_if(|e| !matches!(e, Ok([l, h, _]) if (*l, *h) != (low, high))) {
            uses[(same?[2] & 1) as usize] += 1;
            pace.tick()?;
        }
        if uses == [1, 1] {
            continue;
        }
        let (a, b) = ((low, vertices.get(low)?), (high, vertices.get(high)?));
        let place = || grid.edge(a, b);
        match uses[0] + uses[1] {
            1 => {
                // A face that is counter-clockwise on the map lies to the positive side of its edges in (column, row),
                // or, where the map mirrors, of the way back.
                let low_to_high = (uses == [1, 0]) == (grid.map_turn() > 0);
                let (from, to) = if low_to_high { (a, b) } else { (b, a) };
                let record = match trims {
                    true => rim::record(grid, from, to),
                    false => BoundaryEdge::new(grid, from, to).map(|edge| edge.words(false)),
                };
                match record {
                    Some(words) => boundary.push(words)?,
                    None => found.unmatched.add(place),
                }
            }
            2 => found.same_direction.add(place),
            _ => found.overused.add(place),
        }
    }
    Ok((found, boundary.finish()?))
}
